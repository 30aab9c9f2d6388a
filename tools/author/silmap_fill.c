/* SPDX-License-Identifier: Apache-2.0 */
/* Flat drawings: scan lines through painted shapes. */
#include "silmap_fill.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_SHAPES ((size_t)1 << 20)
#define MOST_EDGES ((size_t)1 << 24)
#define FARTHEST 1e9 /* coordinates */
#define DEEPEST 64   /* shapes within each other */
#define FEW_CROSSINGS 48
#define LAYERS 256         /* that are seen through at a place */
#define LEAST_KEEP 0.0005f /* of what is below: nobody sees it */

/* ---- shapes --------------------------------------------------------------------------------------------- */

static author_result check_path(author_run *run, const author_path *path) {
    for (size_t i = 0; i < 2 * path->count; i++)
        if (!(fabs(path->points[i]) <= FARTHEST))
            return author_fail(run, AUTHOR_BAD_INPUT, "a shape has a point that is nowhere near");
    return AUTHOR_OK;
}

static author_result check_shape(author_run *run, const author_silmap_input *input, size_t s, size_t *edges) {
    const author_silmap_shape *shape = &input->shapes[s];
    size_t depth = 0;
    if (shape->first > input->path_count || shape->count > input->path_count - shape->first)
        return author_fail(run, AUTHOR_BAD_INPUT, "shape %zu has paths that are not there", s);
    if (shape->within > s)
        return author_fail(run, AUTHOR_BAD_INPUT, "shape %zu is within one that comes later", s);
    for (uint32_t w = shape->within; w; w = input->shapes[w - 1].within)
        if (++depth > DEEPEST)
            return author_fail(run, AUTHOR_BAD_INPUT, "more than %d shapes are within each other", DEEPEST);
    author_result result = AUTHOR_OK;
    for (size_t p = shape->first; p < shape->first + shape->count && result == AUTHOR_OK; p++) {
        result = check_path(run, &input->paths[p]);
        *edges += input->paths[p].count;
        if (*edges > MOST_EDGES)
            return author_fail(run, AUTHOR_BAD_INPUT, "the shapes have more than %zu lines", MOST_EDGES);
    }
    return result;
}

static void put_edges(const author_silmap_input *input, size_t s, silmap_truth *truth) {
    const author_silmap_shape *shape = &input->shapes[s];
    for (size_t p = shape->first; p < shape->first + shape->count; p++) {
        const author_path *path = &input->paths[p];
        for (size_t i = 0; i < path->count; i++) {
            const double *a = path->points + 2 * i, *b = path->points + 2 * ((i + 1) % path->count);
            int down = b[1] > a[1];
            const double *top = down ? a : b, *bottom = down ? b : a;
            /* What is above, below or to the right crosses no scan line. */
            if (top[1] < bottom[1] && bottom[1] > 0 && top[1] < 1 && fmin(a[0], b[0]) < 1)
                truth->edges[truth->edge_count++] = (silmap_edge){top[0], top[1], bottom[0], bottom[1],
                                                                  2 * (uint64_t)s + (uint64_t)down};
        }
    }
}

static void set_paint(const struct silmap_fills *fills, const author_silmap_shape *shape, silmap_paint *out) {
    float opacity = fminf(fmaxf(shape->opacity, 0), 1);
    for (uint32_t ch = 0; ch < fills->channels; ch++) {
        float value = ch < fills->coded ? zt_transfer_encode(ZT_TRANSFER_SRGB, shape->colour[ch]) : shape->colour[ch];
        out->value[ch] = opacity * ((int)ch == fills->alpha ? 1 : value);
    }
    out->keep = 1 - opacity;
}

static author_result fill_in(author_run *run, const author_silmap_input *input, size_t edges, silmap_truth *truth) {
    struct silmap_fills *fills = truth->fills;
    fills->paint = author_alloc(run, input->shape_count, sizeof *fills->paint);
    truth->edges = author_alloc(run, edges, sizeof *truth->edges);
    if (!fills->paint || !truth->edges)
        return AUTHOR_NO_MEMORY;
    for (size_t s = 0; s < input->shape_count; s++) {
        set_paint(fills, &input->shapes[s], &fills->paint[s]);
        put_edges(input, s, truth);
    }
    author_result result = silmap_edges_sort(run, truth);
    for (uint32_t r = 0; result == AUTHOR_OK && r < truth->rows; r++) {
        size_t band = truth->row_first[r + 1] - truth->row_first[r];
        fills->most_edges = band > fills->most_edges ? band : fills->most_edges;
    }
    return result;
}

author_result silmap_fills_create(author_run *run, const author_silmap_input *input, int plain, silmap_truth *truth) {
    size_t edges = 0;
    uint32_t channels = truth->picture->channels;
    author_result result = AUTHOR_OK;
    if (input->shape_count > MOST_SHAPES)
        return author_fail(run, AUTHOR_BAD_INPUT, "more than %zu shapes", MOST_SHAPES);
    for (size_t s = 0; s < input->shape_count && result == AUTHOR_OK; s++)
        result = check_shape(run, input, s, &edges);
    if (result != AUTHOR_OK)
        return result;
    truth->fills = author_alloc(run, 1, sizeof *truth->fills);
    if (!truth->fills)
        return AUTHOR_NO_MEMORY;
    int alpha = channels % 2 == 0 ? (int)channels - 1 : -1;
    *truth->fills = (struct silmap_fills){.shapes = input->shapes,
                                          .count = input->shape_count,
                                          .channels = channels,
                                          .coded = plain ? 0 : channels - (alpha >= 0),
                                          .alpha = alpha};
    return fill_in(run, input, edges, truth);
}

void silmap_fills_release(struct silmap_fills *fills) {
    if (fills)
        free(fills->paint);
    free(fills);
}

/* ---- scan lines ----------------------------------------------------------------------------------------- */

author_result silmap_sweep_create(const silmap_truth *truth, silmap_sweep *out) {
    author_run run = {0};
    size_t shapes = truth->fills->count, words = shapes / 64 + 1;
    *out = (silmap_sweep){.truth = truth};
    out->list = author_alloc(&run, truth->fills->most_edges + 1, sizeof *out->list);
    out->runs = author_alloc(&run, truth->fills->most_edges + 1, sizeof *out->runs);
    out->winding = author_alloc(&run, shapes + 1, sizeof *out->winding);
    out->inside = author_alloc(&run, words, sizeof *out->inside);
    out->summary = author_alloc(&run, words / 64 + 1, sizeof *out->summary);
    if (out->list && out->runs && out->winding && out->inside && out->summary)
        return AUTHOR_OK;
    silmap_sweep_release(out);
    return AUTHOR_NO_MEMORY;
}

void silmap_sweep_release(silmap_sweep *sweep) {
    free(sweep->list);
    free(sweep->runs);
    free(sweep->winding);
    free(sweep->inside);
    free(sweep->summary);
    *sweep = (silmap_sweep){0};
}

static int compare_crossings(const void *a, const void *b) {
    const silmap_crossing *p = a, *q = b;
    if (p->x < q->x || p->x > q->x)
        return p->x < q->x ? -1 : 1;
    return (p->edge > q->edge) - (p->edge < q->edge);
}

/* Lists are short mostly, and nearly in order where lines are. */
static void sort_crossings(silmap_crossing *list, size_t count) {
    if (count > FEW_CROSSINGS) {
        qsort(list, count, sizeof *list, compare_crossings);
        return;
    }
    for (size_t i = 1; i < count; i++) {
        silmap_crossing own = list[i];
        size_t k = i;
        for (; k > 0 && compare_crossings(&own, &list[k - 1]) < 0; k--)
            list[k] = list[k - 1];
        list[k] = own;
    }
}

void silmap_sweep_line(silmap_sweep *sweep, double y) {
    const silmap_truth *truth = sweep->truth;
    uint32_t band = silmap_edges_band(truth, y);
    sweep->count = 0;
    for (size_t i = truth->row_first[band]; i < truth->row_first[band + 1]; i++) {
        const silmap_edge *edge = &truth->edges[truth->row_edges[i]];
        if (y >= edge->y0 && y < edge->y1)
            sweep->list[sweep->count++] = (silmap_crossing){silmap_edge_x(edge, y), edge};
    }
    sort_crossings(sweep->list, sweep->count);
}

static int is_inside(const silmap_sweep *sweep, size_t shape) {
    int32_t winding = sweep->winding[shape];
    return sweep->truth->fills->shapes[shape].even_odd ? winding & 1 : winding != 0;
}

void silmap_sweep_cross(silmap_sweep *sweep, size_t i) {
    uint64_t mark = sweep->list[i].edge->mark;
    size_t shape = (size_t)(mark >> 1), word = shape / 64;
    sweep->winding[shape] += mark & 1 ? 1 : -1;
    if (sweep->truth->fills->shapes[shape].bounds)
        return;
    uint64_t bit = UINT64_C(1) << (shape % 64), group = UINT64_C(1) << (word % 64);
    if (is_inside(sweep, shape))
        sweep->inside[word] |= bit;
    else
        sweep->inside[word] &= ~bit;
    if (sweep->inside[word])
        sweep->summary[word / 64] |= group;
    else
        sweep->summary[word / 64] &= ~group;
}

static int highest_bit(uint64_t word) {
    int bit = 0;
    for (int step = 32; step; step /= 2) {
        if (word >> step) {
            word >>= step;
            bit += step;
        }
    }
    return bit;
}

static uint64_t bits_below(size_t n) {
    return (UINT64_C(1) << n) - 1; /* n < 64 */
}

/* The uppermost shape below number `top` that the line is inside of; SIZE_MAX: none. */
static size_t next_below(const silmap_sweep *sweep, size_t top) {
    size_t word = top / 64;
    uint64_t bits = sweep->inside[word] & bits_below(top % 64);
    if (bits)
        return word * 64 + (size_t)highest_bit(bits);
    size_t group = word / 64;
    bits = sweep->summary[group] & bits_below(word % 64);
    while (!bits && group > 0)
        bits = sweep->summary[--group];
    if (!bits)
        return SIZE_MAX;
    word = group * 64 + (size_t)highest_bit(bits);
    return word * 64 + (size_t)highest_bit(sweep->inside[word]);
}

static int is_bounded(const silmap_sweep *sweep, size_t shape) {
    const author_silmap_shape *shapes = sweep->truth->fills->shapes;
    uint32_t w = shapes[shape].within;
    while (w && is_inside(sweep, w - 1))
        w = shapes[w - 1].within;
    return w == 0;
}

void silmap_sweep_value(const silmap_sweep *sweep, float value[SILMAP_CHANNELS]) {
    const struct silmap_fills *fills = sweep->truth->fills;
    float keep = 1;
    memset(value, 0, SILMAP_CHANNELS * sizeof *value);
    size_t shape = fills->count;
    for (int layers = 0; layers < LAYERS && keep > LEAST_KEEP; layers++) {
        do
            shape = next_below(sweep, shape);
        while (shape != SIZE_MAX && !is_bounded(sweep, shape));
        if (shape == SIZE_MAX)
            return;
        for (uint32_t ch = 0; ch < fills->channels; ch++)
            value[ch] += keep * fills->paint[shape].value[ch];
        keep *= fills->paint[shape].keep;
    }
}

void silmap_sweep_end(silmap_sweep *sweep) {
    for (size_t i = 0; i < sweep->count; i++) {
        size_t shape = (size_t)(sweep->list[i].edge->mark >> 1);
        sweep->winding[shape] = 0;
        sweep->inside[shape / 64] = 0;
        sweep->summary[shape / 4096] = 0;
    }
    sweep->count = 0;
}

/* ---- colours -------------------------------------------------------------------------------------------- */

uint32_t silmap_fills_key(const float value[SILMAP_CHANNELS]) {
    uint32_t key = 0;
    for (int ch = 0; ch < SILMAP_CHANNELS; ch++)
        key = key << 8 | (uint32_t)(fminf(fmaxf(value[ch], 0), 1) * 255 + 0.5f);
    return key;
}

/* The first place that a crossing is not to the right of. */
static size_t place_after(double x, double x0, double dx, size_t count) {
    double at = ceil((x - x0) / dx);
    return at <= 0 ? 0 : at < (double)count ? (size_t)at : count;
}

size_t silmap_fills_runs(silmap_sweep *sweep, double y, double x0, double dx, size_t count) {
    float value[SILMAP_CHANNELS];
    size_t next = 0, at = 0, runs = 0;
    silmap_sweep_line(sweep, y);
    while (at < count) {
        while (next < sweep->count && place_after(sweep->list[next].x, x0, dx, count) <= at)
            silmap_sweep_cross(sweep, next++);
        silmap_sweep_value(sweep, value);
        at = next < sweep->count ? place_after(sweep->list[next].x, x0, dx, count) : count;
        sweep->runs[runs++] = (silmap_run){at, silmap_fills_key(value)};
    }
    silmap_sweep_end(sweep);
    return runs;
}

void silmap_fills_texel(const struct silmap_fills *fills, const float value[SILMAP_CHANNELS], float *texel) {
    float alpha = fills->alpha >= 0 ? value[fills->alpha] : 1;
    for (uint32_t ch = 0; ch < fills->channels; ch++) {
        float straight = alpha > 0 ? fminf(value[ch] / alpha, 1) : 0;
        texel[ch] = (int)ch == fills->alpha ? alpha
                    : ch < fills->coded     ? zt_transfer_decode(ZT_TRANSFER_SRGB, straight)
                                            : straight;
    }
}
