/* SPDX-License-Identifier: MIT
 *
 * input.c - what keys and the pointer do. One table holds each key, its help and its action; the
 * overlay, --help and the dispatcher read it.
 */
#include "viewer.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <math.h>
#include <stdio.h>

static const double quarter_turn = 1.57079632679489661923;

static void changed(viewer *v) {
    v->is_cold = v->needs_redraw = 1;
}

/* ---- actions: value is the table's ---------------------------------------------------------- */

static void act_turn(viewer *v, int value) {
    static const double steps[][2] = {{-1. / 36, 0}, {1. / 36, 0}, {0, -1. / 36}, {0, 1. / 36}};
    orbit_turn(&v->orbit, steps[value][0], steps[value][1]); /* one step is 5 degrees */
    v->needs_redraw = 1;
}

static void act_zoom(viewer *v, int value) {
    orbit_zoom(&v->orbit, value, 0, 0);
    v->needs_redraw = 1;
}

static void act_fit(viewer *v, int value) {
    int width, height;
    (void)value;
    window_size(v->window, &width, &height);
    orbit_fit(&v->orbit, &v->shown.bounds, height ? (double)width / height : 1);
    v->needs_redraw = 1;
}

/* value names the axis, 0 to 2; 3 more looks along it from the other side. */
static void act_axis(viewer *v, int value) {
    static const double views[][2] = {{1, 0}, {0, 1}, {0, 0}, {-1, 0}, {0, -1}, {2, 0}};
    v->orbit.azimuth = views[value][0] * quarter_turn;
    v->orbit.elevation = views[value][1] * quarter_turn;
    v->needs_redraw = 1;
}

static void act_orthographic(viewer *v, int value) {
    (void)value;
    v->settings.is_orthographic = !v->settings.is_orthographic;
    overlay_say(v, v->settings.is_orthographic ? "orthographic" : "perspective");
    changed(v);
}

static void act_turntable(viewer *v, int value) {
    (void)value;
    v->settings.is_turning = !v->settings.is_turning;
    v->turn_time = window_seconds();
    v->needs_redraw = 1;
}

static void act_pause(viewer *v, int value) {
    (void)value;
    if (!animation_count(&v->shown)) {
        overlay_say(v, "no animations");
        return;
    }
    v->settings.is_paused = !v->settings.is_paused;
    overlay_say(v, v->settings.is_paused ? "paused" : "playing");
}

static void act_animation(viewer *v, int value) {
    int count = animation_count(&v->shown);
    if (!count) {
        overlay_say(v, "no animations");
        return;
    }
    v->animation = (v->animation + value) % count;
    v->played = 0;
    animation_pose(&v->shown, v->animation, 0);
    overlay_say(v, "animation %d of %d: %.200s", v->animation + 1, count,
                animation_name(&v->shown, v->animation));
}

static void say_choice(viewer *v, const char *what, const char *name) {
    overlay_say(v, "%s: %s", what, name);
    changed(v);
}

static void act_mode(viewer *v, int value) {
    v->settings.mode = (v->settings.mode + value) % names_count(mode_names);
    say_choice(v, "mode", mode_names[v->settings.mode]);
}

static void act_shading(viewer *v, int value) {
    v->settings.shading = value;
    say_choice(v, "shading", shading_names[value]);
}

static void act_lights(viewer *v, int value) {
    v->settings.lights = (v->settings.lights + value) % names_count(lights_names);
    say_choice(v, "lights", lights_names[v->settings.lights]);
}

static void act_shadows(viewer *v, int value) {
    (void)value;
    v->settings.has_no_shadows = !v->settings.has_no_shadows;
    say_choice(v, "shadows", v->settings.has_no_shadows ? "off" : "on");
}

static void act_environment(viewer *v, int value) {
    psplat_error error = {0};
    (void)value;
    if (!v->sky) v->sky = sky_create(v->renderer, &error);
    v->settings.has_environment = v->sky && !v->settings.has_environment;
    say_choice(v, "environment",
               !v->sky                       ? error.text
               : v->settings.has_environment ? "a hazy sky"
                                             : "none");
}

static void act_smooth(viewer *v, int value) {
    (void)value;
    v->settings.is_smooth = !v->settings.is_smooth;
    say_choice(v, "smooth edges", v->settings.is_smooth ? "on" : "off");
}

static void act_filter(viewer *v, int value) {
    (void)value;
    v->settings.has_no_filter = !v->settings.has_no_filter;
    say_choice(v, "screen-space filter", v->settings.has_no_filter ? "off" : "on");
}

static void act_culling(viewer *v, int value) {
    v->settings.culling = (v->settings.culling + value) % names_count(culling_names);
    say_choice(v, "back faces culled", culling_names[v->settings.culling]);
}

/* value is the number of doublings. */
static void act_pixels(viewer *v, int value) {
    v->settings.pixels = fmin(fmax(ldexp(v->settings.pixels, value), 0.125), 64);
    overlay_say(v, "error of tiles: %.3g pixels", v->settings.pixels);
}

static void act_tile_report(viewer *v, int value) {
    (void)value;
    v->settings.has_tile_report = !v->settings.has_tile_report;
    v->needs_redraw = 1;
}

static void act_backdrop(viewer *v, int value) {
    v->settings.backdrop = (v->settings.backdrop + value) % names_count(backdrop_names);
    v->needs_redraw = 1;
}

static void act_side_by_side(viewer *v, int value) {
    v->shown.is_side_by_side = !v->shown.is_side_by_side;
    shown_assets_arrange(&v->shown);
    act_fit(v, value);
    changed(v);
}

static void act_reload(viewer *v, int value) {
    (void)value;
    loader_reload(v->loader);
}

static void act_screenshot(viewer *v, int value) {
    char path[1024];
    psplat_error error = {0};
    (void)value;
    if (screenshot_take(v, path, sizeof path, &error))
        overlay_say(v, "no screenshot: %s", error.text);
    else
        overlay_say(v, "saved as %.300s", path);
}

static void act_full_screen(viewer *v, int value) {
    (void)value;
    window_toggle_full_screen(v->window);
    changed(v);
}

static void act_help(viewer *v, int value) {
    (void)value;
    v->has_help = !v->has_help;
    v->needs_redraw = 1;
}

static void act_quit(viewer *v, int value) {
    if (value && v->has_help)
        act_help(v, 0); /* Escape closes the help first */
    else
        window_close(v->window);
}

/* ---- the table ------------------------------------------------------------------------------ */

#define SHIFT GLFW_MOD_SHIFT
#define GAP                                                                                        \
    { 0, 0, "", "", NULL, 0, 0 } /* a gap between groups in the help */

const key_binding key_bindings[] = {
    {0, 0, "drag", "orbit", NULL, 0, 0},
    {0, 0, "Shift drag, right drag", "pan", NULL, 0, 0},
    {0, 0, "wheel, Ctrl drag", "zoom", NULL, 0, 0},
    {0, 0, "double click", "orbit about what is there", NULL, 0, 0},
    {0, 0, "drop files", "show them", NULL, 0, 0},
    GAP,
    {GLFW_KEY_LEFT, 0, "arrows", "orbit by 5 degrees", act_turn, 0, 1},
    {GLFW_KEY_RIGHT, 0, NULL, NULL, act_turn, 1, 1},
    {GLFW_KEY_DOWN, 0, NULL, NULL, act_turn, 2, 1},
    {GLFW_KEY_UP, 0, NULL, NULL, act_turn, 3, 1},
    {GLFW_KEY_EQUAL, 0, "+ -", "zoom", act_zoom, 1, 1},
    {GLFW_KEY_EQUAL, SHIFT, NULL, NULL, act_zoom, 1, 1},
    {GLFW_KEY_KP_ADD, 0, NULL, NULL, act_zoom, 1, 1},
    {GLFW_KEY_MINUS, 0, NULL, NULL, act_zoom, -1, 1},
    {GLFW_KEY_KP_SUBTRACT, 0, NULL, NULL, act_zoom, -1, 1},
    {GLFW_KEY_R, 0, "R", "all of it in the window", act_fit, 0, 0},
    {GLFW_KEY_HOME, 0, NULL, NULL, act_fit, 0, 0},
    {GLFW_KEY_X, 0, "X Y Z", "along an axis; Shift: from the other side", act_axis, 0, 0},
    {GLFW_KEY_Y, 0, NULL, NULL, act_axis, 1, 0},
    {GLFW_KEY_Z, 0, NULL, NULL, act_axis, 2, 0},
    {GLFW_KEY_X, SHIFT, NULL, NULL, act_axis, 3, 0},
    {GLFW_KEY_Y, SHIFT, NULL, NULL, act_axis, 4, 0},
    {GLFW_KEY_Z, SHIFT, NULL, NULL, act_axis, 5, 0},
    {GLFW_KEY_P, 0, "P", "perspective, orthographic", act_orthographic, 0, 0},
    {GLFW_KEY_SPACE, 0, "Space", "turntable", act_turntable, 0, 0},
    {GLFW_KEY_K, 0, "K", "animation: pause, play", act_pause, 0, 0},
    {GLFW_KEY_N, 0, "N", "next animation", act_animation, 1, 0},
    GAP,
    {GLFW_KEY_M, 0, "M", "mode: phong, gaussian, flat", act_mode, 1, 0},
    {GLFW_KEY_1, 0, "1 2 3", "lit, unlit, toon", act_shading, PSPLAT_SHADING_LIT, 0},
    {GLFW_KEY_2, 0, NULL, NULL, act_shading, PSPLAT_SHADING_UNLIT, 0},
    {GLFW_KEY_3, 0, NULL, NULL, act_shading, PSPLAT_SHADING_TOON, 0},
    {GLFW_KEY_4, 0, "4 5 6 7", "normals, depth, overdraw, splats", act_shading,
     PSPLAT_SHADING_NORMAL, 0},
    {GLFW_KEY_5, 0, NULL, NULL, act_shading, PSPLAT_SHADING_DEPTH, 0},
    {GLFW_KEY_6, 0, NULL, NULL, act_shading, PSPLAT_SHADING_OVERDRAW, 0},
    {GLFW_KEY_7, 0, NULL, NULL, act_shading, PSPLAT_SHADING_SPLATS, 0},
    {GLFW_KEY_L, 0, "L", "lights: headlight, studio, spots, none", act_lights, 1, 0},
    {GLFW_KEY_E, 0, "E", "environment: none, a hazy sky", act_environment, 0, 0},
    {GLFW_KEY_S, 0, "S", "shadows on, off", act_shadows, 0, 0},
    {GLFW_KEY_F, 0, "F", "screen-space filter on, off", act_filter, 0, 0},
    {GLFW_KEY_V, 0, "V", "smooth edges on, off", act_smooth, 0, 0},
    {GLFW_KEY_C, 0, "C", "back faces: by material, shown, culled", act_culling, 1, 0},
    {GLFW_KEY_B, 0, "B", "background", act_backdrop, 1, 0},
    GAP,
    {GLFW_KEY_A, 0, "A", "several files: in place, in a row", act_side_by_side, 0, 0},
    {GLFW_KEY_LEFT_BRACKET, 0, "[ ]", "tilesets: half, twice the error", act_pixels, -1, 1},
    {GLFW_KEY_RIGHT_BRACKET, 0, NULL, NULL, act_pixels, 1, 1},
    {GLFW_KEY_T, 0, "T", "tilesets: show numbers of tiles", act_tile_report, 0, 0},
    {GLFW_KEY_F5, 0, "F5", "load again", act_reload, 0, 0},
    {GLFW_KEY_F11, 0, "F11", "full screen", act_full_screen, 0, 0},
    {GLFW_KEY_F12, 0, "F12", "save a screenshot", act_screenshot, 0, 0},
    {GLFW_KEY_PRINT_SCREEN, 0, NULL, NULL, act_screenshot, 0, 0},
    {GLFW_KEY_H, 0, "H, F1", "show or hide this", act_help, 0, 0},
    {GLFW_KEY_F1, 0, NULL, NULL, act_help, 0, 0},
    {GLFW_KEY_Q, 0, "Q, Esc", "quit", act_quit, 0, 0},
    {GLFW_KEY_ESCAPE, 0, NULL, NULL, act_quit, 1, 0},
};

const size_t key_binding_count = sizeof key_bindings / sizeof *key_bindings;

const key_binding *input_find(int key, int modifiers) {
    const int locks = GLFW_MOD_CAPS_LOCK | GLFW_MOD_NUM_LOCK;
    for (size_t i = 0; i < key_binding_count; ++i)
        if (key_bindings[i].key && key_bindings[i].key == key &&
            key_bindings[i].modifiers == (modifiers & ~locks))
            return &key_bindings[i];
    return NULL;
}

void input_key(viewer *v, int key, int modifiers, int is_repeat) {
    const key_binding *binding = input_find(key, modifiers);
    if (binding && (!is_repeat || binding->repeats)) binding->act(v, binding->value);
}

/* ---- the pointer ---------------------------------------------------------------------------- */

void input_drag(viewer *v, int button, int modifiers, double x, double y) {
    if (button != GLFW_MOUSE_BUTTON_LEFT || modifiers & GLFW_MOD_SHIFT)
        orbit_pan(&v->orbit, x, y);
    else if (modifiers & GLFW_MOD_CONTROL)
        orbit_zoom(&v->orbit, 20 * y, 0, 0);
    else
        orbit_turn(&v->orbit, x, y);
    v->needs_redraw = 1;
}

void input_scroll(viewer *v, double steps, double x, double y) {
    orbit_zoom(&v->orbit, steps, x, y);
    v->needs_redraw = 1;
}

void input_double_click(viewer *v, double x, double y) {
    v->pick[0] = x;
    v->pick[1] = y;
    v->has_pick = v->needs_redraw = 1;
}

void input_drop(viewer *v, const char *const *paths, size_t count) {
    if (!loader_open(v->loader, paths, count)) overlay_say(v, "out of memory");
    v->needs_redraw = 1;
}
