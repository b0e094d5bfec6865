/* SPDX-License-Identifier: MIT
 *
 * ledger.h - an allocator that counts live memory and can fail.
 */
#ifndef PHONGSPLAT_TEST_LEDGER_H
#define PHONGSPLAT_TEST_LEDGER_H

#include <phongsplat/phongsplat.h>

#include <stdlib.h>

typedef struct ledger {
    size_t bytes; /* live bytes, by the sizes handed back: wrong sizes leave a rest */
    int calls;    /* calls that requested memory */
    int fail_at;  /* the call, counted from 0, that fails; -1: none */
} ledger;

static inline void *ledger_resize(void *user, void *memory, size_t old_size, size_t new_size) {
    ledger *l = user;
    if (new_size && l->calls++ == l->fail_at) return NULL;
    l->bytes += new_size - old_size;
    if (new_size) return realloc(memory, new_size);
    free(memory);
    return NULL;
}

static inline psplat_allocator ledger_allocator(ledger *l) {
    return (psplat_allocator){.resize = ledger_resize, .user = l};
}

#endif
