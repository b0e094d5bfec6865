/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * jobs.c - several inputs in one command, each in a process of its own.
 */
#define _XOPEN_SOURCE 700

#include "cli/jobs.h"

#include "base/json_writer.h"
#include "base/path.h"
#include "cli/command.h"

#include <errno.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/prctl.h>
#endif
#ifdef _OPENMP
#include <omp.h>
#endif

/* ---- names ----------------------------------------------------------------------------------- */

/* Returns DIRECTORY/NAME.glb for an input DIR/NAME.EXTENSION; the caller frees it. */
static char *output_of(const char *directory, const char *input) {
    const char *slash = strrchr(input, '/'), *base = slash ? slash + 1 : input;
    const char *dot = strrchr(base, '.');
    size_t length = dot && dot > base ? (size_t)(dot - base) : strlen(base);
    size_t size = strlen(directory) + length + 8;
    char *path = malloc(size);
    const char *between = directory[strlen(directory) - 1] == '/' ? "" : "/";
    if (path) snprintf(path, size, "%s%s%.*s.glb", directory, between, (int)length, base);
    return path;
}

static psplat_result refuse_clash(const psplat_job *first, const psplat_job *second,
                                  psplat_error *error) {
    char input[PSPLAT_SHOWN_PATH], output[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(second->input, input);
    psplat_path_shorten(first->output, output);
    return psplat_fail(error, PSPLAT_ERROR_ARGUMENT, 0, "%s: would become %s, as another input",
                       input, output);
}

psplat_result psplat_jobs_make(const char *const *inputs, size_t count, const char *directory,
                               psplat_jobs *jobs, psplat_error *error) {
    jobs->list = calloc(count + 1, sizeof *jobs->list);
    if (!jobs->list) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
    for (size_t i = 0; i < count; ++i, ++jobs->count) {
        psplat_job *job = &jobs->list[i];
        *job = (psplat_job){.input = inputs[i], .output = output_of(directory, inputs[i])};
        if (!job->output) return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory");
        for (size_t k = 0; k < i; ++k)
            if (!strcmp(jobs->list[k].output, job->output)) {
                refuse_clash(&jobs->list[k], job, error);
                ++jobs->count; /* is freed, too */
                return PSPLAT_ERROR_ARGUMENT;
            }
    }
    return PSPLAT_OK;
}

void psplat_jobs_free(psplat_jobs *jobs) {
    for (size_t i = 0; i < jobs->count; ++i) {
        free(jobs->list[i].output);
        free(jobs->list[i].notes);
    }
    free(jobs->list);
    *jobs = (psplat_jobs){0};
}

/* ---- processes ------------------------------------------------------------------------------- */

/* One process that runs. */
typedef struct worker {
    pid_t process; /* 0: none */
    psplat_job *job;
    FILE *notes;
} worker;

/* Lets the process end silently when the one that made it does, which prints the line. */
static void follow_parent(pid_t parent) {
    const int ending[] = {SIGINT, SIGTERM, SIGHUP};
    for (size_t i = 0; i < sizeof ending / sizeof *ending; ++i) {
        struct sigaction now;
        if (!sigaction(ending[i], NULL, &now) && now.sa_handler != SIG_IGN)
            signal(ending[i], SIG_DFL);
    }
#ifdef __linux__
    prctl(PR_SET_PDEATHSIG, SIGKILL);
#endif
    if (getppid() != parent) _exit(PSPLAT_EXIT_INTERRUPTED);
}

static void share_processors(int at_a_time) {
#ifdef _OPENMP
    int threads = omp_get_num_procs() / at_a_time;
    if (!getenv("OMP_NUM_THREADS")) omp_set_num_threads(threads > 1 ? threads : 1);
#else
    (void)at_a_time;
#endif
}

static void work_and_exit(const worker *w, psplat_job_work work, const void *user) {
    int code = work(user, w->job, w->notes);
    int is_lost = fflush(stdout) || ferror(stdout);
    if (is_lost) psplat_command_error("standard output: cannot be written");
    fflush(w->notes);
    _exit(is_lost && !code ? PSPLAT_EXIT_WRITE : code);
}

/* Starts a job; returns 0 where there is no room for its process or its notes. */
static int start(worker *w, psplat_job *job, int at_a_time, psplat_job_work work,
                 const void *user) {
    pid_t parent = getpid();
    *w = (worker){.job = job, .notes = tmpfile()};
    fflush(stdout); /* what is buffered here must not be printed twice */
    w->process = w->notes ? fork() : -1;
    if (w->process > 0) return 1;
    if (w->process == 0) {
        follow_parent(parent);
        share_processors(at_a_time);
        work_and_exit(w, work, user);
    }
    char shown[PSPLAT_SHOWN_PATH];
    psplat_path_shorten(job->input, shown);
    psplat_command_error("%s: no process for it: %s", shown, strerror(errno));
    job->code = PSPLAT_EXIT_MEMORY;
    if (w->notes) fclose(w->notes);
    *w = (worker){0};
    return 0;
}

static void read_notes(worker *w) {
    long size = fseek(w->notes, 0, SEEK_END) ? 0 : ftell(w->notes);
    if (size > 0) w->job->notes = malloc((size_t)size + 1);
    if (w->job->notes) {
        rewind(w->notes);
        w->job->notes[fread(w->job->notes, 1, (size_t)size, w->notes)] = 0;
    }
    fclose(w->notes);
}

/* Waits for any job to end. A process that another one ended, for its memory for example, wrote
 * nothing. */
static void finish_any(worker *workers, int count) {
    int status = 0;
    pid_t process = waitpid(-1, &status, 0);
    for (int i = 0; i < count; ++i) {
        worker *w = &workers[i];
        if (process <= 0 || w->process != process) continue;
        read_notes(w);
        w->job->code = WIFEXITED(status) ? WEXITSTATUS(status) : PSPLAT_EXIT_INTERRUPTED;
        if (!WIFEXITED(status)) {
            char shown[PSPLAT_SHOWN_PATH];
            psplat_path_shorten(w->job->input, shown);
            psplat_command_error("%s: ended by signal %d", shown, WTERMSIG(status));
        }
        *w = (worker){0};
    }
}

static worker *free_worker(worker *workers, int count) {
    for (int i = 0; i < count; ++i)
        if (!workers[i].process) return &workers[i];
    return NULL;
}

void psplat_jobs_run(psplat_jobs *jobs, int at_a_time, psplat_job_work work, const void *user) {
    worker workers[PSPLAT_MAX_JOBS] = {{0}};
    int running = 0;
    for (size_t next = 0; next < jobs->count || running;) {
        worker *idle = next < jobs->count ? free_worker(workers, at_a_time) : NULL;
        if (idle) {
            running += start(idle, &jobs->list[next++], at_a_time, work, user);
        } else {
            finish_any(workers, at_a_time);
            --running;
        }
    }
}

/* ---- results --------------------------------------------------------------------------------- */

int psplat_jobs_code(const psplat_jobs *jobs) {
    int failed = 0, broken = 0;
    for (size_t i = 0; i < jobs->count; ++i) {
        int code = jobs->list[i].code;
        if (code == PSPLAT_EXIT_BROKEN)
            broken = code;
        else if (code > failed)
            failed = code;
    }
    return failed ? failed : broken;
}

static void report_job(psplat_writer *json, const psplat_job *job) {
    int is_written = job->code == PSPLAT_EXIT_SUCCESS || job->code == PSPLAT_EXIT_BROKEN;
    psplat_writer_open(json, NULL, '{');
    psplat_writer_string(json, "input", job->input);
    psplat_writer_string(json, "output", job->output);
    psplat_writer_count(json, "exit_code", (size_t)job->code);
    if (is_written && job->notes)
        psplat_writer_raw(json, "report", job->notes);
    else
        psplat_writer_string(json, "error", job->notes ? job->notes : "no memory, or ended");
    psplat_writer_close(json, '}');
}

psplat_result psplat_jobs_report(const psplat_jobs *jobs, char **text, size_t *size,
                                 psplat_error *error) {
    psplat_writer json = {0};
    psplat_writer_open(&json, NULL, '{');
    psplat_writer_count(&json, "exit_code", (size_t)psplat_jobs_code(jobs));
    psplat_writer_open(&json, "conversions", '[');
    for (size_t i = 0; i < jobs->count; ++i) report_job(&json, &jobs->list[i]);
    psplat_writer_close(&json, ']');
    psplat_writer_close(&json, '}');
    if (!psplat_writer_finish(&json))
        return psplat_fail(error, PSPLAT_ERROR_MEMORY, 0, "out of memory for the report");
    *text = json.text;
    *size = json.size;
    return PSPLAT_OK;
}
