/* SPDX-License-Identifier: MIT
 *
 * files.h - reading of whole files with the host's callback, or with stdio where the host gave
 * none.
 */
#ifndef PHONGSPLAT_CORE_FILES_H
#define PHONGSPLAT_CORE_FILES_H

#include <phongsplat/phongsplat.h>

/* Returns *files, or a reader with stdio where files is NULL or zero-initialised. */
psplat_files psplat_files_default(const psplat_files *files);

#endif
