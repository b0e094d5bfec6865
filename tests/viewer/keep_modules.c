/* SPDX-License-Identifier: MIT
 *
 * keep_modules.c - keeps graphics drivers loaded in programs under the leak checker. Once a driver
 * is unloaded, its functions have no names any more by which lsan.supp (tests/support) could ignore
 * their leaks.
 */
int dlclose(void *handle);

int dlclose(void *handle) {
    (void)handle;
    return 0;
}
