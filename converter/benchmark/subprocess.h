/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * subprocess.h - runs another program and reads the first line that it prints.
 */
#ifndef PHONGSPLAT_BENCHMARK_SUBPROCESS_H
#define PHONGSPLAT_BENCHMARK_SUBPROCESS_H

#include <stddef.h>

/* Runs arguments[0] (looked up in PATH where it has no slash), NULL at the end, without standard
 * input and with its output thrown away, but for the first line, which goes into line (may be
 * NULL). Returns its exit code, or -1 where it cannot be run or was killed. */
int psplat_subprocess_run(const char *const *arguments, char *line, size_t size);

#endif
