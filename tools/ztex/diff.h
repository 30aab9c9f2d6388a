/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of ztex diff share. */
#ifndef ZTEX_DIFF_H
#define ZTEX_DIFF_H

#include "command.h"

typedef struct dif_job {
    cmd_args *args;
    const zt_file *a, *b;
    int as_json;
    double tolerance;
    uint32_t size; /* of the grid of --rendered */
    uint64_t count;
    json_t *list; /* as_json: the differences */
} dif_job;

/* How far two sets of values are from each other. Zero-initialised is empty. */
typedef struct dif_error {
    double most, sum, peak; /* largest difference; sum of squares; peak for PSNR, at least 1 */
    uint64_t values, bytes; /* values compared; bytes that differ, where there are no values */
} dif_error;

void dif_error_add(dif_error *error, const float *a, const float *b, size_t count);

/* A difference: values as text, or an error. Texts are printed safely. */
void dif_report(dif_job *job, const char *part, const char *where, const char *a, const char *b);
void dif_report_error(dif_job *job, const char *part, const char *where, const dif_error *error);

/* Each returns a cmd_status; CMD_OK also when it found differences. */
int dif_structure(dif_job *job);
int dif_texels(dif_job *job);
int dif_rendered(dif_job *job);

#endif
