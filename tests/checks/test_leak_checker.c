/* SPDX-License-Identifier: MIT
 *
 * test_leak_checker.c - tests that the leak checker sees leaks and does not crash. The one of gcc
 * 12 and clang 14 takes a thread-local block whose address is 16 bytes past a page for one of glibc
 * 2.19. It then reads the block's bounds from the bytes before it (DTLS_on_tls_get_addr in
 * sanitizer_tls_get_addr.cpp), which are no addresses: the process ends with "Tracer caught signal
 * 11" whenever the heap happens to put a driver's block there. phongsplat_test_settings turns that
 * guess off (intercept_tls_get_addr=0). Blocks are still searched for pointers, because the loader
 * requested their memory.
 */
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Small blocks come one after the other: the function takes them until the next one lies 16 bytes
 * past a page. All are reachable from the last. */
static void *fill_page(void) {
    void **last = NULL;
    uintptr_t step = 0;
    for (int i = 0; i < 10000 && (step == 0 || ((uintptr_t)last + step) % 4096 != 16); i++) {
        void **next = malloc(sizeof(void *));
        if (!next) abort();
        step = last && next > last ? (uintptr_t)next - (uintptr_t)last : 0;
        *next = last;
        last = next;
    }
    return last;
}

int main(int argc, char **argv) {
    static void *kept;
    void *library = dlopen(PSPLAT_THREAD_LOCAL_BLOCK, RTLD_NOW);
    void **(*block)(void);
    void *symbol = library ? dlsym(library, "psplat_thread_local_block") : NULL;
    if (!symbol) {
        fprintf(stderr, "no library: %s\n", dlerror());
        return 1;
    }
    memcpy(&block, &symbol, sizeof block);
    kept = fill_page();
    void **place = block(); /* the block is allocated now */
    printf("block at %p, after %p\n", (void *)place, kept);
    if ((uintptr_t)place % 4096 != 16) return 1;
    *place = malloc(100); /* not a leak, although only the block knows it */
    if (argc > 1 && strcmp(argv[1], "leak") == 0) *place = NULL;
    return 0;
}
