/* SPDX-License-Identifier: MIT
 *
 * fuzz.h - what the fuzz targets share. A target is fuzz_<name>.c with one LLVMFuzzerTestOneInput.
 * Its seeds are in corpus/<name>, inputs that once failed in findings/<name>, and its words in
 * dictionaries/<name>.dict. Built with clang and -DPHONGSPLAT_FUZZ=ON it is a libFuzzer program;
 * otherwise replay.c runs it on seeds, findings and a fixed number of their mutations.
 */
#ifndef PHONGSPLAT_FUZZ_H
#define PHONGSPLAT_FUZZ_H

#include <phongsplat/phongsplat.h>

#include <stdio.h>
#include <stdlib.h>

/* These names are prescribed by libFuzzer. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

/* Demands what must hold for every input, in every build. */
#define FUZZ_DEMAND(condition)                                                                     \
    ((condition)                                                                                   \
         ? (void)0                                                                                 \
         : (fprintf(stderr, "%s:%d: demanded: %s\n", __FILE__, __LINE__, #condition), abort()))

/* ---- meter.c: what a reader takes ---------------------------------------------------------- */

/* Measures memory requested from an allocator and processor time. Initialise with zeros. */
typedef struct fuzz_meter {
    size_t bytes, peak;    /* live now, and at most so far */
    size_t calls, fail_at; /* calls for memory, and the one that fails; 0: none fails */
    double start;          /* seconds of processor time */
} fuzz_meter;

/* Returns an allocator that counts. Every size that is handed back must be the one that was
 * requested. */
psplat_allocator fuzz_meter_allocator(fuzz_meter *meter);
void fuzz_meter_start(fuzz_meter *meter);
/* Demands that less than the given seconds of processor time have gone by. */
void fuzz_meter_stop(const fuzz_meter *meter, double seconds);

/* ---- chance ------------------------------------------------------------------------------- */

/* Returns a number from 0 to bound - 1 by xorshift32, whose state must not be 0. */
static inline uint32_t fuzz_random(uint32_t *state, size_t bound) {
    *state ^= *state << 13;
    *state ^= *state >> 17;
    *state ^= *state << 5;
    return (uint32_t)(*state % bound);
}

/* ---- mutate*.c ----------------------------------------------------------------------------- */

/* Bytes that are changed in place, with room for more. */
typedef struct fuzz_text {
    uint8_t *data;
    size_t size, capacity;
} fuzz_text;

/* Replaces the bytes from begin to end by others, which must not lie in the text. Returns 0 where
 * there is no room for them. */
int fuzz_splice(fuzz_text *text, size_t begin, size_t end, const void *bytes, size_t size);

/* Changes a JSON document so that it mostly stays one: values are replaced, moved, dropped and
 * doubled, and members that the readers know are added. */
void fuzz_mutate_json(fuzz_text *text, uint32_t *random);

/* These change binary data as floats and small integers, or a text as numbers and lines. */
void fuzz_mutate_binary(fuzz_text *text, uint32_t *random);
void fuzz_mutate_lines(fuzz_text *text, uint32_t *random);

#endif
