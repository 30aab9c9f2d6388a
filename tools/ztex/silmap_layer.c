/* SPDX-License-Identifier: Apache-2.0 */
/* Other layers of a silmap share its cells: a sample is the mean of what lies in the quadrants around it, never of what
 * lies behind a cut. */
#include "silmap.h"

#include <math.h>
#include <stdlib.h>

typedef struct averaging {
    const author_picture *picture;
    const author_silmap_place *place;
    const author_silmap_result *cells;
    author_picture *samples;
    double *sums; /* of each sample: the channels, then the weight */
    int alpha;    /* channel that weighs the others, or -1 */
} averaging;

static zt_silmap_cell look(const averaging *a, uint32_t x, uint32_t y) {
    const author_silmap_result *cells = a->cells;
    zt_silmap_cell cell;
    zt_silmap_cell_at(cells->cells, cells->cells_x, cells->cells_y, a->samples->width == cells->cells_x,
                      a->samples->height == cells->cells_y, x, y, &cell);
    return cell;
}

static size_t corner(const averaging *a, uint32_t x, uint32_t y, int quadrant) {
    uint32_t i = (x + (uint32_t)(quadrant & 1)) % a->samples->width;
    uint32_t j = (y + (uint32_t)(quadrant >> 1)) % a->samples->height;
    return (size_t)j * a->samples->width + i;
}

static void add(const averaging *a, size_t sample, const float *texel) {
    uint32_t channels = a->picture->channels;
    double *sum = a->sums + sample * (channels + 1);
    double weight = a->alpha >= 0 ? (double)texel[a->alpha] : 1;
    for (uint32_t c = 0; c < channels; c++)
        sum[c] += (int)c == a->alpha ? (double)texel[c] : weight * (double)texel[c];
    sum[channels]++;
}

static void add_row(const averaging *a, uint32_t row) {
    const author_picture *picture = a->picture;
    double y = (a->place->y + a->place->height * (row + 0.5) / picture->height) * a->cells->cells_y;
    if (!(y >= 0 && y < a->cells->cells_y))
        return;
    for (uint32_t column = 0; column < picture->width; column++) {
        double x = (a->place->x + a->place->width * (column + 0.5) / picture->width) * a->cells->cells_x;
        if (!(x >= 0 && x < a->cells->cells_x))
            continue;
        uint32_t i = (uint32_t)x, j = (uint32_t)y;
        zt_silmap_cell cell = look(a, i, j);
        int quadrant = zt_silmap_quadrant(&cell, x - i, y - j);
        add(a, corner(a, i, j, quadrant),
            picture->texels + ((size_t)row * picture->width + column) * picture->channels);
    }
}

/* A sample with so small quadrants that no texel's centre is in them has the texel that it stands on. */
static void fill_gap(const averaging *a, size_t sample) {
    const author_picture *picture = a->picture;
    size_t i = sample % a->samples->width, j = sample / a->samples->width;
    size_t x = (size_t)(((double)i / a->cells->cells_x - a->place->x) / a->place->width * picture->width);
    size_t y = (size_t)(((double)j / a->cells->cells_y - a->place->y) / a->place->height * picture->height);
    x = x < picture->width ? x : picture->width - 1;
    y = y < picture->height ? y : picture->height - 1;
    add(a, sample, picture->texels + (y * picture->width + x) * picture->channels);
}

static void divide(const double *sum, uint32_t channels, int alpha, float *to) {
    double cover = alpha >= 0 ? sum[alpha] : sum[channels];
    for (uint32_t c = 0; c < channels; c++) {
        double by = (int)c == alpha ? sum[channels] : cover;
        to[c] = by > 0 ? (float)(sum[c] / by) : 0.0f;
    }
}

/* Corners weighted by the areas of their quadrants. */
static void minify_cell(const averaging *a, uint32_t x, uint32_t y, float *to) {
    uint32_t channels = a->picture->channels;
    double areas[4], sum[5] = {0};
    zt_silmap_cell cell = look(a, x, y);
    zt_silmap_areas(&cell, areas);
    for (int k = 0; k < 4; k++) {
        const float *from = a->samples->texels + corner(a, x, y, k) * channels;
        double weight = areas[k] * (a->alpha >= 0 ? (double)from[a->alpha] : 1);
        for (uint32_t c = 0; c < channels; c++)
            sum[c] += ((int)c == a->alpha ? areas[k] : weight) * (double)from[c];
        sum[channels] += areas[k];
    }
    divide(sum, channels, a->alpha, to);
}

author_result silmap_layer_fit(author_run *run, const author_picture *picture, const author_silmap_place *place,
                               const author_silmap_result *cells, author_picture *samples, author_picture *minified) {
    uint32_t width = cells->samples.width, height = cells->samples.height, channels = picture->channels;
    size_t count = (size_t)width * height;
    averaging a = {.picture = picture, .place = place, .cells = cells, .samples = samples};
    a.alpha = channels == 2 || channels == 4 ? (int)channels - 1 : -1;
    *minified = (author_picture){0};
    author_result result = author_picture_create(run, width, height, channels, samples);
    if (result == AUTHOR_OK)
        result = author_picture_create(run, cells->cells_x, cells->cells_y, channels, minified);
    a.sums = result == AUTHOR_OK ? author_alloc(run, count, (channels + 1) * sizeof *a.sums) : NULL;
    if (!a.sums) {
        author_picture_release(samples);
        author_picture_release(minified);
        return AUTHOR_NO_MEMORY;
    }
    for (uint32_t y = 0; y < picture->height; y++)
        add_row(&a, y);
    for (size_t s = 0; s < count; s++) {
        if (!(a.sums[s * (channels + 1) + channels] > 0))
            fill_gap(&a, s);
        divide(a.sums + s * (channels + 1), channels, a.alpha, samples->texels + s * channels);
    }
    for (uint32_t y = 0; y < minified->height; y++)
        for (uint32_t x = 0; x < minified->width; x++)
            minify_cell(&a, x, y, minified->texels + ((size_t)y * minified->width + x) * channels);
    free(a.sums);
    return AUTHOR_OK;
}
