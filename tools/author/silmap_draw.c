/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The picture of a flat drawing, each texel the mean over its box. A row is cut into bands at the points of all lines,
 * if these are not too many; a band in which no line ends and no two lines cross is made of trapezoids, and what
 * changes at a line changes the texels to the right of it by the area that they have there: exactly. Other bands are
 * halved some times.
 */
#include "silmap_fill.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LOWEST (1.5 / 32) /* of a row: the lowest band that is halved */
#define SAME_PLACE 1e-12  /* of lines that meet */
#define MOST_CUTS 32 /* of a row at ends of lines: where there are more, at that of the tallest line in each 32nd */

typedef struct draw_job {
    silmap_truth truth;
    author_picture *picture;
    silmap_sweep *sweeps; /* of each worker */
    double **changes;     /* of each worker: what changes from each texel to the next */
} draw_job;

typedef struct draw_row {
    const draw_job *job;
    silmap_sweep *sweep;
    double *changes;
    double scale_x, scale_y; /* texels */
} draw_row;

/* The integral over a band of the width between a line and `to`, the line being to the left; it goes from low to
 * high. */
static double area_before(double low, double high, double to) {
    if (to <= low)
        return 0;
    if (to >= high)
        return to - (low + high) / 2;
    return (to - low) * (to - low) / (2 * (high - low));
}

/* To the right of a line from xa to xb in a band of that height the colour is another one. */
static void change_at(const draw_row *row, double xa, double xb, double height, const float by[SILMAP_CHANNELS]) {
    uint32_t width = row->job->picture->width, channels = row->job->picture->channels;
    double low = fmin(xa, xb), high = fmax(xa, xb), covered = 0;
    if (low >= width)
        return;
    size_t first = low > 0 ? (size_t)low : 0, last = high < 0 ? 0 : high < width ? (size_t)high : width - 1;
    double before = area_before(low, high, (double)first);
    for (size_t x = first; x <= last + 1 && x < width; x++) {
        double after = area_before(low, high, (double)x + 1);
        double share = x <= last ? after - before : 1;
        for (uint32_t ch = 0; ch < channels; ch++)
            row->changes[x * channels + ch] += (share - covered) * height * (double)by[ch];
        covered = share;
        before = after;
    }
}

/* Where a line crosses a border of the band, or where it ends before. */
static double x_at(const silmap_edge *edge, double y) {
    return silmap_edge_x(edge, fmin(fmax(y, edge->y0), edge->y1));
}

/* Whether the lines that cross the band do not end in it, and are in the same order at both of its ends. */
static int is_simple(const silmap_sweep *sweep, double top, double bottom) {
    double x0 = -INFINITY, x1 = -INFINITY;
    for (size_t i = 0; i < sweep->count; i++) {
        const silmap_edge *edge = sweep->list[i].edge;
        double a = x_at(edge, top), b = x_at(edge, bottom);
        if (edge->y0 > top + SAME_PLACE || edge->y1 < bottom - SAME_PLACE)
            return 0;
        if (a < x0 - SAME_PLACE || b < x1 - SAME_PLACE)
            return 0;
        x0 = a;
        x1 = b;
    }
    return 1;
}

static void draw_line(const draw_row *row, double top, double bottom) {
    silmap_sweep *sweep = row->sweep;
    float before[SILMAP_CHANNELS] = {0}, after[SILMAP_CHANNELS], by[SILMAP_CHANNELS];
    for (size_t i = 0; i < sweep->count;) {
        const silmap_crossing *at = &sweep->list[i];
        while (i < sweep->count && sweep->list[i].x <= at->x)
            silmap_sweep_cross(sweep, i++);
        silmap_sweep_value(sweep, after);
        if (memcmp(before, after, sizeof after) == 0)
            continue;
        for (int ch = 0; ch < SILMAP_CHANNELS; ch++)
            by[ch] = after[ch] - before[ch];
        change_at(row, x_at(at->edge, top) * row->scale_x, x_at(at->edge, bottom) * row->scale_x,
                  (bottom - top) * row->scale_y, by);
        memcpy(before, after, sizeof before);
    }
}

static void draw_band(const draw_row *row, double top, double bottom) {
    double middle = (top + bottom) / 2;
    silmap_sweep_line(row->sweep, middle);
    if ((bottom - top) * row->scale_y > LOWEST && !is_simple(row->sweep, top, bottom)) {
        silmap_sweep_end(row->sweep);
        draw_band(row, top, middle);
        draw_band(row, middle, bottom);
        return;
    }
    draw_line(row, top, bottom);
    silmap_sweep_end(row->sweep);
}

static int compare_places(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Where the row is cut: its ends and those of lines in it. What ends at corners is taller than the pieces of a
 * curve. */
static size_t find_cuts(const silmap_truth *truth, double top, double bottom, double cuts[MOST_CUTS + 2]) {
    double one[MOST_CUTS], height[MOST_CUTS] = {0};
    size_t found = 0, count = 0;
    for (int i = 0; i < MOST_CUTS; i++)
        one[i] = top;
    for (size_t i = truth->row_first[silmap_edges_band(truth, top)];
         i < truth->row_first[silmap_edges_band(truth, bottom) + 1]; i++) {
        const silmap_edge *edge = &truth->edges[truth->row_edges[i]];
        for (int end = 0; end < 2; end++) {
            double y = end ? edge->y1 : edge->y0;
            if (y <= top || y >= bottom)
                continue;
            size_t part = (size_t)((y - top) / (bottom - top) * MOST_CUTS);
            part = part < MOST_CUTS ? part : MOST_CUTS - 1;
            if (edge->y1 - edge->y0 > height[part]) {
                height[part] = edge->y1 - edge->y0;
                one[part] = y;
            }
            if (found++ < MOST_CUTS)
                cuts[count++] = y;
        }
    }
    for (count = found > MOST_CUTS ? 0 : count; found > MOST_CUTS && count < MOST_CUTS; count++)
        cuts[count] = one[count];
    cuts[count++] = top;
    cuts[count++] = bottom;
    qsort(cuts, count, sizeof *cuts, compare_places);
    return count;
}

/* The sums of the changes. */
static void put_texels(const draw_row *row, float *texel) {
    const struct silmap_fills *fills = row->job->truth.fills;
    uint32_t channels = fills->channels;
    double sum[SILMAP_CHANNELS] = {0};
    float value[SILMAP_CHANNELS] = {0};
    for (size_t x = 0; x < row->job->picture->width; x++, texel += channels) {
        int same = x > 0;
        for (uint32_t ch = 0; ch < channels; ch++) {
            double by = row->changes[x * channels + ch];
            same = same && !(by < 0) && !(by > 0);
            sum[ch] += by;
            value[ch] = (float)fmin(fmax(sum[ch], 0), 1);
        }
        if (same)
            memcpy(texel, texel - channels, channels * sizeof *texel);
        else
            silmap_fills_texel(fills, value, texel);
    }
}

static author_result visit_row(void *context, size_t y, unsigned worker, char *error) {
    (void)error;
    const draw_job *job = context;
    const author_picture *picture = job->picture;
    size_t values = (size_t)picture->width * picture->channels;
    draw_row row = {job, &job->sweeps[worker], job->changes[worker], picture->width, picture->height};
    double cuts[MOST_CUTS + 2];
    size_t count = find_cuts(&job->truth, (double)y / picture->height, (double)(y + 1) / picture->height, cuts);
    memset(row.changes, 0, values * sizeof *row.changes);
    for (size_t i = 0; i + 1 < count; i++)
        if (cuts[i] < cuts[i + 1])
            draw_band(&row, cuts[i], cuts[i + 1]);
    put_texels(&row, picture->texels + y * values);
    return AUTHOR_OK;
}

static author_result draw_rows(author_run *run, draw_job *job) {
    unsigned workers = author_workers(run);
    job->sweeps = author_alloc(run, workers, sizeof *job->sweeps);
    job->changes = author_alloc(run, workers, sizeof *job->changes);
    author_result result = job->sweeps && job->changes ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (unsigned i = 0; i < workers && result == AUTHOR_OK; i++) {
        job->changes[i] = author_alloc(run, (size_t)job->picture->width * job->picture->channels, sizeof(double));
        result = job->changes[i] ? silmap_sweep_create(&job->truth, &job->sweeps[i]) : AUTHOR_NO_MEMORY;
    }
    if (result == AUTHOR_OK)
        result = author_for(run, "drawing", job->picture->height, visit_row, job);
    for (unsigned i = 0; job->sweeps && job->changes && i < workers; i++) {
        silmap_sweep_release(&job->sweeps[i]);
        free(job->changes[i]);
    }
    free(job->sweeps);
    free(job->changes);
    return result;
}

author_result author_silmap_draw(author_run *run, const author_silmap_input *input, int plain,
                                 author_picture *picture) {
    draw_job job = {.truth = {.picture = picture}, .picture = picture};
    author_result result = silmap_fills_create(run, input, plain, &job.truth);
    if (result == AUTHOR_OK)
        result = draw_rows(run, &job);
    if (result == AUTHOR_NO_MEMORY)
        author_fail(run, result, "no memory to draw %zu shapes", input->shape_count);
    silmap_truth_release(&job.truth);
    return result;
}
