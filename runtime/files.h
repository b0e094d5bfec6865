/* SPDX-License-Identifier: MIT
 * files.h - whole files through the host's callback, or through stdio where it gave none. */
#ifndef PHONGSPLAT_FILES_H
#define PHONGSPLAT_FILES_H

#include <phongsplat/phongsplat.h>

/* Stdio where files is NULL or zero-initialised, else files itself. */
psplat_files psplat_files_default(const psplat_files *files);

#endif
