/* SPDX-License-Identifier: MIT
 *
 * meter.c - measures a reader's memory and time; see fuzz.h.
 */
#include "fuzz.h"

#include <stdlib.h>
#include <time.h>

static void *resize_metered(void *user, void *memory, size_t old_size, size_t new_size) {
    fuzz_meter *meter = user;
    FUZZ_DEMAND(meter->bytes >= old_size && (memory != NULL) == (old_size != 0));
    void *resized = NULL;
    if (new_size) {
        if (++meter->calls == meter->fail_at) return NULL;
        resized = realloc(memory, new_size);
        if (!resized) return NULL;
    } else {
        free(memory);
    }
    meter->bytes += new_size - old_size;
    if (meter->bytes > meter->peak) meter->peak = meter->bytes;
    return resized;
}

psplat_allocator fuzz_meter_allocator(fuzz_meter *meter) {
    return (psplat_allocator){.resize = resize_metered, .user = meter};
}

/* Returns the time of this process instead of the wall clock's, because other work on the machine
 * must not count. */
static double processor_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

void fuzz_meter_start(fuzz_meter *meter) {
    meter->start = processor_seconds();
}

void fuzz_meter_stop(const fuzz_meter *meter, double seconds) {
    FUZZ_DEMAND(processor_seconds() - meter->start < seconds);
}
