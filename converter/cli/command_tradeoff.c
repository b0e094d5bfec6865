/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * command_tradeoff.c - phongsplat tradeoff: a sweep of settings is measured, one is recommended.
 */
#include "base/path.h"
#include "cli/command.h"
#include "cli/options.h"
#include "cli/progress.h"
#include "table/row.h"
#include "table/setting.h"
#include "table/sweep_options.h"
#include "table/sweep_table.h"
#include "table/text.h"
#include "tradeoff/advice.h"
#include "tradeoff/pareto.h"
#include "tradeoff/sweep.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct arguments {
    const char *source;
    const char *directory;
    const char *tolerances, *ratios; /* lists, as given */
    const char *gltfpack;
    psplat_sweep_desc desc;
    psplat_demand demand;
    int error_kind;
    int max_bytes;
    int no_gltfpack;
    int quiet;
} arguments;

static psplat_parse refuse(const char *cause) {
    psplat_command_error("tradeoff: %s (phongsplat tradeoff --help lists what it takes)", cause);
    return PSPLAT_PARSE_ERROR;
}

/* What single options cannot say. */
static psplat_parse finish(arguments *a) {
    psplat_sweep_options *o = &a->desc.options;
    if (a->tolerances && !psplat_ladder_read(a->tolerances, 1e-4, 50, &o->tolerances))
        return refuse("tolerances: not up to 16 percentages from 0.0001 to 50 with commas between");
    if (a->ratios && !psplat_ladder_read(a->ratios, 1e-6, 1, &o->ratios))
        return refuse("ratios: not up to 16 numbers from 1e-06 to 1 with commas between");
    if (o->no_creases && o->crease_angle > 0)
        return refuse("no-creases: not together with crease-angle");
    if (a->gltfpack && a->no_gltfpack) return refuse("gltfpack: not together with no-gltfpack");
    a->desc.source = a->source;
    a->desc.folder = a->directory;
    a->desc.gltfpack = a->no_gltfpack ? "" : a->gltfpack;
    a->demand.kind = (psplat_error_kind)a->error_kind;
    a->demand.bytes = a->max_bytes;
    return PSPLAT_PARSE_OK;
}

static psplat_parse parse_options(const psplat_option *options, size_t count, arguments *a,
                                  int argc, char **argv) {
    const psplat_syntax syntax = {
        .command = "tradeoff",
        .operands = "SOURCE DIR",
        .summary =
            "Converts a mesh by a ladder of tolerances, as convert does and with floats and\n"
            "planar splats, measures and draws each conversion, writes table, charts and page\n"
            "into DIR, and recommends a setting.",
        .notes =
            "DIR is made, or is one of an earlier sweep. It holds tradeoff.csv, index.html, the\n"
            "assets, and charts as SVG, which gnuplot draws by charts.gp where it is installed.\n"
            "A sweep that was interrupted goes on when it is started again with the same options;\n"
            "one that is finished answers at once. Rows that a changed source or option concerns\n"
            "are measured anew, and those that are not asked for leave the table. Two sweeps at\n"
            "once need a DIR each.\n\n"
            "With --max-error the cheapest setting that keeps it is recommended, with budgets\n"
            "alone the one whose pictures differ least, and without either the knee of the front.\n"
            "Where nothing fits, the exit code is 10 and the line names the nearest miss.",
        .options = options,
        .option_count = count,
        .slots = {&a->source, &a->directory},
    };
    psplat_parse parsed = psplat_options_parse(&syntax, argc, argv);
    return parsed == PSPLAT_PARSE_OK ? finish(a) : parsed;
}

static psplat_parse parse(int argc, char **argv, arguments *a) {
    psplat_sweep_options *o = &a->desc.options;
    const psplat_option options[] = {
        {0, "max-error", PSPLAT_OPTION_PERCENT, &a->demand.error, "E",
         "recommend the cheapest setting (bytes, then ms) whose error\nis at most this", 1e-9, 1e6,
         NULL},
        {0, "error", PSPLAT_OPTION_CHOICE, &a->error_kind, "distance|normal|image|outline",
         "which error that is: greatest two-sided distance, % of the\n"
         "diagonal; normals, RMS degrees; mean difference of pictures,\n% of white; pixels along "
         "outlines, % (default distance)",
         0, 0, psplat_error_kind_names},
        {0, "max-bytes", PSPLAT_OPTION_COUNT, &a->max_bytes, "N", "a budget for the file", 1, 2e9,
         NULL},
        {0, "max-ms", PSPLAT_OPTION_NUMBER, &a->demand.ms, "MS",
         "a budget for a frame: time of the GPU, or, where GL is\ndrawn in software, of all its "
         "threads",
         1e-6, 1e6, NULL},
        {0, "tolerances", PSPLAT_OPTION_TEXT, &a->tolerances, "LIST",
         "tolerances of conversions, % (default 2,1,0.5,0.2,0.1)", 0, 0, NULL},
        psplat_option_shared("normal-tolerance", &o->normal_tolerance),
        psplat_option_shared("crease-angle", &o->crease_angle),
        psplat_option_shared("no-creases", &o->no_creases),
        psplat_option_shared("effort", &o->effort),
        psplat_option_shared("seed", &o->seed),
        psplat_option_shared("samples", &o->samples),
        psplat_option_shared("size", &o->size),
        {0, "frames", PSPLAT_OPTION_COUNT, &o->frames, "N",
         "frames of each setting that are timed at most (default 24);\nfewer where a turn of the "
         "12 "
         "views leaves standard errors of\n5 % or less",
         1, 1e5, NULL},
        {0, "gltfpack", PSPLAT_OPTION_TEXT, &a->gltfpack, "PATH",
         "the program (default: the one in PATH, if there is)", 0, 0, NULL},
        {0, "ratios", PSPLAT_OPTION_TEXT, &a->ratios, "LIST",
         "of triangles that gltfpack keeps\n(default 0.5,0.2,0.1,0.05,0.02,0.01)", 0, 0, NULL},
        {0, "no-gltfpack", PSPLAT_OPTION_FLAG, &a->no_gltfpack, NULL, "do not look for it", 0, 0,
         NULL},
        {0, "fresh", PSPLAT_OPTION_FLAG, &a->desc.fresh, NULL,
         "forget the table in DIR and write a new one over it, as after\na change of phongsplat "
         "itself",
         0, 0, NULL},
        psplat_option_shared("software", &a->desc.software),
        psplat_option_shared("quiet", &a->quiet),
    };
    return parse_options(options, sizeof options / sizeof *options, a, argc, argv);
}

/* ---- printing ----------------------------------------------------------------------------- */

static const char *cost_name(psplat_column cost) {
    return cost == PSPLAT_COLUMN_GPU_MS ? "GPU" : "CPU";
}

static void add_value(psplat_text *text, const psplat_row *row, psplat_column column,
                      const char *before, const char *after) {
    if (isnan(row->values[column])) return;
    psplat_text_add(text, "%s", before);
    psplat_text_figure(text, row->values[column]);
    psplat_text_add(text, "%s", after);
}

static void add_values(psplat_text *text, const psplat_sweep_table *t, const psplat_row *row) {
    psplat_column cost = psplat_rows_cost(t->rows, t->count);
    add_value(text, row, PSPLAT_COLUMN_BYTES, "", " bytes");
    add_value(text, row, PSPLAT_COLUMN_ELEMENTS, ", ", " splats");
    add_value(text, row, cost, ", ", " ms of ");
    psplat_text_add(text, "the %s a frame", cost_name(cost));
    add_value(text, row, PSPLAT_COLUMN_DISTANCE_MAX, ", distance ", " %");
    add_value(text, row, PSPLAT_COLUMN_NORMAL_RMS, ", normals ", " degrees");
    add_value(text, row, PSPLAT_COLUMN_DIFFERENCE, ", pictures ", " %");
    add_value(text, row, PSPLAT_COLUMN_OUTLINE, ", outlines ", " %");
}

/* The command, how to draw, what that was measured to give, and what gltfpack needs for it. */
static void add_recommendation(psplat_text *text, const arguments *a, const psplat_sweep_table *t,
                               const psplat_advice *advice) {
    const psplat_row *row = &t->rows[advice->row];
    psplat_setting_command(&row->setting, &t->options, a->source, text);
    psplat_text_add(text, "\ndraw with: mode %s\nmeasured: ", psplat_mode_names[row->setting.mode]);
    add_values(text, t, row);
    psplat_text_add(text, "\n");
    if (advice->simplified == SIZE_MAX) return;
    psplat_text_add(text, "compare: ");
    psplat_setting_describe(&t->rows[advice->simplified].setting, text);
    add_value(text, &t->rows[advice->simplified], PSPLAT_COLUMN_BYTES, " does it with ", " bytes");
    add_value(text, &t->rows[advice->simplified], PSPLAT_COLUMN_ELEMENTS, ", ", " triangles");
    psplat_text_add(text, "\n");
}

static void add_cell(psplat_text *text, const psplat_row *row, psplat_column column) {
    psplat_text cell = {0};
    psplat_text_figure(&cell, row->values[column]);
    /* A dash is one column wide and three bytes long. */
    int is_dash = isnan(row->values[column]);
    psplat_text_add(text, "%*s", is_dash ? 13 : 11, cell.data ? cell.data : "");
    text->failed |= cell.failed;
    free(cell.data);
}

/* The front of bytes and pictures; the knee is what is recommended. */
static void add_front(psplat_text *text, const psplat_sweep_table *t, const size_t *order,
                      size_t count, size_t knee) {
    psplat_column cost = psplat_rows_cost(t->rows, t->count);
    const psplat_column columns[] = {PSPLAT_COLUMN_BYTES,
                                     PSPLAT_COLUMN_ELEMENTS,
                                     PSPLAT_COLUMN_DISTANCE_MAX,
                                     PSPLAT_COLUMN_NORMAL_RMS,
                                     PSPLAT_COLUMN_DIFFERENCE,
                                     PSPLAT_COLUMN_OUTLINE,
                                     cost};
    psplat_text_add(text, "%-24s%11s%11s%11s%11s%11s%11s%8s ms\n", "setting", "bytes", "splats",
                    "distance %", "normals", "pictures %", "outlines %", cost_name(cost));
    for (size_t i = 0; i < count; ++i) {
        psplat_text name = {0};
        psplat_setting_describe(&t->rows[order[i]].setting, &name);
        psplat_text_add(text, "%-24s", name.data ? name.data : "");
        text->failed |= name.failed;
        free(name.data);
        for (size_t k = 0; k < sizeof columns / sizeof *columns; ++k)
            add_cell(text, &t->rows[order[i]], columns[k]);
        psplat_text_add(text, "%s\n", i == knee ? "  knee" : "");
    }
}

/* The smallest simplified mesh that looks as good as a setting. */
static size_t find_simplified(const psplat_sweep_table *t, size_t row, size_t *scratch) {
    double difference = t->rows[row].values[PSPLAT_COLUMN_DIFFERENCE];
    const psplat_demand demand = {.kind = PSPLAT_ERROR_KIND_IMAGE, .error = difference};
    return psplat_advise(t->rows, t->count, &demand, scratch).simplified;
}

/* Without limits: the knee of the front, after the front itself. 0 where memory ran out. */
static int choose_knee(psplat_text *text, const psplat_sweep_table *t, psplat_advice *advice) {
    uint8_t *is_front = malloc(t->count + 1);
    size_t *order = malloc((t->count + 1) * sizeof *order);
    if (is_front && order) {
        size_t count = psplat_advise_front(t->rows, t->count, order, is_front);
        size_t knee = psplat_pareto_knee(t->rows, order, count, PSPLAT_COLUMN_BYTES,
                                         PSPLAT_COLUMN_DIFFERENCE);
        add_front(text, t, order, count, knee);
        *advice = (psplat_advice){count ? order[knee] : SIZE_MAX, count > 0, SIZE_MAX};
        if (count) advice->simplified = find_simplified(t, order[knee], order);
    }
    int is_done = is_front && order;
    free(is_front);
    free(order);
    return is_done;
}

static int choose(psplat_text *text, const arguments *a, const psplat_sweep_table *t,
                  psplat_advice *advice) {
    if (a->demand.error <= 0 && a->demand.bytes <= 0 && a->demand.ms <= 0)
        return choose_knee(text, t, advice);
    size_t *scratch = malloc((t->count + 1) * sizeof *scratch);
    if (scratch) *advice = psplat_advise(t->rows, t->count, &a->demand, scratch);
    free(scratch);
    return scratch != NULL;
}

static void add_counts(psplat_text *text, const arguments *a, const psplat_sweep_table *t,
                       const psplat_sweep_counts *counts) {
    psplat_text_add(text, "%s: %zu settings, %zu of them measured anew, %zu timed anew\n",
                    a->directory, t->count, counts->measured, counts->timed);
}

static int fail_budget(const arguments *a, const psplat_sweep_table *t, const psplat_row *nearest) {
    psplat_text text = {0};
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(a->source, shown);
    psplat_setting_describe(&nearest->setting, &text);
    psplat_text_add(&text, ", gives ");
    add_values(&text, t, nearest);
    psplat_command_error("%s: no setting keeps to this; the nearest, %s", shown,
                         text.data ? text.data : "");
    free(text.data);
    return PSPLAT_EXIT_BUDGET;
}

static int recommend(const arguments *a, const psplat_sweep_table *t,
                     const psplat_sweep_counts *counts) {
    psplat_text text = {0};
    psplat_advice advice = {.row = SIZE_MAX};
    int code = PSPLAT_EXIT_SUCCESS;
    if (!a->quiet) add_counts(&text, a, t, counts);
    if (!choose(&text, a, t, &advice)) text.failed = 1;
    if (!text.failed && advice.row == SIZE_MAX) {
        psplat_command_error("%s: no conversion is left to recommend", a->source);
        code = PSPLAT_EXIT_INVALID;
    } else if (!text.failed && !advice.fits) {
        code = fail_budget(a, t, &t->rows[advice.row]);
    } else if (!text.failed) {
        add_recommendation(&text, a, t, &advice);
    }
    if (text.failed) {
        psplat_command_error("no memory for a text");
        code = PSPLAT_EXIT_MEMORY;
    }
    if (!code) fputs(text.data, stdout);
    free(text.data);
    return code;
}

/* Errors of the directory begin with its path; others are about the source. */
static int fail(const arguments *a, const psplat_error *error) {
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(a->directory, shown);
    int is_named = !strncmp(error->text, shown, strlen(shown));
    return psplat_command_fail(is_named ? NULL : a->source, error);
}

/* ---- the command -------------------------------------------------------------------------- */

/* A sweep takes minutes, so that it says what it does also where nobody looks at a terminal: a line
 * for each step then. */
typedef struct speaker {
    psplat_progress progress; /* the line of a terminal */
    int is_log;
    char said[64];
} speaker;

static int say(void *user, const char *what, double done) {
    speaker *s = user;
    if (!s->is_log) return psplat_progress_show_done(&s->progress, what, done);
    if (!strcmp(s->said, what)) return 0;
    snprintf(s->said, sizeof s->said, "%s", what);
    fprintf(stderr, "phongsplat: tradeoff: %d %%: %s\n", (int)(100 * done), what);
    return 0;
}

static void warn(void *user, const char *text) {
    speaker *s = user;
    psplat_progress_end(&s->progress);
    psplat_command_error("%s", text);
}

int psplat_command_tradeoff(int argc, char **argv) {
    arguments a = {0};
    psplat_parse parsed = parse(argc, argv, &a);
    if (parsed != PSPLAT_PARSE_OK) return (int)parsed;
    speaker speaker = {.progress = psplat_progress_begin(a.quiet)};
    psplat_sweep_table table = {.count = 0};
    psplat_sweep_counts counts = {0};
    psplat_error error = {0};
    speaker.is_log = !a.quiet && !speaker.progress.enabled;
    a.desc.progress = say;
    a.desc.warn = warn;
    a.desc.user = &speaker;
    psplat_result result = psplat_sweep_run(&a.desc, &table, &counts, &error);
    psplat_progress_end(&speaker.progress);
    int code = result ? fail(&a, &error) : recommend(&a, &table, &counts);
    psplat_sweep_table_free(&table);
    return code;
}
