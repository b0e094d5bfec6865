/* SPDX-License-Identifier: MIT
 *
 * main.c - phongsplat-viewer: shows Phong splats in a window. Arguments and the loop.
 *
 *     phongsplat-viewer [options] [A.glb ...]
 */
#define _POSIX_C_SOURCE 200809L

#include "viewer_gl.h"
#include "viewer.h"

#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const double title_seconds = 0.2; /* the least time between changes of the title */
static const double idle_seconds = 60; /* the longest wait; events and the loader end it earlier */
static const double turn_per_second = 0.1; /* speed of the turntable, in drags across the window */

static void on_signal(int number) {
    static const char line[] = "phongsplat-viewer: interrupted\n";
    (void)number;
    ssize_t written = write(STDERR_FILENO, line, sizeof line - 1);
    (void)written;
    _exit(report_exit_code(PSPLAT_ERROR_INTERRUPTED));
}

/* Checks the files before a window is requested, so that a wrong name is reported without a display
 * too. */
static psplat_result check_files(const options *o, const char **path, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    for (int i = 0; i < o->file_count && !result; ++i)
        result = loader_check(*path = o->files[i], error);
    return result;
}

/* ---- the loop ------------------------------------------------------------------------------- */

/* Notes how long a frame took. The first frame after a change compiles shaders and makes targets,
 * so that it is drawn again to be timed. */
static void note_time(viewer *v, double seconds) {
    if (v->is_cold)
        v->needs_redraw = 1;
    else
        v->frame_time = v->frame_time > 0 ? 0.7 * v->frame_time + 0.3 * seconds : seconds;
    if (v->is_cold) v->frame_time = 0;
    v->is_cold = 0;
}

static psplat_result draw(viewer *v, psplat_error *error) {
    int width, height;
    window_size(v->window, &width, &height);
    v->needs_redraw = 0;
    if (width < 1 || height < 1) return PSPLAT_OK;
    double start = window_seconds();
    psplat_result result = frame_draw(v, 0, width, height, error);
    canvas_gl(v->canvas)->Finish();
    note_time(v, window_seconds() - start);
    overlay_draw(v, width, height);
    window_present(v->window);
    return result;
}

static void turn(viewer *v) {
    double now = window_seconds();
    orbit_turn(&v->orbit, turn_per_second * (now - v->turn_time), 0);
    v->turn_time = now;
    v->needs_redraw = 1;
}

/* A file of the command line that cannot be shown ends the program; one that is dropped later does
 * not. */
static psplat_result take_loads(viewer *v, psplat_error *error) {
    for (load *l; (l = loader_take(v->loader)) != NULL;) {
        int width, height;
        shown_change change = shown_assets_take(&v->shown, l);
        window_size(v->window, &width, &height);
        if (change == SHOWN_OPENED) v->animation = 0;
        if (change == SHOWN_OPENED) v->played = 0;
        animation_pose(&v->shown, v->animation, v->played);
        if (change == SHOWN_OPENED)
            orbit_fit(&v->orbit, &v->shown.bounds, height ? (double)width / height : 1);
        v->is_cold = v->needs_redraw = 1;
        if (!v->shown.entry_count && v->options.file_count) {
            *error = v->shown.refused;
            return error->code;
        }
    }
    return PSPLAT_OK;
}

static void update_overlay(viewer *v) {
    int is_busy = loader_is_busy(v->loader);
    if (is_busy != v->was_busy) v->needs_redraw = 1;
    v->was_busy = is_busy;
    if (v->message_end > 0 && window_seconds() >= v->message_end) {
        v->message_end = 0;
        v->needs_redraw = 1;
    }
}

static void update_title(viewer *v) {
    char text[sizeof v->title];
    double now = window_seconds();
    v->is_title_late = now - v->title_time < title_seconds;
    if (v->is_title_late) return;
    title_write(v, text, sizeof text);
    if (!strcmp(text, v->title)) return;
    memcpy(v->title, text, sizeof text);
    v->title_time = now;
    window_set_title(v->window, text);
}

/* Waits until something happens or, while something is due by itself, until it is due. */
static void wait_for_events(viewer *v) {
    int is_due = v->is_title_late || v->message_end > 0;
    int is_moving = v->settings.is_turning || animation_is_playing(v);
    window_wait(v->window, v->needs_redraw || is_moving ? 0
                           : is_due                     ? title_seconds
                                                        : idle_seconds);
}

static psplat_result loop(viewer *v, psplat_error *error) {
    psplat_result result = PSPLAT_OK;
    while (!result && !window_is_closing(v->window)) {
        wait_for_events(v);
        result = take_loads(v, error);
        if (v->settings.is_turning) turn(v);
        animation_advance(v, window_seconds());
        if (shown_tiles_have_news(&v->shown)) v->needs_redraw = 1;
        update_overlay(v);
        if (!result && v->needs_redraw) result = draw(v, error);
        update_title(v);
    }
    return result;
}

/* ---- beginning and end ---------------------------------------------------------------------- */

static psplat_result begin(viewer *v, psplat_error *error) {
    v->settings = v->options.settings;
    v->shown.wake = window_wake;
    v->orbit = (orbit){.azimuth = 0.52, .elevation = 0.35, .distance = 1, .reach = 1};
    v->needs_redraw = 1;
    v->window = window_create(v, &v->options, error);
    if (!v->window) return error->code;
    v->canvas = canvas_create(window_get_proc, NULL, error);
    if (!v->canvas) return error->code;
    psplat_renderer_desc desc = {.get_proc = window_get_proc, .images = decoded_images(&v->shown)};
    psplat_result result = psplat_renderer_create(&desc, &v->renderer, error);
    if (result) return result;
    v->shown.renderer = v->renderer;
    if (v->settings.has_environment) v->sky = sky_create(v->renderer, error);
    if (v->settings.has_environment && !v->sky) return error->code;
    v->loader = loader_create(window_wake, (size_t)v->options.max_megabytes << 20);
    if (!v->loader) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no thread to load files on");
    if (v->options.file_count)
        input_drop(v, (const char *const *)v->options.files, (size_t)v->options.file_count);
    return PSPLAT_OK;
}

static void end(viewer *v) {
    loader_destroy(v->loader);
    if (v->renderer) shown_assets_clear(&v->shown);
    if (v->sky) psplat_environment_destroy(v->renderer, v->sky);
    psplat_renderer_destroy(v->renderer);
    if (v->canvas) target_free(&v->fine, canvas_gl(v->canvas));
    canvas_destroy(v->canvas);
    window_destroy(v->window);
}

static int show(viewer *v) {
    psplat_error error = {0};
    psplat_result result = begin(v, &error);
    if (!result) result = loop(v, &error);
    char path[sizeof v->shown.refused_path] = "";
    if (!v->shown.entry_count) memcpy(path, v->shown.refused_path, sizeof path);
    end(v);
    return result ? report_error(*path ? path : NULL, &error) : 0;
}

int main(int argc, char **argv) {
    viewer v = {.options.settings.pixels = 1};
    psplat_error error = {0};
    const char *path = NULL;
    switch (options_parse(argc, argv, &v.options, &error)) {
    case PARSE_ERROR:
        return report_error(NULL, &error);
    case PARSE_HELP:
        options_print_help();
        return 0;
    case PARSE_VERSION:
        printf("phongsplat-viewer %d.%d.%d\n", PSPLAT_VERSION_MAJOR, PSPLAT_VERSION_MINOR,
               PSPLAT_VERSION_PATCH);
        return 0;
    case PARSE_OK:
        break;
    }
    if (check_files(&v.options, &path, &error)) return report_error(path, &error);
    signal(SIGINT, on_signal);
    signal(SIGTERM, on_signal);
    signal(SIGHUP, on_signal);
    return show(&v);
}
