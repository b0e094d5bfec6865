/* SPDX-License-Identifier: MIT
 *
 * mutate_bytes.c - changes binary data and texts of numbers; see fuzz.h.
 */
#include "fuzz.h"

#include <stdlib.h>
#include <string.h>

/* Numbers at the bounds of what single precision, quaternions, radii and indices may be. */
static const uint32_t words[] = {
    0x00000000u, 0x80000000u, 0x3f800000u, 0xbf800000u, 0x3f000000u, 0x3f3504f3u, 0x00000001u,
    0x00800000u, 0x7f7fffffu, 0xff7fffffu, 0x7f800000u, 0xff800000u, 0x7fc00000u, 0x3d4ccccdu,
    0x3f7d70a4u, 0x3f8147aeu, 0x41a00000u, 0x7e967699u, 0x0da24260u, 0xffffffffu, 0x00000002u,
    0x00000003u, 0x00000004u, 0x0000ffffu, 0x00010000u, 0x7fffffffu, 0x4b800000u, 0x33d6bf95u,
};

void fuzz_mutate_binary(fuzz_text *text, uint32_t *random) {
    if (text->size < 4 || fuzz_random(random, 2)) {
        text->size = LLVMFuzzerMutate(text->data, text->size, text->capacity);
        return;
    }
    size_t at = 4 * fuzz_random(random, text->size / 4);
    size_t other = 4 * fuzz_random(random, text->size / 4);
    uint32_t word = words[fuzz_random(random, sizeof words / sizeof *words)];
    if (fuzz_random(random, 3) == 0) memcpy(&word, text->data + other, sizeof word);
    for (int i = 0; i < 4; ++i) text->data[at + (size_t)i] = (uint8_t)(word >> (8 * i));
}

/* ---- texts -------------------------------------------------------------------------------- */

static int is_blank(uint8_t c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n' || c == ',' || c == ';' || c == '/';
}

/* Returns the next token after a random place. */
static size_t token_at(const fuzz_text *text, uint32_t *random, size_t *end) {
    size_t begin = fuzz_random(random, text->size);
    while (begin && !is_blank(text->data[begin - 1])) --begin;
    *end = begin;
    while (*end < text->size && !is_blank(text->data[*end])) ++*end;
    return begin;
}

static size_t line_at(const fuzz_text *text, uint32_t *random, size_t *end) {
    size_t begin = fuzz_random(random, text->size);
    while (begin && text->data[begin - 1] != '\n') --begin;
    *end = begin;
    while (*end < text->size && text->data[*end] != '\n') ++*end;
    *end += *end < text->size;
    return begin;
}

static void replace_token(fuzz_text *text, uint32_t *random) {
    static const char *const numbers[] = {
        "0",          "1",          "2",          "3",          "4",
        "-1",         "-2",         "8",          "1.5",        "-0.0",
        "1e-30",      "3e38",       "-1e39",      "1e-45",      "1e400",
        "nan",        "inf",        "0x10",       "255",        "65536",
        "1073741824", "4294967295", "4294967296", "2147483648", "99999999999999999999",
        "1e7",        "1.0000001",  ".5",         "5.",         "+1",
        "1,5",        "",           "-"};
    size_t end, begin = token_at(text, random, &end);
    const char *number = numbers[fuzz_random(random, sizeof numbers / sizeof *numbers)];
    fuzz_splice(text, begin, end, number, strlen(number));
}

static void copy_line(fuzz_text *text, uint32_t *random) {
    size_t end, begin = line_at(text, random, &end), ignored;
    size_t to = line_at(text, random, &ignored);
    uint8_t *copy = malloc(end - begin + 1);
    if (!copy) return;
    memcpy(copy, text->data + begin, end - begin);
    fuzz_splice(text, to, to, copy, end - begin);
    free(copy);
}

void fuzz_mutate_lines(fuzz_text *text, uint32_t *random) {
    size_t begin, end;
    switch (text->size ? fuzz_random(random, 6) : 5) {
    case 0:
    case 1:
        replace_token(text, random);
        break;
    case 2:
        copy_line(text, random);
        break;
    case 3:
        begin = line_at(text, random, &end);
        fuzz_splice(text, begin, end, "", 0);
        break;
    default:
        text->size = LLVMFuzzerMutate(text->data, text->size, text->capacity);
    }
}
