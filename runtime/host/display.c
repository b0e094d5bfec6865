/* SPDX-License-Identifier: MIT
 *
 * display.c - the EGL displays that a headless context may use, in the order in which they are
 * tried: the devices of GPUs (unless software is asked for), Mesa's software device, Mesa's
 * surfaceless platform and the default display. A driver may offer a device and then refuse
 * contexts on it, so the caller goes on until one works.
 */
#include "host/egl_context.h"

#include <EGL/eglext.h>
#include <string.h>

enum { MAX_DEVICES = 16 }; /* of EGL_EXT_device_enumeration; chosen by hand */

/* Returns 1 where a list of words separated by spaces (or NULL) has the word. */
static int has_word(const char *list, const char *word) {
    size_t length = strlen(word);
    for (const char *at = list; at && (at = strstr(at, word)); at += length)
        if ((at == list || at[-1] == ' ') && (at[length] == ' ' || at[length] == '\0')) return 1;
    return 0;
}

/* Returns the display once it is initialised, or EGL_NO_DISPLAY. */
static EGLDisplay initialized(EGLDisplay display) {
    if (display == EGL_NO_DISPLAY) return EGL_NO_DISPLAY;
    return eglInitialize(display, NULL, NULL) ? display : EGL_NO_DISPLAY;
}

/* EGL returns the same display object for the same platform and native handle, so that hosts of one
 * process share it; that is why no host terminates it. */
static EGLDisplay platform_display(EGLenum platform, void *native) {
    PFNEGLGETPLATFORMDISPLAYEXTPROC get =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    return get ? initialized(get(platform, native, NULL)) : EGL_NO_DISPLAY;
}

static EGLDisplay surfaceless_display(const char *extensions) {
    if (!has_word(extensions, "EGL_MESA_platform_surfaceless")) return EGL_NO_DISPLAY;
    return platform_display(EGL_PLATFORM_SURFACELESS_MESA, (void *)EGL_DEFAULT_DISPLAY);
}

/* Returns the display of the index-th device that is (software 1) or is not (software 0) Mesa's
 * software rasteriser. *exists becomes 0 where there is no such device. */
static EGLDisplay device_display(const char *extensions, int software, int index, int *exists) {
    PFNEGLQUERYDEVICESEXTPROC query_devices =
        (PFNEGLQUERYDEVICESEXTPROC)eglGetProcAddress("eglQueryDevicesEXT");
    PFNEGLQUERYDEVICESTRINGEXTPROC query_string =
        (PFNEGLQUERYDEVICESTRINGEXTPROC)eglGetProcAddress("eglQueryDeviceStringEXT");
    EGLDeviceEXT devices[MAX_DEVICES];
    EGLint count = 0;
    *exists = 0;
    if (!has_word(extensions, "EGL_EXT_platform_device") || !query_devices || !query_string ||
        !query_devices(MAX_DEVICES, devices, &count))
        return EGL_NO_DISPLAY;
    for (EGLint i = 0; i < count; ++i) {
        const char *words = query_string(devices[i], EGL_EXTENSIONS);
        if (has_word(words, "EGL_MESA_device_software") != software || index-- > 0) continue;
        *exists = 1;
        return platform_display(EGL_PLATFORM_DEVICE_EXT, devices[i]);
    }
    return EGL_NO_DISPLAY;
}

EGLDisplay psplat_host_display(int software, int attempt, int *done) {
    const char *extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    int exists = 0;
    *done = 0;
    if (!software) {
        for (int index = 0; index < MAX_DEVICES; ++index) {
            EGLDisplay display = device_display(extensions, 0, index, &exists);
            if (!exists) break;
            if (attempt-- == 0) return display;
        }
    }
    EGLDisplay device = device_display(extensions, 1, 0, &exists);
    if (exists && attempt-- == 0) return device;
    if (attempt-- == 0) return surfaceless_display(extensions);
    *done = 1;
    return initialized(eglGetDisplay(EGL_DEFAULT_DISPLAY));
}
