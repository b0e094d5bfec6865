/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * page.h - all of a sweep as one HTML file.
 */
#ifndef PHONGSPLAT_TRADEOFF_PAGE_H
#define PHONGSPLAT_TRADEOFF_PAGE_H

#include "table/sweep_table.h"
#include "table/text.h"

/* Adds the page, which is self-contained and has no scripts. It shows the source and the machine's
 * graphics, the front with the pictures that lie in the folder, the charts there unless has_charts
 * is 0, and every row. */
void psplat_page_write(const psplat_sweep_table *table, const char *folder, int has_charts,
                       psplat_text *text);

#endif
