/* SPDX-License-Identifier: Apache-2.0 */
/*
 * bench_umbrella_one FILE...: what a lookup in the first texture of each file costs, in nanoseconds, as JSON: at the
 * pixels of a square picture row by row, and at the same places in no order. The files take turns, so that what else
 * the machine does meets them all alike.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include <zt/zt.h>

enum {
    EDGE = 512, /* pixels */
    COUNT = EDGE * EDGE,
    ROUNDS = 7,
    FILES = 64
};

typedef struct contestant {
    const char *path;
    zt_file *file;
    zt_sampler *sampler;
    double ns[2][ROUNDS]; /* rows, scattered */
} contestant;

static void must(zt_result result, const char *path, const zt_diag *diag) {
    if (result == ZT_OK)
        return;
    fprintf(stderr, "%s: %s: %s\n", path, zt_result_text(result), diag->text);
    exit(1);
}

static double cpu_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void make_points(zt_point *points, int scattered) {
    unsigned long long state = 1;
    for (size_t i = 0; i < COUNT; i++)
        points[i] = (zt_point){.u = ((double)(i % EDGE) + 0.5) / EDGE,
                               .v = ((double)(i / EDGE) + 0.5) / EDGE,
                               .du_dx = 1.0 / EDGE,
                               .dv_dy = 1.0 / EDGE};
    for (size_t i = COUNT - 1; scattered && i > 0; i--) {
        state = state * 6364136223846793005ull + 1442695040888963407ull;
        size_t k = (size_t)(state >> 33) % (i + 1);
        zt_point swap = points[i];
        points[i] = points[k];
        points[k] = swap;
    }
}

static double time_once(const contestant *c, const zt_point *points, float *out) {
    zt_diag diag = {0};
    double begin = cpu_seconds();
    must(zt_sample(c->sampler, points, COUNT, out, &diag), c->path, &diag);
    return (cpu_seconds() - begin) * 1e9 / COUNT;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print(contestant *c, int last) {
    for (int i = 0; i < 2; i++)
        qsort(c->ns[i], ROUNDS, sizeof c->ns[i][0], compare);
    printf("  {\"file\": \"%s\", \"rows\": %.1f, \"rows_median\": %.1f, \"scattered\": %.1f, \"scattered_median\": "
           "%.1f}%s\n",
           c->path, c->ns[0][0], c->ns[0][ROUNDS / 2], c->ns[1][0], c->ns[1][ROUNDS / 2], last ? "" : ",");
}

int main(int argc, char **argv) {
    static contestant all[FILES];
    int count = argc - 1;
    zt_diag diag = {0};
    zt_point *points[2] = {calloc(COUNT, sizeof(zt_point)), calloc(COUNT, sizeof(zt_point))};
    float *out = calloc(COUNT, 4 * sizeof *out);
    if (count < 1 || count > FILES || !points[0] || !points[1] || !out)
        return 1;
    for (int order = 0; order < 2; order++)
        make_points(points[order], order);
    for (int i = 0; i < count; i++) {
        all[i].path = argv[i + 1];
        must(zt_open_path(all[i].path, NULL, &diag, &all[i].file), all[i].path, &diag);
        must(zt_sampler_open(all[i].file, 0, NULL, &diag, &all[i].sampler), all[i].path, &diag);
        (void)time_once(&all[i], points[0], out); /* decodes the tiles */
    }
    for (int round = 0; round < ROUNDS; round++)
        for (int order = 0; order < 2; order++)
            for (int i = 0; i < count; i++)
                all[i].ns[order][round] = time_once(&all[i], points[order], out);
    printf("[\n");
    for (int i = 0; i < count; i++) {
        print(&all[i], i + 1 == count);
        zt_sampler_close(all[i].sampler);
        zt_close(all[i].file);
    }
    printf("]\n");
    free(points[0]);
    free(points[1]);
    free(out);
    return 0;
}
