/* SPDX-License-Identifier: MIT
 *
 * mutate.c - the mutator of all targets, which decides by what the bytes look like. The chunks of a
 * GLB are changed one by one and put together, mostly with correct lengths. JSON, texts and binary
 * data have mutators of their own. One input in eight is left to libFuzzer's own mutator.
 */
#include "fuzz.h"

#include <stdlib.h>
#include <string.h>

enum { HEADER = 12, CHUNK_HEADER = 8, WORD = 4 };

static uint32_t get_u32(const uint8_t *bytes) {
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

static void put_u32(uint8_t *bytes, size_t value) {
    for (int i = 0; i < WORD; ++i) bytes[i] = (uint8_t)(value >> (8 * i));
}

static int is_glb(const fuzz_text *text) {
    return text->size >= HEADER + CHUNK_HEADER && !memcmp(text->data, "glTF", WORD) &&
           get_u32(text->data + HEADER) <= text->size - HEADER - CHUNK_HEADER;
}

static int is_json(const fuzz_text *text) {
    size_t at = 0;
    while (at < text->size && text->data[at] && strchr(" \t\r\n", text->data[at])) ++at;
    return at < text->size && text->data[at] == '{';
}

/* Returns whether all bytes but some 1 % are letters, digits and the like. */
static int is_printable(const fuzz_text *text) {
    size_t others = 0;
    for (size_t i = 0; i < text->size; ++i) {
        uint8_t c = text->data[i];
        others += (c < ' ' || c > '~') && c != '\n' && c != '\r' && c != '\t';
    }
    return others * 100 <= text->size;
}

/* Pads a chunk to a multiple of four bytes. */
static void pad(fuzz_text *text, uint8_t with) {
    while (text->size % WORD && text->size < text->capacity) text->data[text->size++] = with;
    text->size -= text->size % WORD;
}

/* Puts the chunk back in the place of the bytes from begin to end, with its length before it. */
static void put_chunk(fuzz_text *text, size_t begin, size_t end, const fuzz_text *chunk) {
    if (!fuzz_splice(text, begin, end, chunk->data, chunk->size)) return;
    put_u32(text->data + begin - CHUNK_HEADER, chunk->size);
    put_u32(text->data + 8, text->size);
}

static void mutate_chunk(fuzz_text *text, size_t begin, size_t end, int is_document,
                         uint32_t *random) {
    fuzz_text chunk = {.size = end - begin, .capacity = end - begin + 512};
    chunk.data = calloc(chunk.capacity, 1);
    if (!chunk.data) return;
    memcpy(chunk.data, text->data + begin, chunk.size);
    if (is_document)
        fuzz_mutate_json(&chunk, random);
    else
        fuzz_mutate_binary(&chunk, random);
    pad(&chunk, is_document ? ' ' : 0);
    put_chunk(text, begin, end, &chunk);
    free(chunk.data);
}

static void mutate_glb(fuzz_text *text, uint32_t *random) {
    size_t begin = HEADER + CHUNK_HEADER, end = begin + get_u32(text->data + HEADER);
    int is_document = fuzz_random(random, 3) != 0;
    if (!is_document && text->size - end >= CHUNK_HEADER) {
        begin = end + CHUNK_HEADER;
        end = text->size;
    } else {
        is_document = 1;
    }
    mutate_chunk(text, begin, end, is_document, random);
}

static void mutate_raw(fuzz_text *text, uint32_t *random) {
    text->size = LLVMFuzzerMutate(text->data, text->size, text->capacity);
    if (is_glb(text) && fuzz_random(random, 2)) put_u32(text->data + 8, text->size);
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed) {
    fuzz_text text = {data, size, max_size};
    uint32_t random = seed * 2654435761u | 1;
    size_t times = 1 + fuzz_random(&random, 3);
    for (size_t i = 0; i < times; ++i) {
        if (!fuzz_random(&random, 8))
            mutate_raw(&text, &random);
        else if (is_glb(&text))
            mutate_glb(&text, &random);
        else if (is_json(&text))
            fuzz_mutate_json(&text, &random);
        else if (is_printable(&text))
            fuzz_mutate_lines(&text, &random);
        else
            fuzz_mutate_binary(&text, &random);
    }
    return text.size;
}
