/* SPDX-License-Identifier: Apache-2.0 */
#include "diff.h"

#include <math.h>

void dif_error_add(dif_error *error, const float *a, const float *b, size_t count) {
    for (size_t i = 0; i < count; i++) {
        double x = (double)a[i], y = (double)b[i], d = fabs(x - y);
        /* Equal infinities and two NaN are the same; one alone is as far away as can be. */
        if (x == y || (isnan(x) && isnan(y)))
            d = 0;
        else if (!isfinite(d))
            d = INFINITY;
        error->most = fmax(error->most, d);
        error->sum += d * d;
        error->peak = fmax(error->peak, isfinite(x) ? fabs(x) : 0);
    }
    error->values += count;
}

/* Infinite when nothing differs. */
static double psnr(const dif_error *error) {
    double peak = fmax(error->peak, 1), mean = error->sum / (double)error->values;
    return 10 * log10(peak * peak / mean);
}

static json_t *begin(dif_job *job, const char *part, const char *where) {
    json_t *object = json_object();
    json_object_set_new(object, "part", json_string(part));
    json_object_set_new(object, "where", cmd_json_text(where));
    json_array_append_new(job->list, object);
    return object;
}

void dif_report(dif_job *job, const char *part, const char *where, const char *a, const char *b) {
    job->count++;
    if (job->as_json) {
        json_t *object = begin(job, part, where);
        json_object_set_new(object, "a", cmd_json_text(a));
        json_object_set_new(object, "b", cmd_json_text(b));
        return;
    }
    if (job->args->quiet)
        return;
    printf("%s: ", part);
    cmd_print_safe(stdout, where);
    printf(": ");
    cmd_print_safe(stdout, a ? a : "not there");
    printf(" | ");
    cmd_print_safe(stdout, b ? b : "not there");
    printf("\n");
}

static json_t *number_or_null(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

void dif_report_error(dif_job *job, const char *part, const char *where, const dif_error *error) {
    job->count++;
    if (job->as_json) {
        json_t *object = begin(job, part, where);
        json_object_set_new(object, "max", error->values ? number_or_null(error->most) : json_null());
        json_object_set_new(object, "psnr", error->values ? number_or_null(psnr(error)) : json_null());
        json_object_set_new(object, "bytes", error->values ? json_null() : cmd_json_u64(error->bytes));
        return;
    }
    if (job->args->quiet)
        return;
    printf("%s: ", part);
    cmd_print_safe(stdout, where);
    if (error->values)
        printf(": max %.6g, PSNR %.2f dB\n", error->most, psnr(error));
    else
        printf(": %llu bytes differ\n", (unsigned long long)error->bytes);
}
