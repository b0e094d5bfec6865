/* SPDX-License-Identifier: MIT
 *
 * document.h - schema/minimal.gltf as text, to be changed into what a test is about. Texts are
 * malloc'd and owned by the caller. A test that asks for what is not there ends with a message.
 */
#ifndef PHONGSPLAT_TEST_DOCUMENT_H
#define PHONGSPLAT_TEST_DOCUMENT_H

#include <stddef.h>

char *document_read(const char *path, size_t *size);

/* The bundled document; source_dir is PSPLAT_SOURCE_DIR. */
char *document_minimal(const char *source_dir);

/* Replaces the first from in *text by to. */
void document_replace(char **text, const char *from, const char *to);

/* Offset of the first word in text. */
size_t document_find(const char *text, const char *word);

#endif
