/* SPDX-License-Identifier: MIT
 *
 * screenshot.c - saves the picture without the overlay as a PNG that replaces no file. It is drawn
 * into a framebuffer of its own, because the pixels of a window that another one covers are
 * undefined.
 */
#define _GNU_SOURCE /* for O_TMPFILE */

#include "viewer_gl.h"
#include "viewer.h"

#include <errno.h>
#include <fcntl.h>
#include <png.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* ---- the file ------------------------------------------------------------------------------ */

enum { MAX_NUMBER = 9999 };

int screenshot_name(const char *asset, const char *directory, int n, char *path, size_t size) {
    const char *name = shown_asset_name(asset), *dot = strrchr(name, '.');
    int stem = (int)(dot && dot > name ? (size_t)(dot - name) : strlen(name));
    int prefix = directory ? (int)strlen(directory) : (int)(name - asset);
    int written = snprintf(path, size, "%.*s%s%.*s-%03d.png", prefix, directory ? directory : asset,
                           directory && prefix ? "/" : "", stem, name, n);
    return written > 0 && (size_t)written < size;
}

static int write_all(int file, const uint8_t *data, size_t size) {
    while (size) {
        ssize_t written = write(file, data, size);
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return 0;
        data += written;
        size -= (size_t)written;
    }
    return 1;
}

/* Opens a file that has no name yet, so that killing the viewer leaves no half picture. Returns -1
 * where the file system has no such files. */
static int open_nameless(const char *path) {
    const char *slash = strrchr(path, '/');
    char *directory = slash ? strndup(path, (size_t)(slash - path) + 1) : strdup(".");
    int file = directory ? open(directory, O_TMPFILE | O_WRONLY | O_CLOEXEC, 0666) : -1;
    free(directory);
    return file;
}

/* Gives the file a name that must be free. */
static int link_nameless(int file, const char *path) {
    char link[64];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    return linkat(AT_FDCWD, link, AT_FDCWD, path, AT_SYMLINK_FOLLOW);
}

/* Returns 0 or an errno. */
static int create(const char *path, const uint8_t *png, size_t size) {
    int file = open_nameless(path), cause = EOPNOTSUPP;
    if (file >= 0) {
        cause = write_all(file, png, size) && !link_nameless(file, path) ? 0 : errno;
        close(file);
    }
    if (!cause || cause == EEXIST) return cause;
    file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (file < 0) return errno;
    cause = write_all(file, png, size) ? 0 : errno;
    if (close(file) && !cause) cause = errno;
    if (cause) unlink(path);
    return cause;
}

int screenshot_create(const char *asset, const char *directory, const uint8_t *png, size_t png_size,
                      char *path, size_t size) {
    for (int n = 1; n <= MAX_NUMBER; ++n) {
        if (!screenshot_name(asset, directory, n, path, size)) return ENAMETOOLONG;
        if (!access(path, F_OK)) continue;
        int cause = create(path, png, png_size);
        if (cause != EEXIST) return cause;
    }
    return EEXIST;
}

static psplat_result store(const viewer *v, const uint8_t *png, size_t png_size, char *path,
                           size_t size, psplat_error *error) {
    const char *asset = v->shown.entry_count ? v->shown.entries[0].path : "phongsplat";
    const char *directory = v->options.screenshots;
    int cause = screenshot_create(asset, directory, png, png_size, path, size);
    if (cause && !directory) cause = screenshot_create(asset, ".", png, png_size, path, size);
    if (!cause) return PSPLAT_OK;
    return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%.150s: %s", path, strerror(cause));
}

/* ---- the picture --------------------------------------------------------------------------- */

/* Draws into rgba: width x height pixels, row 0 at the bottom. */
static psplat_result draw(viewer *v, int width, int height, uint8_t *rgba, psplat_error *error) {
    const gl *gl = canvas_gl(v->canvas);
    target t = {0};
    psplat_result result = PSPLAT_OK;
    if (!target_resize(&t, gl, width, height))
        result = psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "no framebuffer for a screenshot");
    if (!result) result = frame_draw(v, t.framebuffer, width, height, error);
    if (!result) {
        gl->PixelStorei(GL_PACK_ALIGNMENT, 1);
        gl->ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    }
    gl->BindFramebuffer(GL_FRAMEBUFFER, 0);
    target_free(&t, gl);
    return result;
}

/* Turns RGBA into RGB in place; the alpha that the framebuffer happens to hold is not saved. */
static void drop_alpha(uint8_t *pixels, size_t count) {
    for (size_t i = 0; i < count; ++i) memmove(pixels + 3 * i, pixels + 4 * i, 3);
}

/* Encodes with libpng's simplified interface, which first says how much memory it needs and then
 * fills it. */
static psplat_result encode(uint8_t *rgb, int width, int height, uint8_t **data, size_t *size,
                            psplat_error *error) {
    png_image image = {.version = PNG_IMAGE_VERSION,
                       .width = (png_uint_32)width,
                       .height = (png_uint_32)height,
                       .format = PNG_FORMAT_RGB};
    png_alloc_size_t needed = PNG_IMAGE_PNG_SIZE_MAX(image);
    *data = malloc(needed);
    if (!*data) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a screenshot");
    int stride = -3 * width; /* negative: the last row first */
    if (!png_image_write_to_memory(&image, *data, &needed, 0, rgb, stride, NULL))
        return psplat_fail(error, PSPLAT_ERROR_WRITE, 0, "%s", image.message);
    *size = needed;
    return PSPLAT_OK;
}

psplat_result screenshot_take(viewer *v, char *path, size_t size, psplat_error *error) {
    int width, height;
    window_size(v->window, &width, &height);
    if (width < 1 || height < 1)
        return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "the window has no size");
    size_t png_size = 0, count = (size_t)width * (size_t)height;
    uint8_t *pixels = malloc(4 * count), *png = NULL;
    if (!pixels) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "no memory for a screenshot");
    psplat_result result = draw(v, width, height, pixels, error);
    if (!result) {
        drop_alpha(pixels, count);
        result = encode(pixels, width, height, &png, &png_size, error);
    }
    if (!result) result = store(v, png, png_size, path, size, error);
    free(pixels);
    free(png);
    return result;
}
