/* SPDX-License-Identifier: Apache-2.0 */
/* How far the colours of each patch and of its parent are apart: what was stored counts, not what was meant. */
#include "heap_report.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MOST_TEXELS (UINT64_C(4) << 20) /* of a parent that are held */
#define SEEN 0.02f                      /* coverage that is taken to show */
#define OWN_CHANGE 0.5                  /* texels of the parent */
#define BLURRED 2.0                     /* texels at the border of the patch that are not looked at, */
#define SOFT 4.0                        /* and of those behind them, over which windows end */
#define LEAST_SEAM 8.0                  /* of a place that is measured; a texel counts 1 where it is half transparent */

/* ---- decoded levels ------------------------------------------------------------------------------------------ */

static void to_linear(const zt_image_info *info, float *texel) {
    for (int c = 0; c < 3; c++) {
        texel[c] = zt_transfer_decode(info->transfer, texel[c]);
        if (info->alpha_mode == ZT_ALPHA_PREMULTIPLIED)
            texel[c] = texel[3] > 0.0f ? texel[c] / texel[3] : 0.0f;
    }
    if (info->alpha_mode == ZT_ALPHA_NONE)
        texel[3] = 1.0f;
}

int heap_flat_load(const zt_file *file, uint32_t image, uint32_t level, heap_flat *out) {
    zt_image_info info;
    zt_level_info size;
    zt_diag diag = {.offset = UINT64_MAX};
    *out = (heap_flat){0};
    if (zt_get_image(file, image, &info) != ZT_OK || zt_get_level(file, image, level, &size) != ZT_OK)
        return cmd_fail(CMD_INTERNAL, "report: image %u has no level %u", (unsigned)image, (unsigned)level);
    size_t count = (size_t)size.width * size.height;
    void *bytes = malloc((size_t)size.layer_size);
    out->texels = malloc(count * 4 * sizeof *out->texels);
    out->width = size.width;
    out->height = size.height;
    zt_result result = bytes && out->texels ? ZT_OK : ZT_NO_MEMORY;
    if (result == ZT_OK)
        result = zt_decode_level(file, image, level, 0, bytes, (size_t)size.layer_size, 0, NULL, &diag);
    if (result == ZT_OK)
        result = zt_unpack_texels(info.format, bytes, count, out->texels);
    free(bytes);
    if (result != ZT_OK) {
        free(out->texels);
        *out = (heap_flat){0};
        return cmd_fail_result("report", result, &diag);
    }
    for (size_t i = 0; i < count; i++)
        to_linear(&info, out->texels + 4 * i);
    return CMD_OK;
}

int heap_flat_coverage(const zt_file *file, uint32_t texture, uint32_t patch, uint32_t level, heap_flat *out) {
    zt_patch_info info;
    if (zt_get_patch(file, texture, patch, &info) != ZT_OK)
        return cmd_fail(CMD_INTERNAL, "report: there is no patch %u", (unsigned)patch);
    uint32_t image = info.mask == ZT_NONE ? zt_get_patch_image(file, texture, patch, 0) : info.mask;
    int status = heap_flat_load(file, image, level, out);
    for (size_t i = 0; info.mask != ZT_NONE && out->texels && i < (size_t)out->width * out->height; i++)
        out->texels[4 * i + 3] = out->texels[4 * i];
    return status;
}

static void look_up(const heap_flat *flat, double u, double v, float out[4]) {
    double x = fmin(fmax(u * flat->width - 0.5, 0.0), flat->width - 1.0);
    double y = fmin(fmax(v * flat->height - 0.5, 0.0), flat->height - 1.0);
    uint32_t x0 = (uint32_t)x, y0 = (uint32_t)y;
    uint32_t x1 = x0 + 1 < flat->width ? x0 + 1 : x0, y1 = y0 + 1 < flat->height ? y0 + 1 : y0;
    float fx = (float)(x - x0), fy = (float)(y - y0);
    const float *rows[2] = {flat->texels + 4 * (size_t)y0 * flat->width, flat->texels + 4 * (size_t)y1 * flat->width};
    for (int c = 0; c < 4; c++) {
        float top = rows[0][4 * (size_t)x0 + (size_t)c] * (1.0f - fx) + rows[0][4 * (size_t)x1 + (size_t)c] * fx;
        float low = rows[1][4 * (size_t)x0 + (size_t)c] * (1.0f - fx) + rows[1][4 * (size_t)x1 + (size_t)c] * fx;
        out[c] = top * (1.0f - fy) + low * fy;
    }
}

/* ---- places -------------------------------------------------------------------------------------------------- */

static int apply(const double m[9], double u, double v, double *x, double *y) {
    double w = m[6] * u + m[7] * v + m[8];
    if (!(w > 0.0))
        return -1;
    *x = (m[0] * u + m[1] * v + m[2]) / w;
    *y = (m[3] * u + m[4] * v + m[5]) / w;
    return 0;
}

static int root_inverse(const zt_file *file, uint32_t texture, uint32_t patch, double out[9]) {
    zt_patch_info info;
    if (zt_get_patch(file, texture, patch, &info) != ZT_OK || make_matrix_invert(info.root_matrix, out))
        return -1;
    /* The sign that keeps w positive inside the patch. */
    if (out[6] * 0.5 + out[7] * 0.5 + out[8] < 0.0)
        for (int i = 0; i < 9; i++)
            out[i] = -out[i];
    return 0;
}

int heap_patch_corner(const zt_file *file, uint32_t texture, uint32_t patch, int i, double *u, double *v) {
    double back[9];
    if (root_inverse(file, texture, patch, back))
        return -1;
    return apply(back, i == 1 || i == 2, i >= 2, u, v);
}

/* A patch and its parent in one of the two files, both low-passed alike. */
typedef struct side {
    zt_patch_info patch, parent;
    uint32_t level, below_level;
    heap_flat own, below;
} side;

static void side_release(side *s) {
    free(s->own.texels);
    free(s->below.texels);
}

/* Texels of the parent along a texel of the patch, on the average. */
static double parent_texels(const zt_file *file, uint32_t texture, uint32_t patch, const zt_patch_info *info,
                            const zt_image_info *own, const zt_image_info *below) {
    double area = 0.0, x[4], y[4];
    for (int i = 0; i < 4; i++) {
        double u, v;
        zt_patch_info parent;
        if (heap_patch_corner(file, texture, patch, i, &u, &v) ||
            zt_get_patch(file, texture, info->parent, &parent) != ZT_OK ||
            apply(parent.root_matrix, u, v, &x[i], &y[i]))
            return 1.0;
    }
    for (int i = 0; i < 4; i++)
        area += x[i] * y[(i + 1) % 4] - x[(i + 1) % 4] * y[i];
    return sqrt(fabs(area) / 2.0 * below->width * below->height / ((double)own->width * own->height));
}

static uint32_t least(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

/* Level of the patch's image whose texels are as large as those of the parent's level. */
static uint32_t level_for(double texels, uint32_t parent_level, uint32_t levels) {
    double level = parent_level - log2(texels);
    return least(level > 0.0 ? (uint32_t)(level + 0.5) : 0, levels - 1);
}

/* Which images, and which of their levels. */
static int side_find(const zt_file *file, const heap_seam *seam, side *s, uint32_t images[2]) {
    zt_image_info own, below;
    memset(s, 0, sizeof *s);
    if (zt_get_patch(file, seam->texture, seam->patch, &s->patch) != ZT_OK ||
        zt_get_patch(file, seam->texture, s->patch.parent, &s->parent) != ZT_OK)
        return cmd_fail(CMD_INTERNAL, "report: there is no patch %u", (unsigned)seam->patch);
    images[0] = zt_get_patch_image(file, seam->texture, seam->patch, 0);
    images[1] = zt_get_patch_image(file, seam->texture, s->patch.parent, 0);
    if (zt_get_image(file, images[0], &own) != ZT_OK || zt_get_image(file, images[1], &below) != ZT_OK)
        return cmd_fail(CMD_INTERNAL, "report: patch %u has no image", (unsigned)seam->patch);
    while (s->below_level + 1 < below.levels &&
           ((uint64_t)below.width * below.height >> 2 * s->below_level) > MOST_TEXELS)
        s->below_level++;
    double texels = parent_texels(file, seam->texture, seam->patch, &s->patch, &own, &below);
    s->level = level_for(texels, s->below_level, own.levels);
    return CMD_OK;
}

static int side_load(const zt_file *file, const heap_seam *seam, side *s) {
    uint32_t images[2];
    int status = side_find(file, seam, s, images);
    if (status == CMD_OK)
        status = heap_flat_load(file, images[0], s->level, &s->own);
    return status == CMD_OK ? heap_flat_load(file, images[1], s->below_level, &s->below) : status;
}

/* ---- figures ------------------------------------------------------------------------------------------------- */

/* Sums over texels, each counted by its weight. */
typedef struct sum {
    double own[3], below[3], weight;
    double moved[2][3]; /* below, by how much it differs OWN_CHANGE further right and down */
} sum;

/* A square of the patch that the seam goes through. */
typedef struct place {
    sum around; /* by a window that begins and ends softly, twice as wide: hard ones would count edges that are not
                   equally sharp */
    sum seam;   /* the square itself, by how much of both is seen */
} place;

typedef struct gathering {
    double *steps; /* of each place along the seam */
    size_t count;
    double worst; /* beyond what a parent makes of it that is placed or blurred a little differently */
    double sharp; /* the largest on the seam itself */
    sum all;      /* that the patch covers by more than half */
} gathering;

static int by_size(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double coded(double light) {
    return 255.0 * (double)zt_transfer_encode(ZT_TRANSFER_SRGB, (float)light);
}

/* Between the means of both, less `changes` times what the parent's would differ by if it were moved a little, in the
 * channel in which it is largest. */
static double step_of(const sum *at, double changes) {
    double worst = 0.0, n = at->weight > 0.0 ? at->weight : 1.0;
    for (int c = 0; c < 3; c++) {
        double below = at->below[c] / n, step = fabs(coded(at->own[c] / n) - coded(below));
        double change = coded(below + hypot(at->moved[0][c], at->moved[1][c]) / n) - coded(below);
        worst = fmax(worst, step - changes * change);
    }
    return worst;
}

/* What is seen at one place. */
typedef struct sight {
    double x, y; /* of the parent */
    float own[4], below[4];
} sight;

static void add(sum *at, const sight *here, double weight) {
    for (int c = 0; c < 3; c++) {
        at->own[c] += weight * (double)here->own[c];
        at->below[c] += weight * (double)here->below[c];
    }
    at->weight += weight;
}

static heap_steps steps_of(gathering *g) {
    heap_steps s = {0};
    qsort(g->steps, g->count, sizeof *g->steps, by_size);
    if (g->count > 0) {
        s.median = g->steps[g->count / 2];
        s.high = g->steps[g->count * 95 / 100];
        s.worst = g->worst;
        s.sharp = g->sharp;
    }
    s.mean = step_of(&g->all, 0.0);
    return s;
}

/* What both show at root coordinates u, v. 0 where the parent ends. */
static int look_at(const side *s, double u, double v, sight *out) {
    double x, y;
    if (apply(s->patch.root_matrix, u, v, &x, &y) || apply(s->parent.root_matrix, u, v, &out->x, &out->y))
        return 0;
    if (out->x < 0.0 || out->x > 1.0 || out->y < 0.0 || out->y > 1.0)
        return 0;
    look_up(&s->own, x, y, out->own);
    look_up(&s->below, out->x, out->y, out->below);
    return 1;
}

static void add_moved(sum *at, const heap_flat *below, const sight *here, double weight) {
    float from[4], to[4];
    for (int i = 0; i < 2; i++) {
        double x = i ? 0.0 : OWN_CHANGE / below->width, y = i ? OWN_CHANGE / below->height : 0.0;
        look_up(below, here->x - x, here->y - y, from);
        look_up(below, here->x + x, here->y + y, to);
        for (int c = 0; c < 3; c++)
            at->moved[i][c] += weight * (double)(to[c] - from[c]) / 2.0;
    }
}

static void close_place(const place *at, gathering *g) {
    if (at->seam.weight < LEAST_SEAM)
        return;
    g->steps[g->count++] = step_of(&at->around, 0.0);
    g->worst = fmax(g->worst, step_of(&at->around, 1.0));
    g->sharp = fmax(g->sharp, step_of(&at->seam, 0.0));
}

typedef struct measuring {
    const side *sides[2]; /* before, after */
    gathering sums[2];
    const heap_flat *coverage;
    double back[9]; /* the patch's coordinates to the root's */
    heap_seam *seam;
} measuring;

/* From 0 over 1 to 0, where the square is the middle half. */
static double window(uint32_t at, uint32_t from, uint32_t edge) {
    double t = ((double)at - (double)from + 0.5 + edge / 2.0) / (2.0 * edge);
    return 0.5 - 0.5 * cos(2.0 * 3.14159265358979323846 * t);
}

/* From 0 at the border of the patch, where the parent shows some of what is outside, to 1. */
static double inwards(const heap_flat *coverage, uint32_t x, uint32_t y) {
    uint32_t across = least(x, coverage->width - 1 - x), down = least(y, coverage->height - 1 - y);
    return fmin(fmax(((double)least(across, down) + 0.5 - BLURRED) / SOFT, 0.0), 1.0);
}

/* One texel of the coverage, within or around the square at x0, y0. */
static void gather(measuring *m, uint32_t x, uint32_t y, uint32_t x0, uint32_t y0, uint32_t edge, int seam,
                   place places[2]) {
    const heap_flat *coverage = m->coverage;
    double u, v, alpha = (double)coverage->texels[4 * ((size_t)y * coverage->width + x) + 3];
    int within = x >= x0 && y >= y0 && x - x0 < edge && y - y0 < edge;
    if (within) {
        m->seam->opaque += alpha >= 1.0 - SEEN;
        m->seam->partly += alpha > SEEN && alpha < 1.0 - SEEN;
    }
    if (apply(m->back, (x + 0.5) / coverage->width, (y + 0.5) / coverage->height, &u, &v))
        return;
    for (int i = 0; i < 2; i++) {
        sight here;
        if (!look_at(m->sides[i], u, v, &here))
            continue;
        if (seam) {
            double weight = window(x, x0, edge) * window(y, y0, edge) * inwards(coverage, x, y);
            add(&places[i].around, &here, weight);
            add_moved(&places[i].around, &m->sides[i]->below, &here, weight);
        }
        if (within && alpha > SEEN && alpha < 1.0 - SEEN)
            add(&places[i].seam, &here, 4.0 * alpha * (1.0 - alpha));
        if (within && alpha > 0.5)
            add(&m->sums[i].all, &here, 1.0);
    }
}

static int has_seam(const heap_flat *coverage, uint32_t x0, uint32_t y0, uint32_t edge) {
    int found = 0;
    for (uint32_t y = y0; y < y0 + edge && y < coverage->height && !found; y++)
        for (uint32_t x = x0; x < x0 + edge && x < coverage->width && !found; x++) {
            float alpha = coverage->texels[4 * ((size_t)y * coverage->width + x) + 3];
            found = alpha > SEEN && alpha < 1.0f - SEEN;
        }
    return found;
}

/* A square of edge x edge texels of the coverage. */
static void measure_square(measuring *m, uint32_t x0, uint32_t y0, uint32_t edge) {
    place places[2];
    memset(places, 0, sizeof places);
    uint32_t half = edge / 2, left = x0 < half ? 0 : x0 - half, top = y0 < half ? 0 : y0 - half;
    int seam = has_seam(m->coverage, x0, y0, edge);
    for (uint32_t y = top; y < y0 + edge + half && y < m->coverage->height; y++)
        for (uint32_t x = left; x < x0 + edge + half && x < m->coverage->width; x++)
            gather(m, x, y, x0, y0, edge, seam, places);
    for (int i = 0; i < 2; i++)
        close_place(&places[i], &m->sums[i]);
}

static int measure(const heap_report *report, heap_seam *seam, const side *before, const side *after,
                   const heap_flat *coverage) {
    uint32_t whole = HEAP_LOWPASS;
    uint32_t edge = whole >> after->below_level ? whole >> after->below_level : 1;
    size_t texels = (size_t)coverage->width * coverage->height;
    double *room = malloc(2 * texels * sizeof *room);
    measuring m = {.sides = {before, after},
                   .sums = {{.steps = room}, {.steps = room ? room + texels : NULL}},
                   .coverage = coverage,
                   .seam = seam};
    if (!room || root_inverse(report->after, seam->texture, seam->patch, m.back)) {
        free(room);
        return cmd_fail(CMD_INTERNAL, "report: patch %u cannot be measured", (unsigned)seam->patch);
    }
    for (uint32_t y = 0; y < coverage->height; y += edge)
        for (uint32_t x = 0; x < coverage->width; x += edge)
            measure_square(&m, x, y, edge);
    seam->opaque /= (double)texels;
    seam->partly /= (double)texels;
    seam->places = m.sums[1].count;
    seam->before = steps_of(&m.sums[0]);
    seam->after = steps_of(&m.sums[1]);
    free(room);
    return CMD_OK;
}

/* The colours are those of the opaque patch: a half covered texel of a coarser level has only those of what it
 * covers. */
static int measure_seam(const heap_report *report, heap_seam *seam) {
    side before = {0}, plain = {0}, after = {0};
    heap_flat coverage = {0};
    uint32_t images[2];
    int status = side_load(report->before, seam, &before);
    if (status == CMD_OK)
        status = side_load(report->plain, seam, &plain);
    if (status == CMD_OK)
        status = side_find(report->after, seam, &after, images);
    if (status == CMD_OK)
        status = heap_flat_coverage(report->after, seam->texture, seam->patch, after.level, &coverage);
    if (status == CMD_OK)
        status = measure(report, seam, &before, &plain, &coverage);
    free(coverage.texels);
    side_release(&before);
    side_release(&plain);
    return status;
}

int heap_measure_seams(heap_report *report) {
    int status = CMD_OK;
    for (size_t i = 0; status == CMD_OK && i < report->seam_count; i++)
        status = cmd_interrupted() ? cmd_cancelled() : measure_seam(report, &report->seams[i]);
    return status;
}
