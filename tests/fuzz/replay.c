/* SPDX-License-Identifier: MIT
 *
 * replay.c - runs a target without libFuzzer: `fuzz_asset COUNT PATH...` runs it on each file, each
 * file of each directory, and COUNT mutations of each, which are the same on every machine. Each
 * file has a process of its own; where that dies, the bytes that killed it are left in
 * ./crash-<file>.
 */
#include "fuzz.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

/* Mutations are mutated again up to FRESH times; with more, nothing of the seed would be left. */
enum { MOST_BYTES = 1 << 16, MOST_PATH = 1024, FRESH = 8 };

typedef struct replay {
    unsigned long count; /* mutations of each file */
    unsigned long files, failures;
    /* Shared with the parent: 0 for the file itself, i for its i-th mutation. */
    volatile unsigned long *at;
} replay;

static uint32_t mutations = 1; /* the state of LLVMFuzzerMutate */

/* Does the simplest things that libFuzzer does: it changes bits, bytes and runs of bytes. */
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size) {
    fuzz_text text = {data, size, max_size};
    size_t at = fuzz_random(&mutations, size + 1), run = 1 + fuzz_random(&mutations, 8);
    uint8_t bytes[8];
    for (size_t i = 0; i < sizeof bytes; ++i) bytes[i] = (uint8_t)fuzz_random(&mutations, 256);
    size_t end = run < size - at ? at + run : size;
    switch (at < size ? fuzz_random(&mutations, 5) : 0) {
    case 0:
        fuzz_splice(&text, at, at, bytes, run);
        break;
    case 1:
        data[at] = bytes[0];
        break;
    case 2:
        data[at] ^= (uint8_t)(1u << (bytes[0] & 7));
        break;
    case 3:
        fuzz_splice(&text, at, end, "", 0);
        break;
    default:
        fuzz_splice(&text, at, end, bytes, run);
    }
    return text.size;
}

/* ---- one file ----------------------------------------------------------------------------- */

/* Copies the input to a block of exactly its size, so that reading a byte too far is noticed. */
static void run(const uint8_t *data, size_t size) {
    uint8_t *copy = malloc(size ? size : 1);
    if (!copy) abort();
    memcpy(copy, data, size);
    LLVMFuzzerTestOneInput(copy, size);
    free(copy);
}

/* Makes the index-th mutation of seed (index >= 1) from the one before; text has room. */
static void mutate(const fuzz_text *seed, unsigned long index, fuzz_text *text) {
    if ((index - 1) % FRESH == 0) {
        memcpy(text->data, seed->data, seed->size);
        text->size = seed->size;
        mutations = (uint32_t)index * 2654435761u | 1;
    }
    text->size = LLVMFuzzerCustomMutator(text->data, text->size, text->capacity, (unsigned)index);
}

static void run_all(const replay *r, const fuzz_text *seed, fuzz_text *text) {
    *r->at = 0;
    run(seed->data, seed->size);
    for (unsigned long i = 1; i <= r->count; ++i) {
        *r->at = i;
        mutate(seed, i, text);
        run(text->data, text->size);
    }
}

static void keep_crash(const replay *r, const char *path, const fuzz_text *seed, fuzz_text *text) {
    char name[MOST_PATH];
    const char *slash = strrchr(path, '/');
    snprintf(name, sizeof name, "crash-%s", slash ? slash + 1 : path);
    const fuzz_text *bytes = *r->at ? text : seed;
    for (unsigned long i = *r->at ? *r->at - (*r->at - 1) % FRESH : 1; i <= *r->at; ++i)
        mutate(seed, i, text);
    FILE *file = fopen(name, "wb");
    if (file) {
        fwrite(bytes->data, 1, bytes->size, file);
        fclose(file);
    }
    fprintf(stderr, "%s, mutation %lu: see %s\n", path, *r->at, name);
}

static void replay_bytes(replay *r, const char *path, const fuzz_text *seed, fuzz_text *text) {
    pid_t child = fork();
    if (child == 0) {
        run_all(r, seed, text);
        exit(0);
    }
    int status = 1;
    if (child > 0) waitpid(child, &status, 0);
    ++r->files;
    if (!status) return;
    ++r->failures;
    keep_crash(r, path, seed, text);
}

static void replay_file(replay *r, const char *path) {
    static uint8_t seed_bytes[MOST_BYTES], bytes[MOST_BYTES];
    FILE *file = fopen(path, "rb");
    fuzz_text seed = {seed_bytes, file ? fread(seed_bytes, 1, MOST_BYTES, file) : 0, MOST_BYTES};
    fuzz_text text = {bytes, 0, MOST_BYTES};
    if (file) {
        fclose(file);
        replay_bytes(r, path, &seed, &text);
    } else {
        fprintf(stderr, "%s: cannot be read\n", path);
        ++r->failures;
    }
}

/* ---- all ---------------------------------------------------------------------------------- */

static void replay_path(replay *r, const char *path) {
    struct stat status;
    if (stat(path, &status) || !S_ISDIR(status.st_mode)) {
        replay_file(r, path);
        return;
    }
    struct dirent **entries = NULL;
    int count = scandir(path, &entries, NULL, alphasort);
    for (int i = 0; i < count; ++i) {
        char name[MOST_PATH];
        snprintf(name, sizeof name, "%s/%s", path, entries[i]->d_name);
        if (entries[i]->d_name[0] != '.') replay_file(r, name);
        free(entries[i]);
    }
    free(entries);
}

int main(int argc, char **argv) {
    replay r = {.count = argc > 1 ? strtoul(argv[1], NULL, 10) : 0};
    r.at = mmap(NULL, sizeof *r.at, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (r.at == MAP_FAILED) return 1;
    for (int i = 2; i < argc; ++i) replay_path(&r, argv[i]);
    printf("%lu files, %lu runs, %lu failures\n", r.files, r.files * (r.count + 1), r.failures);
    return r.failures || !r.files;
}
