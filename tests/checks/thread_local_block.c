/* SPDX-License-Identifier: MIT
 *
 * A library as a graphics driver is one: loaded late, with a variable of each thread's own. */
void **psplat_thread_local_block(void);

void **psplat_thread_local_block(void) {
    static _Thread_local void *block;
    return &block;
}
