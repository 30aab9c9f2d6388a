/* SPDX-License-Identifier: Apache-2.0 */
/* Pyramids of brightness, out of which everything is registered. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "zipmap_private.h"

/* A texel: three numbers of 10 bits, square roots of red, green and blue light. */
enum { WHITE = 1000, CLIPPED = 1023, BITS = 10, LEAST_EDGE = 8 };

static const float FULL = 0.995F; /* light from which on a channel may have been cut off */

/* What a clipped texel counts when levels are made: two of four make the average a clipped one as well. */
static const float CLIPPED_LIGHT = 1.2F;

const float LUMA_GREY[3] = {0.2126F, 0.7152F, 0.0722F};

static uint32_t code_of(float light) {
    if (light >= FULL)
        return CLIPPED;
    return light > 0 ? (uint32_t)(sqrtf(light) * WHITE + 0.5F) : 0; /* 0 also where the picture has a NaN */
}

static uint32_t channel_of(uint32_t texel, int channel) {
    return texel >> (channel * BITS) & CLIPPED;
}

/* Light of a code times a weight. */
static void table_of(float weight, float clipped, float table[CLIPPED + 1]) {
    for (int i = 0; i <= CLIPPED; i++)
        table[i] = weight * ((float)i / WHITE) * ((float)i / WHITE);
    table[CLIPPED] = weight > 0 ? weight * clipped : 0;
}

author_result luma_level_create(author_run *run, uint32_t width, uint32_t height, luma_level *out) {
    *out = (luma_level){.width = width, .height = height};
    out->texels = author_alloc(run, (size_t)width * height, sizeof *out->texels);
    return out->texels ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

/* ---- area averages ---------------------------------------------------------------------------------------- */

/* Which texels of a row of `from` make texel i of one of `to`, and the share of the first and the last. */
typedef struct span {
    uint32_t first, last; /* inclusive */
    float head, tail, scale;
} span;

static span span_of(uint32_t i, uint32_t from, uint32_t to) {
    double step = (double)from / to, a = i * step, b = (i + 1) * step;
    span out = {.first = (uint32_t)a, .last = (uint32_t)b};
    if (out.last >= from || out.last == b)
        out.last = out.last > out.first ? (uint32_t)ceil(b) - 1 : out.first;
    if (out.last >= from)
        out.last = from - 1;
    out.head = (float)(out.first + 1 - a);
    out.tail = (float)(b - out.last);
    if (out.first == out.last)
        out.head = (float)(b - a);
    out.scale = (float)(1 / step);
    return out;
}

/* Area averages of one row after the other. */
typedef struct shrink {
    const uint32_t *texels;
    uint32_t width, to_width;
    float (*tables)[CLIPPED + 1]; /* of each channel */
    span *columns;
    float *line; /* light of a row, of up to three channels after each other */
    float *row;  /* the average, likewise */
    int planes;  /* 1: the channels added up; 3 */
} shrink;

static void read_line(const shrink *s, uint32_t y) {
    const uint32_t *texels = s->texels + (size_t)y * s->width;
    for (size_t x = 0; x < s->width; x++) {
        float light[3];
        for (int c = 0; c < 3; c++)
            light[c] = s->tables[c][channel_of(texels[x], c)];
        if (s->planes == 1)
            s->line[x] = (light[0] + light[1]) + light[2];
        else
            for (size_t c = 0; c < 3; c++)
                s->line[c * s->width + x] = light[c];
    }
}

static void add_line(const shrink *s, size_t channel, float weight) {
    const float *line = s->line + channel * s->width;
    float *row = s->row + channel * s->to_width;
    for (uint32_t x = 0; x < s->to_width; x++) {
        const span *c = &s->columns[x];
        float sum = line[c->first] * c->head;
        for (uint32_t i = c->first + 1; i < c->last; i++)
            sum += line[i];
        if (c->last > c->first)
            sum += line[c->last] * c->tail;
        row[x] += sum * c->scale * weight;
    }
}

static void shrink_row(const shrink *s, uint32_t y, uint32_t from, uint32_t to) {
    span r = span_of(y, from, to);
    memset(s->row, 0, (size_t)s->planes * s->to_width * sizeof *s->row);
    for (uint32_t i = r.first; i <= r.last; i++) {
        read_line(s, i);
        for (int c = 0; c < s->planes; c++)
            add_line(s, (size_t)c, (i == r.first ? r.head : i == r.last ? r.tail : 1) * r.scale);
    }
}

static author_result shrink_open(author_run *run, const uint32_t *texels, uint32_t width, uint32_t to_width, int planes,
                                 shrink *out) {
    *out = (shrink){.texels = texels, .width = width, .to_width = to_width, .planes = planes};
    out->tables = author_alloc(run, 3, sizeof *out->tables);
    out->columns = author_alloc(run, to_width, sizeof *out->columns);
    out->line = author_alloc(run, width, (size_t)planes * sizeof *out->line);
    out->row = author_alloc(run, to_width, (size_t)planes * sizeof *out->row);
    if (!out->tables || !out->columns || !out->line || !out->row)
        return AUTHOR_NO_MEMORY;
    for (uint32_t x = 0; x < to_width; x++)
        out->columns[x] = span_of(x, width, to_width);
    return AUTHOR_OK;
}

static void shrink_close(shrink *s) {
    free(s->tables);
    free(s->columns);
    free(s->line);
    free(s->row);
}

author_result luma_shrink(author_run *run, const luma *pyramid, const float weights[3], float clipped, uint32_t width,
                          uint32_t height, luma_level *out) {
    uint32_t l = 0;
    shrink s = {0};
    while (l + 1 < pyramid->count && pyramid->level[l + 1].width >= width && pyramid->level[l + 1].height >= height)
        l++;
    author_result result = luma_level_create(run, width, height, out);
    if (result == AUTHOR_OK)
        result = shrink_open(run, pyramid->level[l].texels, pyramid->level[l].width, width, 1, &s);
    for (int c = 0; c < 3 && result == AUTHOR_OK; c++)
        table_of(weights[c], clipped, s.tables[c]);
    for (uint32_t y = 0; y < height && result == AUTHOR_OK; y++) {
        shrink_row(&s, y, pyramid->level[l].height, height);
        for (uint32_t x = 0; x < width; x++)
            out->texels[(size_t)y * width + x] = sqrtf(s.row[x]);
    }
    shrink_close(&s);
    return result;
}

author_result luma_crop(author_run *run, const luma *pyramid, const float weights[3], float clipped, uint32_t level,
                        const uint32_t box[4], luma_level *out) {
    uint32_t width = pyramid->level[level].width;
    shrink s = {0};
    author_result result = luma_level_create(run, box[2] - box[0], box[3] - box[1], out);
    if (result == AUTHOR_OK)
        result = shrink_open(run, pyramid->level[level].texels, width, 1, 1, &s);
    for (int c = 0; c < 3 && result == AUTHOR_OK; c++)
        table_of(weights[c], clipped, s.tables[c]);
    for (uint32_t y = 0; y < out->height && result == AUTHOR_OK; y++) {
        read_line(&s, box[1] + y);
        for (uint32_t x = 0; x < out->width; x++)
            out->texels[(size_t)y * out->width + x] = sqrtf(s.line[box[0] + x]);
    }
    shrink_close(&s);
    return result;
}

/* ---- the pyramid ------------------------------------------------------------------------------------------ */

static uint32_t packed(const float *light, size_t stride) {
    return code_of(light[0]) | code_of(light[stride]) << BITS | code_of(light[2 * stride]) << 2 * BITS;
}

static author_result halve(author_run *run, luma *pyramid) {
    uint32_t l = pyramid->count, w = pyramid->level[l - 1].width, h = pyramid->level[l - 1].height;
    uint32_t width = (w + 1) / 2, height = (h + 1) / 2;
    shrink s = {0};
    uint32_t *texels = author_alloc(run, (size_t)width * height, sizeof *texels);
    author_result result = texels ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    pyramid->level[l].width = width;
    pyramid->level[l].height = height;
    pyramid->level[l].texels = texels;
    pyramid->count = l + 1;
    if (result == AUTHOR_OK)
        result = shrink_open(run, pyramid->level[l - 1].texels, w, width, 3, &s);
    for (int c = 0; c < 3 && result == AUTHOR_OK; c++)
        table_of(1, CLIPPED_LIGHT, s.tables[c]);
    for (uint32_t y = 0; y < height && result == AUTHOR_OK; y++) {
        shrink_row(&s, y, h, height);
        for (uint32_t x = 0; x < width; x++)
            texels[(size_t)y * width + x] = packed(s.row + x, width);
    }
    shrink_close(&s);
    return result;
}

author_result luma_create(author_run *run, const author_picture *picture, luma *out) {
    size_t count = (size_t)picture->width * picture->height;
    uint32_t *texels = author_alloc(run, count, sizeof *texels);
    *out = (luma){.count = 1};
    if (!texels)
        return AUTHOR_NO_MEMORY;
    for (size_t i = 0; i < count; i++) {
        const float *texel = picture->texels + i * picture->channels, grey[3] = {*texel, *texel, *texel};
        texels[i] = packed(picture->channels < 3 ? grey : texel, 1);
    }
    out->level[0].width = picture->width;
    out->level[0].height = picture->height;
    out->level[0].texels = texels;
    author_result result = AUTHOR_OK;
    while (result == AUTHOR_OK && out->count < LUMA_LEVELS && out->level[out->count - 1].width > LEAST_EDGE &&
           out->level[out->count - 1].height > LEAST_EDGE)
        result = halve(run, out);
    return result;
}

void luma_release(luma *pyramid) {
    for (uint32_t l = 0; l < pyramid->count; l++)
        free(pyramid->level[l].texels);
    *pyramid = (luma){0};
}

/* ---- what is done with a level ---------------------------------------------------------------------------- */

static size_t clamped(double i, uint32_t count) {
    return i < 0 ? 0 : i > count - 1 ? count - 1 : (size_t)i;
}

/* Sums of 2 reach + 1 elements of a line. */
static void box_line(const float *from, float *to, size_t count, size_t stride, size_t reach) {
    double sum = 0;
    for (size_t i = 0; i < reach && i < count; i++)
        sum += (double)from[i * stride];
    for (size_t i = 0; i < count; i++) {
        if (i + reach < count)
            sum += (double)from[(i + reach) * stride];
        if (i > reach)
            sum -= (double)from[(i - reach - 1) * stride];
        to[i * stride] = (float)sum;
    }
}

static void box_blur(float *texels, float *scratch, uint32_t width, uint32_t height, size_t reach) {
    for (size_t y = 0; y < height; y++)
        box_line(texels + y * width, scratch + y * width, width, 1, reach);
    for (size_t x = 0; x < width; x++)
        box_line(scratch + x, texels + x, height, width, reach);
}

/* The mean of what is inside. */
static double mean_of(const luma_level *level, const uint8_t *inside) {
    double sum = 0, weight = 0;
    for (size_t i = 0; i < (size_t)level->width * level->height; i++) {
        sum += inside[i] ? (double)level->texels[i] : 0;
        weight += inside[i] ? 1 : 0;
    }
    return weight > 0 ? sum / weight : 0;
}

author_result luma_detail(author_run *run, const luma_level *level, const uint8_t *inside, uint32_t reach,
                          luma_level *out) {
    size_t count = (size_t)level->width * level->height;
    float *weights = author_alloc(run, count, 2 * sizeof *weights), *scratch = weights ? weights + count : NULL;
    float mean = (float)mean_of(level, inside);
    for (size_t i = 0; i < count && weights; i++) {
        weights[i] = inside[i] ? 1 : 0;
        out->texels[i] = inside[i] ? level->texels[i] - mean : 0;
    }
    for (int pass = 0; pass < 2 && weights; pass++) {
        box_blur(weights, scratch, level->width, level->height, reach);
        box_blur(out->texels, scratch, level->width, level->height, reach);
    }
    for (size_t i = 0; i < count && weights; i++)
        out->texels[i] = inside[i] ? level->texels[i] - mean - out->texels[i] / weights[i] : 0;
    free(weights);
    return weights ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

static float *texel_of(const luma_level *level, size_t i, uint32_t j, bool column) {
    return level->texels + (column ? (size_t)j * level->width + i : i * level->width + j);
}

/* 1 2 1 along each row or column, `passes` times. */
static void soften_lines(const luma_level *level, unsigned passes, bool column) {
    size_t lines = column ? level->width : level->height;
    uint32_t length = column ? level->height : level->width;
    for (size_t i = 0; i < lines; i++)
        for (unsigned pass = 0; pass < passes; pass++) {
            float before = *texel_of(level, i, 0, column);
            for (uint32_t j = 0; j < length; j++) {
                float *texel = texel_of(level, i, j, column), own = *texel;
                float after = *texel_of(level, i, j + 1 < length ? j + 1 : j, column);
                *texel = 0.25F * ((before + after) + 2 * own);
                before = own;
            }
        }
}

void luma_soften(luma_level *level, unsigned passes) {
    size_t count = (size_t)level->width * level->height;
    for (size_t i = 0; i < count; i++)
        level->texels[i] *= level->texels[i];
    soften_lines(level, passes, false);
    soften_lines(level, passes, true);
    for (size_t i = 0; i < count; i++)
        level->texels[i] = sqrtf(level->texels[i]);
}

static void cubic(float t, float weight[4]) {
    float s = t * t;
    weight[0] = ((2 - t) * t - 1) * t / 2;
    weight[1] = ((3 * t - 5) * s + 2) / 2;
    weight[2] = ((4 - 3 * t) * t + 1) * t / 2;
    weight[3] = (t - 1) * s / 2;
}

static float sample_row(const float *line, const size_t columns[4], const float weight[4]) {
    return (line[columns[0]] * weight[0] + line[columns[1]] * weight[1]) +
           (line[columns[2]] * weight[2] + line[columns[3]] * weight[3]);
}

/* Where all 16 texels are there: most lookups by far. */
static float sample_inside(const float *corner, size_t width, const float across[4], const float down[4]) {
    float value = 0;
    for (size_t i = 0; i < 4; i++) {
        const float *line = corner + i * width;
        value += down[i] * ((line[0] * across[0] + line[1] * across[1]) + (line[2] * across[2] + line[3] * across[3]));
    }
    return value;
}

float luma_sample(const luma_level *level, double x, double y) {
    double left = floor(x - 0.5), top = floor(y - 0.5);
    float across[4], down[4], value = 0;
    size_t columns[4];
    cubic((float)(x - 0.5 - left), across);
    cubic((float)(y - 0.5 - top), down);
    if (left >= 1 && top >= 1 && left + 2 < level->width && top + 2 < level->height)
        return sample_inside(level->texels + ((size_t)top - 1) * level->width + (size_t)left - 1, level->width, across,
                             down);
    for (int i = 0; i < 4; i++)
        columns[i] = clamped(left + i - 1, level->width);
    for (int i = 0; i < 4; i++)
        value += down[i] *
                 sample_row(level->texels + clamped(top + i - 1, level->height) * level->width, columns, across);
    return value;
}

author_result luma_bytes(author_run *run, const luma_level *level, uint8_t **out) {
    size_t count = (size_t)level->width * level->height;
    *out = author_alloc(run, count, 1);
    for (size_t i = 0; i < count && *out; i++) {
        float code = level->texels[i] * 255 + 0.5F;
        (*out)[i] = code < 255 ? (uint8_t)code : 255;
    }
    return *out ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}
