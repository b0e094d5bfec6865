/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * page.c - the page of `convert --html`.
 */
#include "cli/page.h"

#include "base/file_bytes.h"
#include "cli/command.h"
#include "export/html_page.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const char template_name[] = "phongsplat-page.html";

/* Where builds and installations have the template, from the directory of the program. */
static const char *const places[] = {"", PSPLAT_PAGE_DIRECTORY "/"};

enum { PLACE_COUNT = sizeof places / sizeof *places, MAX_PATH = 4096 };

static psplat_result read_template(char **text, psplat_error *error) {
    char path[MAX_PATH], name[MAX_PATH + sizeof PSPLAT_PAGE_DIRECTORY + sizeof template_name + 1];
    psplat_result result = PSPLAT_ERROR_READ;
    size_t size;
    int is_there = 0;
    int is_known = psplat_program_directory(path, sizeof path);
    for (int i = 0; is_known && i < PLACE_COUNT && !is_there; ++i) {
        snprintf(name, sizeof name, "%s%s%s", path, places[i], template_name);
        is_there = access(name, F_OK) == 0;
        if (is_there) result = psplat_file_read(name, text, &size, error);
    }
    if (!is_there)
        return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0,
                           "%s: not found beside phongsplat or in %s; builds have it where "
                           "Node.js and three.js are (samples/install.sh)",
                           template_name, PSPLAT_PAGE_DIRECTORY);
    if (result || !psplat_html_check(*text, error)) return result;
    return psplat_fail(error, PSPLAT_ERROR_GRAPHICS, 0, "%s: is not the viewer's page",
                       template_name);
}

/* Returns whether an OBJ refers to a file of materials, in a line that blanks may begin. */
static int has_library(const char *text) {
    for (const char *at = text; (at = strstr(at, "mtllib")) != NULL; ++at) {
        const char *begin = at;
        while (begin > text && (begin[-1] == ' ' || begin[-1] == '\t')) --begin;
        if (begin == text || begin[-1] == '\n' || begin[-1] == '\r') return 1;
    }
    return 0;
}

/* Returns whether the JSON of a GLB, which begins behind two headers and holds no zeros, names
 * Draco's extension; a 0 follows the bytes of the file. */
static int names_draco(const psplat_source *glb) {
    enum { HEADERS = 20 };
    return glb->size > HEADERS && strstr(glb->data + HEADERS, "KHR_draco_mesh_compression") != NULL;
}

int psplat_page_wants_mesh(const psplat_page *page) {
    switch (page->source.format) {
    case PSPLAT_SOURCE_UNKNOWN:
        return 0;
    case PSPLAT_SOURCE_GLB:
        return names_draco(&page->source);
    case PSPLAT_SOURCE_OBJ:
        return has_library(page->source.data);
    default:
        return 1;
    }
}

psplat_result psplat_page_open(psplat_page *page, const char *source, psplat_error *error) {
    psplat_result result = read_template(&page->template, error);
    if (result || !source) return result;
    return psplat_source_load(source, &page->source, error);
}

/* Returns the file name of a path, with the extension at its end, or NULL; the caller frees it. */
static char *name_with(const char *path, const char *extension) {
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    size_t length = strlen(base), more = strlen(extension);
    char *name = malloc(length + more + 1);
    if (!name) return NULL;
    int has_it = length > more && !strcmp(base + length - more, extension);
    memcpy(name, base, length + 1);
    if (!has_it) memcpy(name + length, extension, more + 1);
    return name;
}

psplat_result psplat_page_make(const psplat_page *page, const char *asset_path, const void *bytes,
                               size_t size, char **text, size_t *text_size, psplat_error *error) {
    int has_source = page->source.format != PSPLAT_SOURCE_UNKNOWN;
    int is_obj = page->source.format == PSPLAT_SOURCE_OBJ && !page->mesh;
    char *name = name_with(strcmp(asset_path, "-") != 0 ? asset_path : "splats", ".glb");
    char *source = has_source ? name_with(page->source.file, is_obj ? ".obj" : ".glb") : NULL;
    const psplat_page_model models[] = {{name, bytes, size},
                                        {source,
                                         page->mesh ? (const void *)page->mesh : page->source.data,
                                         page->mesh ? page->mesh_size : page->source.size}};
    psplat_result result =
        name && (source || !has_source)
            ? psplat_html_page(page->template, models, has_source ? 2 : 1, text, text_size, error)
            : psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    free(name);
    free(source);
    return result;
}

void psplat_page_close(psplat_page *page) {
    free(page->template);
    free(page->mesh);
    psplat_source_free(&page->source);
    page->template = NULL;
    page->mesh = NULL;
}
