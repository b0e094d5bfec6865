/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * row.h - a setting and what was measured of it.
 */
#ifndef PHONGSPLAT_TABLE_ROW_H
#define PHONGSPLAT_TABLE_ROW_H

#include "table/setting.h"

/* X(CONSTANT, name). Units are in the names; distances are % of the source's diagonal, angles
 * degrees, areas and differences % (see
 * compare/shape_errors.h and views/image_metrics.h). They stand in the order in which they are
 * measured: first the asset and its shape, then pictures, then times (medians and quartiles). */
#define PSPLAT_COLUMNS(X)                                                                          \
    X(BYTES, bytes)                                                                                \
    X(ELEMENTS, elements) /* splats, or triangles */                                               \
    X(CONVERT_S, convert_s)                                                                        \
    X(BROKEN, broken_promises)                                                                     \
    X(DISTANCE_MAX, distance_max)                                                                  \
    X(DISTANCE_RMS, distance_rms)                                                                  \
    X(DISTANCE_P95, distance_p95)                                                                  \
    X(OUTWARD_MAX, outward_max)                                                                    \
    X(OUTWARD_RMS, outward_rms)                                                                    \
    X(OUTWARD_P95, outward_p95)                                                                    \
    X(INWARD_MAX, inward_max)                                                                      \
    X(INWARD_RMS, inward_rms)                                                                      \
    X(INWARD_P95, inward_p95)                                                                      \
    X(NORMAL_MAX, normal_max)                                                                      \
    X(NORMAL_RMS, normal_rms)                                                                      \
    X(NORMAL_P95, normal_p95)                                                                      \
    X(FACE_NORMAL_MAX, face_normal_max)                                                            \
    X(FACE_NORMAL_RMS, face_normal_rms)                                                            \
    X(FACE_NORMAL_P95, face_normal_p95)                                                            \
    X(CREASE_NORMAL_MAX, crease_normal_max)                                                        \
    X(CREASE_NORMAL_RMS, crease_normal_rms)                                                        \
    X(CREASE_NORMAL_P95, crease_normal_p95)                                                        \
    X(CREASE_AREA, crease_area)                                                                    \
    X(CREASE_WIDTH, crease_width)                                                                  \
    X(UNCOVERED_AREA, uncovered_area)                                                              \
    X(OVERHANG_AREA, overhang_area)                                                                \
    X(REACH, reach)                                                                                \
    X(SOURCE_SAMPLES, source_samples)                                                              \
    X(TARGET_SAMPLES, target_samples)                                                              \
    X(PSNR, psnr_db)                                                                               \
    X(SSIM, ssim)                                                                                  \
    X(DIFFERENCE, difference)                                                                      \
    X(INSIDE, inside_difference)                                                                   \
    X(DISTANT, distant_difference)                                                                 \
    X(MISSING, missing_pixels)                                                                     \
    X(EXTRA, extra_pixels)                                                                         \
    X(OUTLINE, outline_pixels) /* missing and extra */                                             \
    X(COVERED, covered_pixels)                                                                     \
    X(FRAMES, frames) /* that were timed */                                                        \
    X(LOAD_MS, load_ms)                                                                            \
    X(CPU_MS, cpu_ms)                                                                              \
    X(CPU_MS_Q1, cpu_ms_q1)                                                                        \
    X(CPU_MS_Q3, cpu_ms_q3)                                                                        \
    X(WALL_MS, wall_ms)                                                                            \
    X(WALL_MS_Q1, wall_ms_q1)                                                                      \
    X(WALL_MS_Q3, wall_ms_q3)                                                                      \
    X(GPU_MS, gpu_ms)                                                                              \
    X(GPU_MS_Q1, gpu_ms_q1)                                                                        \
    X(GPU_MS_Q3, gpu_ms_q3)

typedef enum psplat_column {
#define PSPLAT_COLUMN_ENUM(constant, name) PSPLAT_COLUMN_##constant,
    PSPLAT_COLUMNS(PSPLAT_COLUMN_ENUM)
#undef PSPLAT_COLUMN_ENUM
        PSPLAT_COLUMN_COUNT
} psplat_column;

/* All rows of one asset share the columns before this one. */
enum { PSPLAT_FIRST_PICTURE_COLUMN = PSPLAT_COLUMN_PSNR };

typedef struct psplat_row {
    psplat_setting setting;
    double values[PSPLAT_COLUMN_COUNT]; /* NaN: not measured, or not to be had */
    int is_measured;                    /* 1: all but the times is known */
    char *key; /* the cells before the values (see sweep_table.h), owned by the table */
} psplat_row;

extern const char *const psplat_row_value_names[PSPLAT_COLUMN_COUNT];
psplat_row psplat_row_empty(const psplat_setting *setting);

/* Tells which time stands for what a frame costs: the GPU's where every drawn row has it, else the
 * CPU's of all threads, since software GL draws with the CPU, and wall-clock time includes what
 * else the machine does. */
psplat_column psplat_rows_cost(const psplat_row *rows, size_t count);

#endif
