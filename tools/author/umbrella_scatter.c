/* SPDX-License-Identifier: Apache-2.0 */
/* Where elements lie: Poisson discs, a jittered lattice, a tiling. */
#include <math.h>
#include <stdlib.h>

#include "umbrella_scatter.h"

#define JAMMED 0.696  /* discs of diameter 1 on an area of 1 when darts find no more room */
#define MISSES 300    /* darts, before the discs become smaller */
#define SMALLER 0.985 /* that much */
#define NOBODY UINT32_MAX

typedef struct darts {
    const umb_field *field;
    author_random *random;
    author_xy *points;
    size_t count;
    uint32_t columns, rows; /* of buckets, each at least a disc wide */
    uint32_t *heads, *links;
    double distance;
} darts;

static uint32_t bucket_along(double value, double low, double length, uint32_t count) {
    uint32_t at = (uint32_t)((value - low) / length * count);
    return at < count ? at : count - 1;
}

static double apart(double a, double b, double length, int repeat) {
    double d = fabs(a - b);
    return repeat && d > length / 2 ? length - d : d;
}

/* Is a point of this bucket too near? */
static int bucket_blocks(const darts *d, uint32_t bucket, author_xy p) {
    const umb_field *f = d->field;
    for (uint32_t i = d->heads[bucket]; i != NOBODY; i = d->links[i]) {
        double x = apart(p.x, d->points[i].x, f->width, f->repeat_x);
        double y = apart(p.y, d->points[i].y, f->height, f->repeat_y);
        if (x * x + y * y < d->distance * d->distance)
            return 1;
    }
    return 0;
}

/* The bucket beside another one, or -1 beyond the end. */
static int64_t beside(uint32_t at, int step, uint32_t count, int repeat) {
    int64_t to = (int64_t)at + step;
    if (to >= 0 && to < count)
        return to;
    return repeat ? (to + count) % count : -1;
}

static int blocked(const darts *d, author_xy p, uint32_t bx, uint32_t by) {
    for (int i = 0; i < 9; i++) {
        int64_t x = beside(bx, i % 3 - 1, d->columns, d->field->repeat_x);
        int64_t y = beside(by, i / 3 - 1, d->rows, d->field->repeat_y);
        if (x >= 0 && y >= 0 && bucket_blocks(d, (uint32_t)(y * d->columns + x), p))
            return 1;
    }
    return 0;
}

static void throw_all(darts *d, size_t wanted) {
    const umb_field *f = d->field;
    int misses = 0;
    while (d->count < wanted) {
        author_xy p = {f->x + f->width * author_random_unit(d->random),
                       f->y + f->height * author_random_unit(d->random)};
        uint32_t bx = bucket_along(p.x, f->x, f->width, d->columns);
        uint32_t by = bucket_along(p.y, f->y, f->height, d->rows);
        if (blocked(d, p, bx, by)) {
            if (++misses == MISSES) {
                d->distance *= SMALLER;
                misses = 0;
            }
            continue;
        }
        misses = 0;
        uint32_t bucket = by * d->columns + bx;
        d->links[d->count] = d->heads[bucket];
        d->heads[bucket] = (uint32_t)d->count;
        d->points[d->count++] = p;
    }
}

static uint32_t buckets_along(double length, double distance) {
    double count = floor(length / distance);
    return count < 1 ? 1 : count > 4096 ? 4096 : (uint32_t)count;
}

author_result umb_scatter_discs(author_run *run, const umb_field *field, size_t count, author_random *random,
                                author_xy *points) {
    darts d = {.field = field, .random = random, .points = points};
    d.distance = sqrt(JAMMED * field->width * field->height / (double)(count ? count : 1));
    d.columns = buckets_along(field->width, d.distance);
    d.rows = buckets_along(field->height, d.distance);
    d.heads = author_alloc(run, (size_t)d.columns * d.rows, sizeof *d.heads);
    d.links = author_alloc(run, count, sizeof *d.links);
    author_result result = d.heads && d.links ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (size_t i = 0; result == AUTHOR_OK && i < (size_t)d.columns * d.rows; i++)
        d.heads[i] = NOBODY;
    if (result == AUTHOR_OK)
        throw_all(&d, count);
    free(d.heads);
    free(d.links);
    return result;
}

void umb_scatter_lattice(const umb_field *field, uint32_t columns, uint32_t rows, double jitter, double row_shift,
                         author_random *random, author_xy *points) {
    for (uint32_t y = 0; y < rows; y++)
        for (uint32_t x = 0; x < columns; x++) {
            double i = x + 0.5 + (y % 2 ? row_shift : 0), j = y + 0.5;
            if (jitter > 0) {
                i += jitter * umb_signed(random) / 2;
                j += jitter * umb_signed(random) / 2;
            }
            *points++ = (author_xy){field->x + i * field->width / columns, field->y + j * field->height / rows};
        }
}
