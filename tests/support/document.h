/* SPDX-License-Identifier: MIT
 *
 * document.h - schema/minimal.gltf as text, which a test changes into what it is about. Texts are
 * allocated with malloc and owned by the caller. A test that looks for a text that is not there
 * ends with a message.
 */
#ifndef PHONGSPLAT_TEST_DOCUMENT_H
#define PHONGSPLAT_TEST_DOCUMENT_H

#include <stddef.h>

char *document_read(const char *path, size_t *size);

/* Reads the bundled document; source_dir is PSPLAT_SOURCE_DIR. */
char *document_minimal(const char *source_dir);

/* Replaces the first occurrence of from in *text by to. */
void document_replace(char **text, const char *from, const char *to);

/* Returns the offset of the first occurrence of word in text. */
size_t document_find(const char *text, const char *word);

#endif
