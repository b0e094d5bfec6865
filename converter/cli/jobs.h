/* SPDX-License-Identifier: GPL-3.0-or-later
 *
 * jobs.h - several inputs in one command: each is a job of its own in a process of its own, so that
 * one that fails or runs out of memory leaves the others alone.
 */
#ifndef PHONGSPLAT_CLI_JOBS_H
#define PHONGSPLAT_CLI_JOBS_H

#include <phongsplat/splat.h>

#include <stddef.h>
#include <stdio.h>

enum { PSPLAT_MAX_JOBS = 256 }; /* at a time */

typedef struct psplat_job {
    const char *input; /* as the user gave it */
    char *output;      /* DIRECTORY/NAME.glb for the input NAME.obj */
    int code;          /* exit code */
    char *notes;       /* what the job wrote to its notes, ended by a 0; or NULL */
} psplat_job;

/* Zero-initialise; psplat_jobs_free releases it. */
typedef struct psplat_jobs {
    psplat_job *list;
    size_t count;
} psplat_jobs;

/* Does one job in the process that was made for it, and returns its exit code. Its notes are for
 * psplat_jobs_report: the report of a conversion that wrote its output, else what went wrong. */
typedef int (*psplat_job_work)(const void *user, const psplat_job *job, FILE *notes);

/* Makes a job for each input, with its output in the directory. Two outputs of one name are an
 * error. Errors: PSPLAT_ERROR_ARGUMENT, PSPLAT_ERROR_MEMORY. */
psplat_result psplat_jobs_make(const char *const *inputs, size_t count, const char *directory,
                               psplat_jobs *jobs, psplat_error *error);

/* Runs all jobs, so many at a time, at most PSPLAT_MAX_JOBS, and stores their codes and notes.
 * Where none of the threads is asked for by OMP_NUM_THREADS, they share the processors. Processes
 * end with this one. */
void psplat_jobs_run(psplat_jobs *jobs, int at_a_time, psplat_job_work work, const void *user);

/* Returns the exit code of all jobs: the greatest of those that wrote nothing, else
 * PSPLAT_EXIT_BROKEN where one broke a promise, else 0. */
int psplat_jobs_code(const psplat_jobs *jobs);

/* Writes one JSON object: the exit code of all, and in "conversions" for each job its input,
 * output, exit code, and its report or error. *text is malloc'ed and owned by the caller. Fails
 * only with PSPLAT_ERROR_MEMORY. */
psplat_result psplat_jobs_report(const psplat_jobs *jobs, char **text, size_t *size,
                                 psplat_error *error);

void psplat_jobs_free(psplat_jobs *jobs);

#endif
