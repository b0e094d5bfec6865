/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * tradeoff.h - what a setting costs and what it buys, on the user's own model, in flow order:
 *
 *     options -> settings -> rows -> journal, sweep -> front -> advice, charts, page
 *
 * A sweep converts one mesh by a ladder of tolerances and two kinds of normal fields, measures each
 * conversion with compare.h, draws it in each mode with and without filter, and times them all in
 * turn. What is measured is kept in a directory that is at once result and journal: tradeoff.csv,
 * assets, charts, a page. Nothing prints but the command line. Numbers are written and read in the
 * C locale, which the command line never leaves.
 */
#ifndef PHONGSPLAT_TRADEOFF_H
#define PHONGSPLAT_TRADEOFF_H

#include "compare.h"

/* ---- text.c: text that grows ----------------------------------------------------------------- */

/* Zero-initialised. After a failed allocation further calls do nothing. */
typedef struct psplat_text {
    char *data; /* terminated, from malloc, owned by the caller; NULL while empty */
    size_t size, capacity;
    int failed;
} psplat_text;

void psplat_text_add(psplat_text *text, const char *format, ...)
#if defined(__GNUC__)
    __attribute__((format(printf, 2, 3)))
#endif
    ;
/* The shortest decimal that reads back as the same number; nothing where it is NaN. */
void psplat_text_number(psplat_text *text, double number);
/* For people: three significant digits, thousands apart ("1.23", "12.3", "12,345"); a dash for NaN.
 */
void psplat_text_figure(psplat_text *text, double number);
/* Bytes that mean something in XML become entities, control characters question marks. */
void psplat_text_escaped(psplat_text *text, const char *raw);
/* As one word of a shell's command line. */
void psplat_text_quoted(psplat_text *text, const char *raw);
/* MEMORY where a call has failed. */
psplat_result psplat_text_check(const psplat_text *text, psplat_error *error);

/* ---- stamp.c: what a measurement was made of ------------------------------------------------- */

/* FNV-1a, 64 bits. Begin with PSPLAT_STAMP; a stamp is never 0, which stands for "not measured". */
#define PSPLAT_STAMP UINT64_C(0xcbf29ce484222325)
uint64_t psplat_stamp_bytes(uint64_t stamp, const void *data, size_t size);
uint64_t psplat_stamp_number(uint64_t stamp, double number);
uint64_t psplat_stamp_text(uint64_t stamp, const char *text);

/* ---- options.c: what a sweep goes through ---------------------------------------------------- */

enum { PSPLAT_MOST_STEPS = 16 };

/* A ladder of numbers. */
typedef struct psplat_ladder {
    double steps[PSPLAT_MOST_STEPS]; /* descending, all different */
    size_t count;
} psplat_ladder;

/* "2,1,0.5" with an optional % sign after each, in any order. Returns 0 where text is anything
 * else, or a number is not within min ... max. */
int psplat_ladder_read(const char *text, double min, double max, psplat_ladder *ladder);

/* Zeros (no steps) mean not given: what the directory's journal says, else the default. */
typedef struct psplat_tradeoff_options {
    psplat_ladder tolerances; /* %; default 2, 1, 0.5, 0.2, 0.1 */
    psplat_ladder ratios;     /* of triangles that gltfpack keeps; default 0.5 ... 0.01 */
    double normal_tolerance;  /* as psplat_convert_desc has them */
    double crease_angle;
    int no_creases;
    int effort;
    uint64_t seed;
    int samples;    /* of shape comparisons; default that of psplat_shape_desc */
    int size;       /* pictures are so many pixels wide and high; default 512 */
    int frames;     /* of each setting that are timed; default 24 */
    int perceptual; /* 1: psplat_picture_errors.perceptual too */
} psplat_tradeoff_options;

/* Fills what is not given in options from others. */
void psplat_tradeoff_options_inherit(psplat_tradeoff_options *options,
                                     const psplat_tradeoff_options *others);
psplat_tradeoff_options psplat_tradeoff_options_default(void);
/* As one line "options tolerances=2,1 effort=3" of what is given, and back. Read returns 0 where
 * the line is none of ours. */
void psplat_tradeoff_options_write(const psplat_tradeoff_options *options, psplat_text *text);
int psplat_tradeoff_options_read(const char *line, psplat_tradeoff_options *options);

/* ---- setting.c: one way to convert and draw ---------------------------------------------------
 */

typedef enum psplat_contender {
    PSPLAT_CONTENDER_MESH = 0, /* the source itself */
    PSPLAT_CONTENDER_SPLATS,
    PSPLAT_CONTENDER_GLTFPACK, /* a simplified mesh */
    PSPLAT_CONTENDER_COUNT
} psplat_contender;

typedef enum psplat_normal_field {
    PSPLAT_FIELD_LINEAR = 0, /* Phong splats */
    PSPLAT_FIELD_CONSTANT,   /* one normal a splat */
    PSPLAT_FIELD_COUNT
} psplat_normal_field;

/* How the asset stores its numbers. */
typedef enum psplat_stored_as {
    PSPLAT_PRECISION_FLOAT = 0,
    PSPLAT_PRECISION_COUNT
} psplat_stored_as;

enum { PSPLAT_DRAWN_MODES = PSPLAT_MODE_PARAMETERS }; /* phong, gaussian, flat */

/* Fields that mean nothing to a contender are 0. */
typedef struct psplat_setting {
    psplat_contender contender;
    double tolerance; /* %, of splats */
    double ratio;     /* of triangles kept, of gltfpack */
    psplat_normal_field field;
    psplat_stored_as precision;
    psplat_mode mode;
    int no_filter;
} psplat_setting;

extern const char *const psplat_contender_names[PSPLAT_CONTENDER_COUNT + 1];
extern const char *const psplat_field_names[PSPLAT_FIELD_COUNT + 1];
extern const char *const psplat_precision_names[PSPLAT_PRECISION_COUNT + 1];
extern const char *const psplat_mode_names[PSPLAT_DRAWN_MODES + 1];
extern const char *const psplat_filter_names[3]; /* "on", "off" */

int psplat_setting_is_same(const psplat_setting *a, const psplat_setting *b);
/* Whether both draw the same file. */
int psplat_setting_shares_asset(const psplat_setting *a, const psplat_setting *b);
/* "linear-0.5.glb", "gltfpack-0.1.glb"; "" of the source. */
void psplat_setting_file(const psplat_setting *setting, psplat_text *text);
/* "0.5 %, linear, phong, no filter", "gltfpack -si 0.1", "source mesh". */
void psplat_setting_describe(const psplat_setting *setting, psplat_text *text);
/* The command that makes the asset: "phongsplat convert part.obj part.glb --tolerance 0.5%". */
void psplat_setting_command(const psplat_setting *setting, const psplat_tradeoff_options *options,
                            const char *source, psplat_text *text);

/* ---- row.c: a setting and what was measured of it -------------------------------------------- */

/* X(NAME, column, group): group is what measures it. Units are in the names; distances are % of the
 * source's diagonal, angles degrees, areas % (see compare.h). */
#define PSPLAT_COLUMNS(X)                                                                          \
    X(BYTES, bytes, MADE)                                                                          \
    X(ELEMENTS, elements, MADE) /* splats, or triangles */                                         \
    X(CONVERT_S, convert_s, MADE)                                                                  \
    X(BROKEN, broken_promises, MADE)                                                               \
    X(DISTANCE_MAX, distance_max, SHAPED)                                                          \
    X(DISTANCE_RMS, distance_rms, SHAPED)                                                          \
    X(DISTANCE_P95, distance_p95, SHAPED)                                                          \
    X(OUTWARD_MAX, outward_max, SHAPED)                                                            \
    X(OUTWARD_RMS, outward_rms, SHAPED)                                                            \
    X(OUTWARD_P95, outward_p95, SHAPED)                                                            \
    X(INWARD_MAX, inward_max, SHAPED)                                                              \
    X(INWARD_RMS, inward_rms, SHAPED)                                                              \
    X(INWARD_P95, inward_p95, SHAPED)                                                              \
    X(NORMAL_MAX, normal_max, SHAPED)                                                              \
    X(NORMAL_RMS, normal_rms, SHAPED)                                                              \
    X(NORMAL_P95, normal_p95, SHAPED)                                                              \
    X(FACE_NORMAL_MAX, face_normal_max, SHAPED)                                                    \
    X(FACE_NORMAL_RMS, face_normal_rms, SHAPED)                                                    \
    X(FACE_NORMAL_P95, face_normal_p95, SHAPED)                                                    \
    X(CREASE_NORMAL_MAX, crease_normal_max, SHAPED)                                                \
    X(CREASE_NORMAL_RMS, crease_normal_rms, SHAPED)                                                \
    X(CREASE_NORMAL_P95, crease_normal_p95, SHAPED)                                                \
    X(CREASE_AREA, crease_area, SHAPED)                                                            \
    X(CREASE_WIDTH, crease_width, SHAPED)                                                          \
    X(UNCOVERED_AREA, uncovered_area, SHAPED)                                                      \
    X(OVERHANG_AREA, overhang_area, SHAPED)                                                        \
    X(REACH, reach, SHAPED)                                                                        \
    X(SOURCE_SAMPLES, source_samples, SHAPED)                                                      \
    X(TARGET_SAMPLES, target_samples, SHAPED)                                                      \
    X(PSNR, psnr_db, PICTURED)                                                                     \
    X(SSIM, ssim, PICTURED)                                                                        \
    X(DIFFERENCE, difference, PICTURED)                                                            \
    X(INSIDE, inside_difference, PICTURED)                                                         \
    X(DISTANT, distant_difference, PICTURED)                                                       \
    X(MISSING, missing_pixels, PICTURED)                                                           \
    X(EXTRA, extra_pixels, PICTURED)                                                               \
    X(PERCEPTUAL, perceptual, PICTURED)                                                            \
    X(COVERED, covered_pixels, PICTURED)                                                           \
    X(LOAD_MS, load_ms, TIMED)                                                                     \
    X(CPU_MS, cpu_ms, TIMED)                                                                       \
    X(CPU_MS_Q1, cpu_ms_q1, TIMED)                                                                 \
    X(CPU_MS_Q3, cpu_ms_q3, TIMED)                                                                 \
    X(WALL_MS, wall_ms, TIMED)                                                                     \
    X(WALL_MS_Q1, wall_ms_q1, TIMED)                                                               \
    X(WALL_MS_Q3, wall_ms_q3, TIMED)                                                               \
    X(GPU_MS, gpu_ms, TIMED)                                                                       \
    X(GPU_MS_Q1, gpu_ms_q1, TIMED)                                                                 \
    X(GPU_MS_Q3, gpu_ms_q3, TIMED)

typedef enum psplat_column {
#define PSPLAT_COLUMN_ENUM(name, column, group) PSPLAT_COLUMN_##name,
    PSPLAT_COLUMNS(PSPLAT_COLUMN_ENUM)
#undef PSPLAT_COLUMN_ENUM
        PSPLAT_COLUMN_COUNT
} psplat_column;

/* What measures at once, in the order in which it happens. */
typedef enum psplat_group {
    PSPLAT_GROUP_MADE = 0, /* the asset */
    PSPLAT_GROUP_SHAPED,   /* psplat_shape_errors of it */
    PSPLAT_GROUP_PICTURED, /* psplat_picture_errors of the setting, all views as one picture */
    PSPLAT_GROUP_TIMED,    /* medians and quartiles */
    PSPLAT_GROUP_COUNT
} psplat_group;

typedef struct psplat_row {
    psplat_setting setting;
    double values[PSPLAT_COLUMN_COUNT];  /* NaN: not measured, or not to be had */
    uint64_t stamps[PSPLAT_GROUP_COUNT]; /* of what each group was measured on; 0: not measured */
    uint64_t content;                    /* stamp of the asset's bytes */
} psplat_row;

extern const char *const psplat_group_names[PSPLAT_GROUP_COUNT + 1];
psplat_row psplat_row_empty(const psplat_setting *setting);
const char *psplat_column_name(psplat_column column);
psplat_group psplat_column_group(psplat_column column);
/* Copies the values and the stamp of a group. */
void psplat_row_copy(psplat_row *to, const psplat_row *from, psplat_group group);
void psplat_row_forget(psplat_row *row, psplat_group group);

/* Which time stands for what a frame costs: the GPU's where every drawn row has it, else the CPU's
 * of all threads, since software GL draws with the CPU, and a clock on the wall measures what else
 * the machine does. */
psplat_column psplat_rows_cost(const psplat_row *rows, size_t count);

/* ---- journal.c: rows as CSV ------------------------------------------------------------------ */

enum { PSPLAT_JOURNAL_TEXT = 1024 };

typedef struct psplat_journal {
    psplat_tradeoff_options options;
    char source[PSPLAT_JOURNAL_TEXT];   /* its path as the sweep was given it, for people */
    char graphics[PSPLAT_JOURNAL_TEXT]; /* GL_RENDERER, GL_VERSION */
    char gltfpack[PSPLAT_JOURNAL_TEXT]; /* its version; "": none */
    psplat_row *rows;
    size_t count;
} psplat_journal;

void psplat_journal_free(psplat_journal *journal);
/* Comment lines (#) with what the struct has beside rows, a line of names, and a line a row, each
 * of both ending in a check sum, so that a changed cell is noticed. Numbers are exact. */
void psplat_journal_write(const psplat_journal *journal, psplat_text *text);
/* The reverse; text need not be terminated. FORMAT, its text naming line and cause, for what was
 * cut off within a line or changed by hand; MEMORY. Lines cut off whole are rows to measure again.
 */
psplat_result psplat_journal_read(const char *text, size_t size, psplat_journal *journal,
                                  psplat_error *error);

/* ---- folder.c: the directory ----------------------------------------------------------------- */

typedef struct psplat_folder {
    char *path; /* owned */
    int lock;   /* descriptor; the kernel releases the lock with the process */
} psplat_folder;

/* Makes the directory where there is none, and locks it. Refuses one that holds anything but was
 * not made by this, and one that another process has locked: WRITE. Removes what a killed process
 * has left half-written. */
psplat_result psplat_folder_open(const char *path, psplat_folder *folder, psplat_error *error);
void psplat_folder_close(psplat_folder *folder);
/* The path of a file in it, from malloc; NULL where memory ran out. */
char *psplat_folder_path(const psplat_folder *folder, const char *name);
/* psplat_output_write over what is there. */
psplat_result psplat_folder_write(const psplat_folder *folder, const char *name, const void *data,
                                  size_t size, psplat_error *error);
/* Whole file, from malloc. *data is NULL and the result OK where there is none. */
psplat_result psplat_folder_read(const psplat_folder *folder, const char *name, char **data,
                                 size_t *size, psplat_error *error);
/* psplat_stamp_bytes of a file; 0: not there, or not readable. */
uint64_t psplat_folder_stamp(const psplat_folder *folder, const char *name, size_t *size);

/* ---- wavefront.c: a mesh as OBJ -------------------------------------------------------------- */

/* In the coordinates of the source's file, with the normals that the converter sees, so that a
 * simplifier starts from what the splats started from. */
void psplat_wavefront_write(const psplat_original *original, psplat_text *text);

/* ---- program.c: other programs --------------------------------------------------------------- */

/* Runs arguments[0] (looked up in PATH where it has no slash), NULL at the end, without standard
 * input and with its output thrown away, but for the first line, which goes into line (may be
 * NULL). Returns its exit code, or -1 where it cannot be run or was killed. */
int psplat_program_run(const char *const *arguments, char *line, size_t size);

/* ---- gltfpack.c: what a mesh simplifier makes of the source ---------------------------------- */

/* Of meshoptimizer. Simplified with attributes in mind (-sv) to a ratio of the triangles (-si) at
 * whatever error it takes (-se 1). */
typedef struct psplat_gltfpack {
    const char *program;               /* as given, or "gltfpack" */
    char version[PSPLAT_JOURNAL_TEXT]; /* as it calls itself; "": cannot be run */
} psplat_gltfpack;

/* program NULL: the one in PATH, if there is. */
psplat_gltfpack psplat_gltfpack_find(const char *program);
/* Writes the compressed file (-cc), for its bytes, or the plain one (-noq: we cannot read
 * EXT_meshopt_compression) of the same triangles. output must end in .glb. READ where it fails. */
psplat_result psplat_gltfpack_run(const psplat_gltfpack *gltfpack, const char *input, double ratio,
                                  int plain, const char *output, psplat_error *error);

/* ---- workbench.c: what measuring takes, made when it is first needed --------------------------
 */

typedef struct psplat_workbench {
    const char *path; /* the caller's */
    int size, software;
    double crease_angle;
    psplat_mesh mesh;
    uint64_t stamp; /* of the source's bytes and of what was read from them */
    size_t bytes;
    psplat_original *original;
    psplat_host *host;
    psplat_renderer *renderer;
    psplat_gallery *gallery;
} psplat_workbench;

/* Reads the source and makes a graphics context. */
psplat_result psplat_workbench_open(psplat_workbench *bench, psplat_error *error);
void psplat_workbench_close(psplat_workbench *bench);
psplat_result psplat_workbench_original(psplat_workbench *bench, psplat_error *error);
psplat_result psplat_workbench_gallery(psplat_workbench *bench, psplat_error *error);

/* ---- timing.c: frames in turn ---------------------------------------------------------------- */

/* Draws one frame into the framebuffer that is bound. */
typedef struct psplat_contestant {
    psplat_result (*draw)(void *self, const psplat_view *view, psplat_error *error);
    void *self;
} psplat_contestant;

typedef struct psplat_quartiles {
    double median, low, high; /* NaN: not to be had */
} psplat_quartiles;

/* Milliseconds a frame, from an empty framebuffer until GL is done with it. */
typedef struct psplat_frame_times {
    psplat_quartiles cpu; /* of all threads of the process */
    psplat_quartiles wall;
    psplat_quartiles gpu; /* GL_TIME_ELAPSED; NaN in software */
} psplat_frame_times;

typedef struct psplat_timing_desc {
    psplat_host *host;
    const psplat_view *views; /* that take turns; all contestants draw the same one in a round */
    size_t view_count;
    const psplat_contestant *contestants;
    size_t count;
    int frames;                                   /* rounds, after two that do not count */
    int (*progress)(void *user, double fraction); /* not 0: INTERRUPTED; may be NULL */
    void *user;
} psplat_timing_desc;

psplat_result psplat_timing_run(const psplat_timing_desc *desc, psplat_frame_times *times,
                                psplat_error *error);
/* Reorders the values; interpolates between neighbours. */
psplat_quartiles psplat_timing_quartiles(double *values, size_t count);
double psplat_timing_clock(void); /* seconds of a monotonic clock */

/* ---- estimate.c: how much of a sweep is done --------------------------------------------------
 */

typedef enum psplat_task {
    PSPLAT_TASK_CONVERT = 0,
    PSPLAT_TASK_SIMPLIFY,
    PSPLAT_TASK_SHAPE,
    PSPLAT_TASK_PICTURE,
    PSPLAT_TASK_TIME,
    PSPLAT_TASK_COUNT
} psplat_task;

/* Zero-initialised. Shares are of a kind of task alike: of two conversions, one that has twice the
 * share of the other takes about twice as long. */
typedef struct psplat_estimate {
    double planned[PSPLAT_TASK_COUNT]; /* shares */
    double done[PSPLAT_TASK_COUNT];
    double seconds[PSPLAT_TASK_COUNT]; /* that the done ones took */
} psplat_estimate;

/* Fraction of the time of the whole sweep, when of one more task so many shares are done. */
double psplat_estimate_done(const psplat_estimate *estimate, psplat_task task, double shares);
double psplat_estimate_conversion(double tolerance_percent); /* its share */

/* ---- plan.c: the rows of a sweep, and what is known of them -----------------------------------
 */

/* The settings of a sweep, coarse to fine, the source first: rows of one asset follow each other.
 * From malloc. */
psplat_result psplat_plan_rows(const psplat_tradeoff_options *options, int with_gltfpack,
                               psplat_row **rows, size_t *count, psplat_error *error);
/* What the stamp of a group would be if it were measured now. source: of the source; the row's
 * earlier stamps and content are part of it, where they are. */
uint64_t psplat_plan_stamp(const psplat_journal *journal, const psplat_row *row, uint64_t source,
                           psplat_group group);

/* ---- specimen.c: an asset, as it is compared and drawn ----------------------------------------
 */

/* Zero-initialised. */
typedef struct psplat_specimen {
    psplat_asset *asset; /* of splats */
    psplat_model *model;
    psplat_renderer *renderer; /* the model's */
    psplat_mesh mesh;          /* of gltfpack */
    psplat_original *original;
    psplat_gallery *gallery; /* draws it for timing */
} psplat_specimen;

/* Opens a file of splats, or of a mesh. */
psplat_result psplat_specimen_open(psplat_specimen *specimen, psplat_workbench *bench,
                                   const psplat_setting *setting, const char *path,
                                   psplat_error *error);
void psplat_specimen_close(psplat_specimen *specimen);
psplat_result psplat_specimen_shape(const psplat_specimen *specimen, psplat_workbench *bench,
                                    int samples, psplat_row *row, psplat_error *error);
psplat_result psplat_specimen_picture(const psplat_specimen *specimen, psplat_workbench *bench,
                                      int perceptual, psplat_row *row, psplat_error *error);

/* ---- contest.c: all rows timed together --------------------------------------------------------
 */

/* Draws every row of the journal in turn, opens every asset in turn, and fills the values of
 * PSPLAT_GROUP_TIMED. */
psplat_result psplat_contest_run(psplat_journal *journal, psplat_workbench *bench,
                                 const psplat_folder *folder,
                                 int (*progress)(void *user, double fraction), void *user,
                                 psplat_error *error);
/* The path of a row's asset within the folder; of gltfpack's the plain one that can be read. From
 * malloc. */
char *psplat_contest_path(const psplat_folder *folder, const psplat_setting *setting);

/* ---- sweep.c: everything measured ------------------------------------------------------------ */

/* Zeros are the defaults. */
typedef struct psplat_sweep_desc {
    const char *source;    /* any file that psplat_mesh_read takes */
    const char *directory; /* see folder.c */
    psplat_tradeoff_options options;
    int fresh;            /* 1: forget what was measured before */
    int software;         /* 1: draw with Mesa's software rasteriser */
    const char *gltfpack; /* NULL: the one in PATH; "": none */
    int (*progress)(void *user, const char *what, double fraction); /* not 0: INTERRUPTED */
    void (*warn)(void *user, const char *text); /* what is left out, and why; may be NULL */
    void *user;
} psplat_sweep_desc;

/* What this run measured anew. */
typedef struct psplat_sweep_counts {
    size_t conversions, simplifications, shapes, pictures;
    size_t timings; /* settings */
} psplat_sweep_counts;

/* Measures what the directory's journal does not have yet, and writes everything. The caller frees
 * *journal. Errors name their subject: those of psplat_mesh_read, psplat_convert, folder.c,
 * journal.c, and GRAPHICS, INTERRUPTED. */
psplat_result psplat_sweep_run(const psplat_sweep_desc *desc, psplat_journal *journal,
                               psplat_sweep_counts *counts, psplat_error *error);

/* ---- pareto.c: what nothing else beats ------------------------------------------------------- */

/* Whether a is at most as great as b in all columns and smaller in one. */
int psplat_pareto_beats(const psplat_row *a, const psplat_row *b, const psplat_column *columns,
                        size_t column_count);
/* Marks the rows of one contender that no other of them beats: none is at most as great in all
 * columns and smaller in one. Rows that lack a value are not on the front; equal rows all are. Rows
 * without filter are no choice: what the filter is for, models that are small and move, is not in
 * the pictures of a model that fills them. */
void psplat_pareto_mark(const psplat_row *rows, size_t count, psplat_contender contender,
                        const psplat_column *columns, size_t column_count, uint8_t *is_front);
/* Indices of marked rows by ascending value of a column, of equal ones the first alone. Returns how
 * many. */
size_t psplat_pareto_sort(const psplat_row *rows, size_t count, const uint8_t *is_front,
                          psplat_column by, size_t *order);
/* The knee of a sorted front: the row farthest below the straight line between its ends, where both
 * columns are logarithms: before it a little more of x buys much less of y, after it much more buys
 * little. With less than three rows the last one. Returns a position in order. */
size_t psplat_pareto_knee(const psplat_row *rows, const size_t *order, size_t order_count,
                          psplat_column x, psplat_column y);

/* ---- advice.c: one setting ------------------------------------------------------------------- */

typedef enum psplat_error_kind {
    PSPLAT_ERROR_KIND_DISTANCE = 0, /* greatest, two-sided, % of the diagonal */
    PSPLAT_ERROR_KIND_NORMAL,       /* root mean square, degrees */
    PSPLAT_ERROR_KIND_IMAGE,        /* mean difference, % of white */
    PSPLAT_ERROR_KIND_COUNT
} psplat_error_kind;

extern const char *const psplat_error_kind_names[PSPLAT_ERROR_KIND_COUNT + 1];
psplat_column psplat_error_kind_column(psplat_error_kind kind);

typedef struct psplat_demand {
    psplat_error_kind kind;
    double error, bytes, ms; /* 0: no limit */
} psplat_demand;

typedef struct psplat_advice {
    size_t row;        /* SIZE_MAX: no setting has what it takes to choose one */
    int fits;          /* 0: nothing keeps the limits, row is the nearest miss */
    size_t simplified; /* the smallest of gltfpack's meshes that keeps them; SIZE_MAX: none does */
} psplat_advice;

/* The cheapest setting - bytes, then ms - that keeps limits->error and the others; without a limit
 * of the error the one with the least difference of images. Times that differ by less than 5 %,
 * and differences by less than 3 %, are equal: the default is taken then.
 *
 * What the error does not see stays at its default where that fits: distances tell nothing of
 * normals and modes, normals nothing of modes, and none tells of the filter (see pareto.c). The
 * nearest miss is the setting whose greatest ratio of value to limit is the smallest. scratch holds
 * count numbers. */
psplat_advice psplat_advise(const psplat_row *rows, size_t count, const psplat_demand *limits,
                            size_t *scratch);

/* What there is to choose between without limits: of each asset the best way to draw it - of those
 * whose pictures differ alike the fastest -, and of these the ones that no other beats in bytes and
 * difference of pictures. By ascending size in order; order and is_front have room for count.
 * Returns how many. */
size_t psplat_advise_front(const psplat_row *rows, size_t count, size_t *order, uint8_t *is_front);

/* ---- axis.c: logarithmic axes ---------------------------------------------------------------- */

enum { PSPLAT_MOST_TICKS = 64 };

typedef struct psplat_axis {
    double low, high; /* > 0 */
    double ticks[PSPLAT_MOST_TICKS];
    int labelled[PSPLAT_MOST_TICKS];
    size_t tick_count;
} psplat_axis;

/* Around the positive ones of the values, with some room on either side and three labelled ticks at
 * least. */
psplat_axis psplat_axis_fit(const double *values, size_t count);
/* 0 at low, 1 at high, less and more beyond; values that have no logarithm are at 0. */
double psplat_axis_place(const psplat_axis *axis, double value);

/* ---- chart.c: two columns of a journal as SVG ------------------------------------------------ */

typedef struct psplat_chart {
    const char *file; /* "error-bytes.svg" */
    const char *title;
    const char *x_label, *y_label;
    psplat_column x, y;
    int by_asset; /* 1: what does not depend on how splats are drawn: a point an asset */
} psplat_chart;

/* The charts of a sweep; cost is psplat_rows_cost. Returns how many, at most PSPLAT_CHARTS. */
enum { PSPLAT_CHARTS = 5 };
size_t psplat_chart_list(psplat_column cost, psplat_chart charts[PSPLAT_CHARTS]);
/* A complete SVG document. Rows that lack a value are left out. */
void psplat_chart_write(const psplat_chart *chart, const psplat_journal *journal,
                        psplat_text *text);

/* ---- page.c: all of it as one HTML file ------------------------------------------------------ */

/* Self-contained, without scripts: what was measured on what, the front, the charts, every row. */
void psplat_page_write(const psplat_journal *journal, psplat_text *text);

#endif
