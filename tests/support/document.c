/* SPDX-License-Identifier: MIT
 *
 * document.c - changes to a text document; see document.h.
 */

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void give_up(const char *what, const char *which) {
    fprintf(stderr, "document: %s: %s\n", what, which);
    abort();
}

char *document_read(const char *path, size_t *size) {
    enum { LIMIT = 1 << 20 };
    char *text = malloc(LIMIT + 1);
    FILE *file = fopen(path, "rb");
    if (!file || !text) {
        give_up("cannot read", path);
        return NULL;
    }
    *size = fread(text, 1, LIMIT, file);
    text[*size] = 0;
    fclose(file);
    return text;
}

char *document_minimal(const char *source_dir) {
    char path[1024];
    size_t size = 0;
    snprintf(path, sizeof path, "%s/schema/minimal.gltf", source_dir);
    return document_read(path, &size);
}

size_t document_find(const char *text, const char *word) {
    const char *found = strstr(text, word);
    if (!found) give_up("does not hold", word);
    return (size_t)(found - text);
}

void document_replace(char **text, const char *from, const char *to) {
    size_t at = document_find(*text, from), size = strlen(*text);
    char *changed = malloc(size - strlen(from) + strlen(to) + 1);
    if (!changed) {
        give_up("out of memory", from);
        return;
    }
    memcpy(changed, *text, at);
    strcpy(changed + at, to);
    strcat(changed + at, *text + at + strlen(from));
    free(*text);
    *text = changed;
}
