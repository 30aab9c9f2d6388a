/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A patch takes the colours of what lies beneath it.
 *
 * Patch and ground are compared on a grid of cells as large as the ground's texels (adjust_grid.c), both low-passed in
 * the same way: what is left between them is a difference of light, not of detail. A gain that varies smoothly over the
 * patch (vignetting, shading), and an offset, are fitted to it by robust least squares. The Poisson equation with the
 * patch's gradient as guidance has as its solution the patch plus the harmonic function e that is, on the edge, ground
 * minus patch. There e is the low-passed difference, never that of single texels: detail on the edge that the ground
 * lacks would otherwise be smeared into the patch. Gains are of light, but e is a difference of about what the eye
 * sees, roots of light: what is nothing on a bright edge would be a strong cast where the patch is dark.
 *
 * Where the patch is clipped, its own light is lost and neither gain nor gradient knows it. There the difference goes
 * to the clipped texels themselves, so that they are, on the whole, as light as the ground. Where the ground is
 * clipped, a lighter patch agrees with it: the difference is what the ground's camera cut off, and would be a cast
 * beside it.
 */
#include "adjust_grid.h"
#include "zipmap_private.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define TERMS 8 /* 1 x y x^2 xy y^2 r^4, times the patch; and 1 */
#define ROUNDS 6
#define FITTED 40000 /* cells that are enough for so few unknowns */
#define DARK 0.02f   /* linear; below it a step is seen less and less well */
#define MOST_ERROR 0.25f
#define INSET 2        /* cells; what the ground shows nearer to the edge is blurred with what lies outside */
#define DEPTHS 3       /* rings of cells that are looked at from there on */
#define SMOOTHINGS 8   /* of what was found along the edge, twice */
#define ACCURATE 0.01f /* share of the light by which two pictures of plain colour differ */
#define ROOT_ACCURATE 0.004f
#define MISPLACED 0.25f /* cells by which edges seem to lie elsewhere, for they are not equally sharp */
#define NO_OFFSET 0.05  /* how much is to be said against an offset, which is only seen where it is dark */
#define CLIPPED 0.05f   /* of a cell: from here on it says nothing about the rest */
#define CUT 0.1f        /* of a cell of the ground: from here on a lighter patch is as light as it should be */
#define MOST_LOST 2.0f  /* of light that clipping may have taken */
#define MOST_GAINED 0.5f

#define BLACK 0.002f /* light that is added before a root is taken: as steep at black as sRGB */

static float root_of(float light) {
    return sqrtf(fmaxf(light, 0.0f) + BLACK);
}

/* Light to whose root something is added: not below black. */
static float shifted(float light, float by) {
    float root = root_of(light) + by;
    return root > 0.0f ? fmaxf(root * root - BLACK, 0.0f) : 0.0f;
}

typedef struct fit {
    double terms[TERMS]; /* the last one is the offset */
} fit;

/* ---- the smooth gain ------------------------------------------------------------------------------------- */

/* x and y from -1 to 1 along the longer side. */
static void basis(double x, double y, double out[TERMS - 1]) {
    double r = x * x + y * y;
    double terms[TERMS - 1] = {1.0, x, y, x * x, x * y, y * y, r * r};
    memcpy(out, terms, sizeof terms);
}

static double gain_at(const fit *f, double x, double y) {
    double terms[TERMS - 1], gain = 0.0;
    basis(x, y, terms);
    for (int i = 0; i < TERMS - 1; i++)
        gain += f->terms[i] * terms[i];
    return gain;
}

typedef struct frame {
    double scale_x, scale_y; /* of coordinates 0 to 1 */
} frame;

static frame frame_of(uint32_t width, uint32_t height) {
    double longer = width > height ? width : height;
    return (frame){width / longer, height / longer};
}

/* Where the middle of a cell is. */
static void cell_place(const author_grid *g, size_t cell, double at[2]) {
    frame shape = frame_of(g->width, g->height);
    at[0] = (2.0 * ((double)(cell % g->width) + 0.5) / g->width - 1.0) * shape.scale_x;
    at[1] = (2.0 * ((double)(cell / g->width) + 0.5) / g->height - 1.0) * shape.scale_y;
}

/* The mean of a cell after the gain. */
static float cell_value(const author_grid *g, const fit *f, uint32_t channel, size_t cell) {
    double at[2];
    cell_place(g, cell, at);
    return (float)(gain_at(f, at[0], at[1]) * (double)g->patch[channel][cell] + f->terms[TERMS - 1]);
}

typedef struct samples {
    size_t count;
    double (*at)[2];
    float *patch, *ground, *accuracy, *weight, *rest, *sorted;
} samples;

/* Without evidence the gain is even, and the offset nothing. */
static void regularise(double a[TERMS][TERMS], int free_terms) {
    double size = a[0][0] > 0.0 ? a[0][0] : 1.0;
    for (int i = 0; i < TERMS; i++)
        a[i][i] += i == 0 ? 1e-9 * size : i + 1 == TERMS ? NO_OFFSET * a[i][i] : 1e-4 * size;
    for (int i = free_terms; i + 1 < TERMS; i++)
        a[i][i] += 1e12 * size;
}

static int fit_once(const samples *s, int free_terms, fit *out) {
    double a[TERMS][TERMS] = {{0}}, b[TERMS] = {0};
    for (size_t i = 0; i < s->count; i++) {
        double row[TERMS];
        basis(s->at[i][0], s->at[i][1], row);
        for (int k = 0; k < TERMS - 1; k++)
            row[k] *= (double)s->patch[i];
        row[TERMS - 1] = 1.0;
        for (int k = 0; k < TERMS; k++) {
            for (int j = 0; j <= k; j++)
                a[k][j] += (double)s->weight[i] * row[k] * row[j];
            b[k] += (double)s->weight[i] * row[k] * (double)s->ground[i];
        }
    }
    regularise(a, free_terms);
    memcpy(out->terms, b, sizeof b);
    return plane_solve(&a[0][0], out->terms, TERMS) ? 0 : -1;
}

static int by_value(const void *a, const void *b) {
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Standard deviation of what a cell of ground says: where the picture changes, patch and ground are never quite equally
 * sharp. Such cells would make a fit of the darker by the lighter ones too flat, and too light where it is dark. */
static float accuracy_of(float ground, float change) {
    float plain = ACCURATE * (fmaxf(ground, 0.0f) + DARK), busy = MISPLACED * change;
    return sqrtf(plain * plain + busy * busy);
}

/* Huber's weights. */
static void reweigh(samples *s, const fit *f) {
    for (size_t i = 0; i < s->count; i++) {
        float value = (float)gain_at(f, s->at[i][0], s->at[i][1]) * s->patch[i] + (float)f->terms[TERMS - 1];
        s->rest[i] = fabsf(value - s->ground[i]) / s->accuracy[i];
        s->sorted[i] = s->rest[i];
    }
    qsort(s->sorted, s->count, sizeof *s->sorted, by_value);
    float bend = 1.345f * 1.4826f * s->sorted[s->count / 2] + 1e-6f;
    for (size_t i = 0; i < s->count; i++) {
        float seen = 1.0f / s->accuracy[i];
        s->weight[i] = seen * seen * (s->rest[i] > bend ? bend / s->rest[i] : 1.0f);
    }
}

/* Clipped values say nothing about the gain. */
static int usable(float patch, float ground, float clipped) {
    return patch > 0.001f && ground > 0.0f && clipped < 0.02f && ground < 0.95f;
}

static void collect(samples *s, const author_grid *g, uint32_t channel) {
    size_t cells = (size_t)g->width * g->height, step = cells / FITTED + 1;
    s->count = 0;
    for (size_t i = 0; i < cells; i += step) {
        float patch = g->patch[channel][i], ground = g->ground[channel][i];
        if (!g->valid[i] || !usable(patch, ground, g->clipped[channel][i]))
            continue;
        size_t k = s->count++;
        cell_place(g, i, s->at[k]);
        s->patch[k] = patch;
        s->ground[k] = ground;
        s->accuracy[k] = accuracy_of(ground, g->change[channel][i]);
        s->weight[k] = 1.0f / (s->accuracy[k] * s->accuracy[k]);
    }
}

/* A gain that is nowhere reasonable would be worse than none. */
static int is_sound(const fit *f, const author_grid *g) {
    frame shape = frame_of(g->width, g->height);
    for (int i = 0; i < 81; i++) {
        double gain = gain_at(f, (i % 9 / 4.0 - 1.0) * shape.scale_x, (i / 9 / 4.0 - 1.0) * shape.scale_y);
        if (!(gain > 0.02 && gain < 50.0))
            return 0;
    }
    return 1;
}

static void fit_channel(samples *s, const author_grid *g, uint32_t channel, int smooth, fit *out) {
    collect(s, g, channel);
    for (int terms = smooth ? TERMS - 1 : 1; terms >= 1; terms -= TERMS - 2) {
        int good = s->count >= 64;
        for (int round = 0; good && round < ROUNDS; round++) {
            good = fit_once(s, terms, out) == 0;
            if (good)
                reweigh(s, out);
        }
        if (good && is_sound(out, g))
            return;
        collect(s, g, channel);
    }
    *out = (fit){.terms = {1.0}};
}

static author_result fit_gains(author_run *run, const author_grid *g, int smooth, fit *fits) {
    size_t room = FITTED + 2;
    samples s = {.at = author_alloc(run, room, sizeof *s.at)};
    float *floats = author_alloc(run, 6 * room, sizeof *floats);
    if (s.at && floats) {
        s.patch = floats;
        s.ground = floats + room;
        s.weight = floats + 2 * room;
        s.rest = floats + 3 * room;
        s.sorted = floats + 4 * room;
        s.accuracy = floats + 5 * room;
        for (uint32_t c = 0; c < g->channels; c++)
            fit_channel(&s, g, c, smooth, &fits[c]);
    }
    int made = s.at && floats;
    free(s.at);
    free(floats);
    return made ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

/* ---- what the gain leaves on the edge ---------------------------------------------------------------------- */

/* The i-th cell of the edge, clockwise. */
static size_t ring_cell(const author_grid *g, size_t i) {
    size_t w = g->width, h = g->height;
    if (i < w - 1)
        return i;
    i -= w - 1;
    if (i < h - 1)
        return i * w + w - 1;
    i -= h - 1;
    return i < w - 1 ? (h - 1) * w + w - 1 - i : (h - 1 - (i - (w - 1))) * w;
}

/* The cell a little further in, where the patch is not transparent any more. */
static size_t inner_cell(const author_grid *g, size_t cell, size_t depth) {
    size_t w = g->width, h = g->height, shorter = w < h ? w : h;
    size_t inset = shorter / 4 < depth ? shorter / 4 : depth;
    size_t x = cell % w, y = cell / w;
    x = x < inset ? inset : x > w - 1 - inset ? w - 1 - inset : x;
    y = y < inset ? inset : y > h - 1 - inset ? h - 1 - inset : y;
    return y * w + x;
}

static size_t ring_length(const author_grid *g) {
    return 2 * ((size_t)g->width - 1) + 2 * ((size_t)g->height - 1);
}

/* Unknown stretches of the ring go straight from one known end to the other. 0 when nothing is known. */
static int close_gaps(float *ring, const uint8_t *known, size_t length) {
    size_t first = 0;
    while (first < length && !known[first])
        first++;
    if (first == length)
        return 0;
    size_t from = first;
    for (size_t i = 1; i <= length; i++) {
        size_t at = (first + i) % length;
        if (!known[at])
            continue;
        size_t gap = first + i - from;
        for (size_t k = 1; k < gap; k++) {
            float t = (float)k / (float)gap;
            ring[(from + k) % length] = ring[from % length] + t * (ring[at] - ring[from % length]);
        }
        from = first + i;
    }
    return 1;
}

/* Binomial of five along the closed ring. */
static void smooth_ring(const float *ring, float *out, size_t length) {
    static const float weights[5] = {1.0f / 16, 4.0f / 16, 6.0f / 16, 4.0f / 16, 1.0f / 16};
    for (size_t i = 0; i < length; i++) {
        out[i] = 0.0f;
        for (size_t k = 0; k < 5; k++)
            out[i] += weights[k] * ring[(i + length - 2 + k) % length];
    }
}

enum { PATCH, GROUND, WEIGHT, SUMS };

/* Light of the patch, without what the ground's camera would have cut off. */
static float comparable(float value, float ground, float cut) {
    return value - fminf(cut / CUT, 1.0f) * fmaxf(value - ground, 0.0f);
}

/* Light of the cells behind the i-th of the ring, of patch and ground, times their weights: cells of plain colour know
 * best. */
static void look_behind(const author_grid *g, uint32_t channel, const fit *f, size_t i, float *const sums[SUMS]) {
    for (size_t depth = INSET; depth < INSET + DEPTHS; depth++) {
        size_t cell = inner_cell(g, ring_cell(g, i), depth);
        if (!g->valid[cell] || g->clipped[channel][cell] >= CLIPPED)
            continue;
        float ground = g->ground[channel][cell];
        float busy = MISPLACED * g->change[channel][cell] / (2.0f * root_of(ground));
        float w = ROOT_ACCURATE * ROOT_ACCURATE / (ROOT_ACCURATE * ROOT_ACCURATE + busy * busy);
        sums[PATCH][i] += w * comparable(fmaxf(cell_value(g, f, channel, cell), 0.0f), ground, g->cut[channel][cell]);
        sums[GROUND][i] += w * fmaxf(ground, 0.0f);
        sums[WEIGHT][i] += w;
    }
}

/* Light is averaged before roots are taken: those of an edge that is less sharp are larger on the average. */
static author_result fill_ring(author_run *run, const author_grid *g, uint32_t channel, const fit *f, float *out) {
    size_t length = ring_length(g);
    float *room = author_alloc(run, (SUMS + 1) * length, sizeof *room), *scratch = room + SUMS * length;
    float *const sums[SUMS] = {room, room + length, room + 2 * length};
    uint8_t *known = author_alloc(run, length, 1);
    if (!room || !known) {
        free(room);
        free(known);
        return AUTHOR_NO_MEMORY;
    }
    for (size_t i = 0; i < length; i++)
        look_behind(g, channel, f, i, sums);
    for (int i = 0; i < SUMS * SMOOTHINGS; i++) {
        smooth_ring(sums[i % SUMS], scratch, length);
        smooth_ring(scratch, sums[i % SUMS], length);
    }
    for (size_t i = 0; i < length; i++) {
        float weight = sums[WEIGHT][i];
        known[i] = weight > 0.0f;
        float error = known[i] ? root_of(sums[GROUND][i] / weight) - root_of(sums[PATCH][i] / weight) : 0.0f;
        scratch[i] = fminf(fmaxf(error, -MOST_ERROR), MOST_ERROR);
    }
    if (close_gaps(scratch, known, length))
        for (size_t i = 0; i < length; i++)
            out[ring_cell(g, i)] = scratch[i];
    free(room);
    free(known);
    return AUTHOR_OK;
}

static author_result solve_rest(author_run *run, const author_grid *g, const fit *fits, author_planes *rest) {
    author_result result = AUTHOR_OK;
    for (uint32_t c = 0; c < g->channels && result == AUTHOR_OK; c++)
        result = fill_ring(run, g, c, &fits[c], rest->planes[c]);
    return result == AUTHOR_OK ? author_harmonic(run, rest->planes, g->channels, g->width, g->height) : result;
}

/* Share of a cell whose light clipping changes: of what the patch's camera cut off when light is missing, else of what
 * is so light that the ground's camera may have cut it off. */
static float lost_share(const author_grid *g, uint32_t c, size_t cell, float value, float missing) {
    return !g->bounded ? 0.0f : missing > 0.0f ? g->clipped[c][cell] : adjust_clipping(value);
}

/* What clipping took of the patch, or, below 0, of the ground, for the clipped texels of each cell to share. */
static void find_lost(const author_grid *g, const fit *fits, const author_planes *rest, author_planes *lost) {
    size_t cells = (size_t)g->width * g->height;
    for (uint32_t c = 0; c < g->channels; c++)
        for (size_t i = 0; i < cells; i++) {
            float value = shifted(cell_value(g, &fits[c], c, i), rest->planes[c][i]);
            float missing = g->ground[c][i] - value, share = lost_share(g, c, i, value, missing);
            if (g->valid[i] && share > 0.0f)
                lost->planes[c][i] = fminf(fmaxf(missing / fmaxf(share, CLIPPED), -MOST_GAINED), MOST_LOST);
        }
}

/* ---- the patch --------------------------------------------------------------------------------------------- */

typedef struct apply {
    author_picture *patch;
    const author_grid *grid;
    const fit *fits;
    const author_planes *rest, *lost; /* NULL: none */
    float *before;                    /* a row of one channel as it was, for each worker */
} apply;

/* Between the centres of cells, straight: e hardly bends, and its values on the edge stay as they are. */
typedef struct between {
    uint32_t first, second;
    float share;
} between;

static between find_between(uint32_t texel, uint32_t texels, uint32_t cells) {
    double at = (texel + 0.5) * cells / texels - 0.5;
    if (at <= 0.0)
        return (between){0, 0, 0.0f};
    uint32_t first = (uint32_t)at;
    if (first + 1 >= cells)
        return (between){cells - 1, cells - 1, 0.0f};
    return (between){first, first + 1, (float)(at - first)};
}

/* A row of a plane of cells, between two rows of cells. */
static void blend_rows(const author_grid *g, const float *cells, const between *down, float *out) {
    const float *upper = cells + (size_t)down->first * g->width, *lower = cells + (size_t)down->second * g->width;
    for (uint32_t i = 0; i < g->width; i++)
        out[i] = upper[i] + down->share * (lower[i] - upper[i]);
}

static void add_rest(const apply *a, uint32_t y, uint32_t c, const float *before, float *row) {
    uint32_t w = a->patch->width, channels = a->patch->channels, cells = a->grid->width;
    between down = find_between(y, a->patch->height, a->grid->height);
    float rest[ADJUST_MOST_CELLS], lost[ADJUST_MOST_CELLS];
    blend_rows(a->grid, a->rest->planes[c], &down, rest);
    blend_rows(a->grid, a->lost->planes[c], &down, lost);
    for (uint32_t x = 0; x < w; x++) {
        between at = find_between(x, w, cells);
        float own = rest[at.first] + at.share * (rest[at.second] - rest[at.first]);
        row[(size_t)x * channels] = shifted(row[(size_t)x * channels], own);
        float light = lost[at.first] + at.share * (lost[at.second] - lost[at.first]);
        if (a->grid->bounded)
            row[(size_t)x * channels] += light * adjust_clipping(light > 0.0f ? before[x] : row[(size_t)x * channels]);
    }
}

/* The gain along a row is a polynomial of fourth degree in u. */
static void scale_row(const apply *a, uint32_t y, uint32_t c, const float *before, float *row) {
    uint32_t w = a->patch->width, channels = a->patch->channels;
    frame shape = frame_of(w, a->patch->height);
    double v = (2.0 * (y + 0.5) / a->patch->height - 1.0) * shape.scale_y;
    const double *t = a->fits[c].terms;
    double g0 = t[0] + t[2] * v + t[5] * v * v + t[6] * v * v * v * v, g1 = t[1] + t[4] * v;
    double g2 = t[3] + 2.0 * t[6] * v * v, g4 = t[6];
    for (uint32_t x = 0; x < w; x++) {
        double u = (2.0 * (x + 0.5) / w - 1.0) * shape.scale_x, uu = u * u;
        row[(size_t)x * channels] = before[x] * (float)(g0 + g1 * u + g2 * uu + g4 * uu * uu) + (float)t[TERMS - 1];
    }
}

static author_result apply_row(void *context, size_t y, unsigned worker, char *error) {
    const apply *a = context;
    (void)error;
    uint32_t w = a->patch->width, channels = a->patch->channels;
    float *before = a->before + (size_t)worker * w;
    for (uint32_t c = 0; c < a->grid->channels; c++) {
        float *row = a->patch->texels + y * w * channels + c;
        for (uint32_t x = 0; x < w; x++)
            before[x] = row[(size_t)x * channels];
        scale_row(a, (uint32_t)y, c, before, row);
        if (a->rest)
            add_rest(a, (uint32_t)y, c, before, row);
        for (uint32_t x = 0; x < w; x++)
            row[(size_t)x * channels] = fmaxf(row[(size_t)x * channels], 0.0f);
    }
    return AUTHOR_OK;
}

static author_result apply_to_patch(author_run *run, apply *a) {
    a->before = author_alloc(run, author_workers(run), (size_t)a->patch->width * sizeof *a->before);
    if (!a->before)
        return AUTHOR_NO_MEMORY;
    author_result result = author_for(run, "colours", a->patch->height, apply_row, a);
    free(a->before);
    return result;
}

/* The cells as they have become: cheaper than looking at all texels again, and the same up to rounding. */
static void apply_to_grid(author_grid *g, const fit *fits, const author_planes *rest, const author_planes *lost) {
    size_t cells = (size_t)g->width * g->height;
    for (uint32_t c = 0; c < g->channels; c++)
        for (size_t i = 0; i < cells; i++) {
            float value = cell_value(g, &fits[c], c, i);
            if (rest) {
                float light = lost->planes[c][i];
                value = shifted(value, rest->planes[c][i]);
                value += lost_share(g, c, i, value, light) * light;
            }
            g->patch[c][i] = fmaxf(value, 0.0f);
        }
}

/* ---- the report ---------------------------------------------------------------------------------------------- */

static float coded(float value) {
    return zt_transfer_encode(ZT_TRANSFER_SRGB, fminf(fmaxf(value, 0.0f), 1.0f));
}

static author_result measure(author_run *run, const author_grid *g, author_seam *seam) {
    size_t length = ring_length(g), count = 0, cells = (size_t)g->width * g->height, valid = 0;
    float *steps = author_alloc(run, length * g->channels, sizeof *steps);
    double sums[3] = {0};
    if (!steps)
        return AUTHOR_NO_MEMORY;
    for (uint32_t c = 0; c < g->channels; c++)
        for (size_t i = 0; i < length; i++) {
            size_t cell = ring_cell(g, i);
            if (g->valid[cell])
                steps[count++] = fabsf(coded(g->patch[c][cell]) - coded(g->ground[c][cell]));
        }
    qsort(steps, count, sizeof *steps, by_value);
    *seam = (author_seam){0};
    if (count) {
        seam->median = (double)steps[count / 2];
        seam->worst = (double)steps[count - 1];
    }
    free(steps);
    for (size_t i = 0; i < cells; i++) {
        valid += g->valid[i];
        for (uint32_t c = 0; c < g->channels && g->valid[i]; c++)
            sums[c] += (double)coded(g->patch[c][i]) - (double)coded(g->ground[c][i]);
    }
    for (uint32_t c = 0; c < g->channels && valid; c++)
        seam->mean = fmax(seam->mean, fabs(sums[c] / (double)valid));
    return AUTHOR_OK;
}

static author_result find_rest(author_run *run, const author_grid *g, const fit *fits, author_planes *rest,
                               author_planes *lost) {
    author_result result = adjust_planes_create(run, g, rest);
    if (result == AUTHOR_OK)
        result = adjust_planes_create(run, g, lost);
    if (result == AUTHOR_OK)
        result = solve_rest(run, g, fits, rest);
    if (result == AUTHOR_OK)
        find_lost(g, fits, rest, lost);
    return result;
}

static author_result adjust(author_run *run, author_picture *patch, author_grid *g, author_colour colour,
                            author_adjustment *report) {
    int poisson = colour == AUTHOR_COLOUR_POISSON;
    fit fits[3];
    author_planes rest = {{0}}, lost = {{0}};
    apply work = {.patch = patch, .grid = g, .fits = fits, .rest = poisson ? &rest : NULL, .lost = &lost};
    author_result result = measure(run, g, &report->before);
    if (result == AUTHOR_OK)
        result = fit_gains(run, g, poisson, fits);
    if (result == AUTHOR_OK && poisson)
        result = find_rest(run, g, fits, &rest, &lost);
    if (result == AUTHOR_OK)
        result = apply_to_patch(run, &work);
    if (result == AUTHOR_OK) {
        apply_to_grid(g, fits, poisson ? &rest : NULL, &lost);
        result = measure(run, g, &report->after);
    }
    for (uint32_t c = 0; c < g->channels && result == AUTHOR_OK; c++) {
        report->gain[c] = fits[c].terms[0];
        report->offset[c] = fits[c].terms[TERMS - 1];
    }
    adjust_planes_release(&rest);
    adjust_planes_release(&lost);
    return result;
}

author_result author_adjust_colour(author_run *run, author_picture *patch, const author_ground *grounds, size_t count,
                                   author_colour colour, author_adjustment *adjustment) {
    author_adjustment report = {0};
    author_grid grid;
    author_result result = adjust_grid_create(run, patch, grounds, count, &grid);
    if (result == AUTHOR_OK) {
        report.covered = grid.covered;
        if (grid.covered > 0.0)
            result = adjust(run, patch, &grid, colour, &report);
    }
    adjust_grid_release(&grid);
    if (adjustment)
        *adjustment = report;
    return result;
}
