/* SPDX-License-Identifier: Apache-2.0 */
/* What is seen of each umbrella, at SAMPLES x SAMPLES places of a cell; what nobody sees is not merged into
 * anything. */
#include <math.h>
#include <stdlib.h>

#include "umbrella_level.h"

#define SAMPLES 16 /* along a cell */
#define PATCHES 4  /* of the ground along a cell */
#define NOBODY UINT32_MAX

typedef struct labelling {
    const umb_sources *sources;
    const umb_grid *grid;
    uint32_t width, height; /* samples */
    uint32_t *labels;
    author_xy *seen_from; /* centre, shifted, of the source that a sample shows */
} labelling;

static int64_t sample_at(double value, uint32_t count) {
    double at = ceil(value * SAMPLES - 0.5);
    return at < 0 ? 0 : at > count ? (int64_t)count : (int64_t)at;
}

static void paint(const labelling *l, uint32_t source, author_xy centre) {
    const author_xy *polygon = l->sources->points + l->sources->first[source];
    size_t count = l->sources->first[source + 1] - l->sources->first[source];
    author_xy low = polygon[0], high = polygon[0];
    for (size_t i = 1; i < count; i++) {
        low = (author_xy){fmin(low.x, polygon[i].x), fmin(low.y, polygon[i].y)};
        high = (author_xy){fmax(high.x, polygon[i].x), fmax(high.y, polygon[i].y)};
    }
    int64_t x0 = sample_at(centre.x + low.x, l->width), x1 = sample_at(centre.x + high.x, l->width);
    int64_t y0 = sample_at(centre.y + low.y, l->height), y1 = sample_at(centre.y + high.y, l->height);
    for (int64_t y = y0; y < y1; y++)
        for (int64_t x = x0; x < x1; x++) {
            author_xy p = {((double)x + 0.5) / SAMPLES - centre.x, ((double)y + 0.5) / SAMPLES - centre.y};
            if (!umb_covers(polygon, count, p))
                continue;
            l->labels[y * l->width + x] = source;
            l->seen_from[y * l->width + x] = centre;
        }
}

static void paint_all(const labelling *l) {
    for (uint32_t i = 0; i < l->sources->count; i++)
        for (int shift = 0; shift < 9; shift++) {
            int sx = shift % 3 - 1, sy = shift / 3 - 1;
            author_xy c = l->sources->centres[i];
            if ((sx == 0 || l->grid->repeat[0]) && (sy == 0 || l->grid->repeat[1]))
                paint(l, i, (author_xy){c.x + (double)sx * l->grid->width, c.y + (double)sy * l->grid->height});
        }
}

/* The ground's samples belong to patches, whose numbers follow those of the sources. */
static void paint_ground(const labelling *l) {
    uint32_t step = SAMPLES / PATCHES, columns = l->width / step;
    for (uint32_t i = 0; i < l->width * l->height; i++) {
        uint32_t x = i % l->width / step, y = i / l->width / step;
        if (l->labels[i] != NOBODY)
            continue;
        l->labels[i] = (uint32_t)l->sources->count + y * columns + x;
        l->seen_from[i] = (author_xy){(x + 0.5) / PATCHES, (y + 0.5) / PATCHES};
    }
}

static author_xy sample_place(const labelling *l, size_t i) {
    return (author_xy){((double)(i % l->width) + 0.5) / SAMPLES, ((double)(i / l->width) + 0.5) / SAMPLES};
}

/* Labels that have samples become regions, in their order. */
static void number_regions(const labelling *l, const size_t *sizes, size_t labels, size_t *numbers, umb_regions *out) {
    size_t samples = 0;
    for (size_t i = 0; i < labels; i++) {
        if (sizes[i] == 0)
            continue;
        numbers[i] = out->count;
        out->depths[out->count] = i < l->sources->count ? (double)i : -1;
        out->first[out->count++] = samples;
        samples += sizes[i];
    }
    out->first[out->count] = samples;
}

static double into(double value, double length, int repeat) {
    if (repeat)
        value -= length * floor(value / length);
    return value < 0 ? 0 : value >= length ? length - 0x1p-20 : value;
}

static void add_colour(const author_picture *truth, const labelling *l, size_t sample, double colour[3]) {
    size_t x = sample % l->width * truth->width / l->width, y = sample / l->width * (truth->height / 2) / l->height;
    for (size_t c = 0; c < 3; c++)
        colour[c] += (double)zt_transfer_encode(ZT_TRANSFER_SRGB, truth->texels[4 * (y * truth->width + x) + c]);
}

/* Samples of a region around its own mean, which may lie beyond a side that repeats. */
static void collect(const labelling *l, const author_picture *truth, const size_t *numbers, size_t *next,
                    umb_regions *out) {
    size_t total = (size_t)l->width * l->height;
    for (size_t i = 0; i < total; i++) {
        if (l->labels[i] == NOBODY)
            continue;
        size_t region = numbers[l->labels[i]];
        author_xy place = umb_less(sample_place(l, i), l->seen_from[i]);
        out->samples[next[region]++] = place;
        out->homes[region].x += place.x;
        out->homes[region].y += place.y;
        add_colour(truth, l, i, out->colours[region]);
    }
}

static void settle(const labelling *l, const size_t *numbers, size_t labels, umb_regions *out) {
    uint32_t columns = l->grid->width * PATCHES;
    for (size_t i = 0; i < labels; i++) {
        size_t r = numbers[i];
        if (r == SIZE_MAX)
            continue;
        size_t ground = i - l->sources->count, count = out->first[r + 1] - out->first[r];
        author_xy mean = {out->homes[r].x / (double)count, out->homes[r].y / (double)count};
        author_xy centre = i < l->sources->count ? l->sources->centres[i]
                                                 : (author_xy){((double)(ground % columns) + 0.5) / PATCHES,
                                                               ((double)(ground / columns) + 0.5) / PATCHES};
        for (int c = 0; c < 3; c++)
            out->colours[r][c] /= (double)count;
        for (size_t k = out->first[r]; k < out->first[r + 1]; k++)
            out->samples[k] = umb_less(out->samples[k], mean);
        out->homes[r] = (author_xy){into(centre.x + mean.x, l->grid->width, l->grid->repeat[0]),
                                    into(centre.y + mean.y, l->grid->height, l->grid->repeat[1])};
    }
}

static author_result group(author_run *run, const labelling *l, const author_picture *truth, umb_regions *out) {
    size_t ground = (size_t)l->grid->width * l->grid->height * PATCHES * PATCHES;
    size_t labels = l->sources->count + ground, total = (size_t)l->width * l->height;
    size_t *sizes = author_alloc(run, labels, sizeof *sizes), *numbers = author_alloc(run, labels, sizeof *numbers);
    size_t *next = author_alloc(run, labels + 1, sizeof *next);
    out->depths = author_alloc(run, labels, sizeof *out->depths);
    out->homes = author_alloc(run, labels, sizeof *out->homes);
    out->colours = author_alloc(run, labels, sizeof *out->colours);
    out->first = author_alloc(run, labels + 1, sizeof *out->first);
    out->samples = author_alloc(run, total, sizeof *out->samples);
    int good = sizes && numbers && next && out->depths && out->homes && out->colours && out->first && out->samples;
    for (size_t i = 0; good && i < total; i++)
        if (l->labels[i] != NOBODY)
            sizes[l->labels[i]]++;
    for (size_t i = 0; good && i < labels; i++)
        numbers[i] = SIZE_MAX;
    if (good) {
        number_regions(l, sizes, labels, numbers, out);
        for (size_t r = 0; r < out->count; r++)
            next[r] = out->first[r];
        collect(l, truth, numbers, next, out);
        settle(l, numbers, labels, out);
    }
    free(sizes);
    free(numbers);
    free(next);
    return good ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

author_result umb_find_regions(author_run *run, const umb_sources *sources, const umb_grid *grid, int with_ground,
                               const author_picture *truth, umb_regions *out) {
    labelling l = {.sources = sources, .grid = grid, .width = grid->width * SAMPLES, .height = grid->height * SAMPLES};
    size_t total = (size_t)l.width * l.height;
    *out = (umb_regions){0};
    l.labels = author_alloc(run, total, sizeof *l.labels);
    l.seen_from = author_alloc(run, total, sizeof *l.seen_from);
    author_result result = l.labels && l.seen_from ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK) {
        for (size_t i = 0; i < total; i++)
            l.labels[i] = NOBODY;
        paint_all(&l);
        if (with_ground)
            paint_ground(&l);
        result = group(run, &l, truth, out);
    }
    free(l.labels);
    free(l.seen_from);
    return result;
}

void umb_regions_release(umb_regions *regions) {
    free(regions->depths);
    free(regions->homes);
    free(regions->colours);
    free(regions->first);
    free(regions->samples);
    *regions = (umb_regions){0};
}

void umb_sources_release(umb_sources *sources) {
    free(sources->centres);
    free(sources->first);
    free(sources->points);
    *sources = (umb_sources){0};
}
