/* SPDX-License-Identifier: MIT
 *
 * races.c - data races that tests/tsan.sh must report, and threads that it must not report. Without
 * both, its silence about the tested programs would prove nothing. It is called as: races threads |
 * openmp | none.
 */
#include <pthread.h>
#include <stdio.h>
#include <string.h>

enum { COUNT = 1000 };

static long shared;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void *count_unlocked(void *unused) {
    for (int i = 0; i < COUNT; ++i) ++shared;
    return unused;
}

static void *count_locked(void *unused) {
    for (int i = 0; i < COUNT; ++i) {
        pthread_mutex_lock(&lock);
        ++shared;
        pthread_mutex_unlock(&lock);
    }
    return unused;
}

static void run_twice(void *(*work)(void *)) {
    pthread_t threads[2];
    for (int i = 0; i < 2; ++i) pthread_create(&threads[i], NULL, work, NULL);
    for (int i = 0; i < 2; ++i) pthread_join(threads[i], NULL);
}

/* Each thread needs what another one wrote; the end of a loop is a barrier, so that there is no
 * race. */
static long sum_in_order(void) {
    long squares[COUNT], sum = 0;
#pragma omp parallel for
    for (long i = 0; i < COUNT; ++i) squares[i] = i * i;
#pragma omp parallel for reduction(+ : sum)
    for (long i = 0; i < COUNT; ++i) sum += squares[COUNT - 1 - i];
    return sum;
}

static long sum_unprotected(void) {
    long sum = 0;
#pragma omp parallel for
    for (long i = 0; i < COUNT; ++i) sum += i;
    return sum;
}

int main(int argc, char **argv) {
    const char *kind = argc > 1 ? argv[1] : "";
    if (!strcmp(kind, "threads")) run_twice(count_unlocked);
    if (!strcmp(kind, "openmp")) shared = sum_unprotected();
    if (!strcmp(kind, "none")) {
        run_twice(count_locked);
        shared += sum_in_order();
    }
    printf("%ld\n", shared);
    return shared == 0;
}
