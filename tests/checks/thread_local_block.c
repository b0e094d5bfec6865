/* SPDX-License-Identifier: MIT
 *
 * thread_local_block.c - a library that resembles a graphics driver: it is loaded late and has a
 * variable for each thread.
 */
void **psplat_thread_local_block(void);

void **psplat_thread_local_block(void) {
    static _Thread_local void *block;
    return &block;
}
