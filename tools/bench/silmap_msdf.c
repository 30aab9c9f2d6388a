/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A distance field of three channels (Chlumsky, 2015): the pieces between two corners of an outline have two of three
 * colours each, so that at a corner one colour changes hands; each channel holds the signed distance to the nearest
 * piece of its colour, beyond the ends of a piece the distance to the line through it; and the median of the three is
 * the shape, with its corners. Texels between which the median errs, as interpolated, are made one distance again.
 */
#include <math.h>
#include <stdlib.h>

#include "silmap_bench.h"

enum { RED = 1, GREEN = 2, BLUE = 4, WHITE = 7 };

static const double reach_factor = 4; /* pieces further away than that many ranges do not count */
static const double tie = 1e-9;

typedef struct near_piece {
    double distance;  /* to the piece itself */
    double steepness; /* where two pieces are equally near, at the point that they share, the steeper one counts */
    double signed_distance;
} near_piece;

typedef struct field {
    const shape *s;
    uint8_t *colours;
    near_piece *nearest; /* three a texel */
} field;

/* ---- colours -------------------------------------------------------------------------------------------- */

/* A contour with one corner: three parts, so that the corner has two colours and they pass into each other. */
static void colour_drop(uint8_t *colours, size_t first, size_t count, size_t corner) {
    static const uint8_t parts[3] = {RED | BLUE, WHITE, RED | GREEN};
    for (size_t i = 0; i < count; i++)
        colours[first + (corner + i) % count] = parts[i * 3 / count];
}

static void colour_contour(const piece *pieces, uint8_t *colours, size_t first, size_t count) {
    static const uint8_t cycle[3] = {GREEN | BLUE, RED | BLUE, RED | GREEN};
    size_t corners = 0, start = 0;
    for (size_t i = count; i-- > 0;) {
        corners += pieces[first + i].corner != 0;
        start = pieces[first + i].corner ? i : start;
    }
    if (corners == 1 && count >= 3) {
        colour_drop(colours, first, count, start);
        return;
    }
    size_t part = 0;
    for (size_t i = 0; i < count; i++) {
        size_t at = first + (start + i) % count;
        part += i > 0 && pieces[at].corner;
        /* The last part must differ from the one before it and from the first. */
        size_t colour = part + 1 == corners && part % 3 == 0 ? 1 : part % 3;
        colours[at] = corners < 2 ? WHITE : cycle[colour];
    }
}

static void colour_pieces(const shape *s, uint8_t *colours) {
    for (size_t first = 0, end; first < s->count; first = end) {
        end = first;
        while (end < s->count && s->pieces[end].contour == s->pieces[first].contour)
            end++;
        colour_contour(s->pieces, colours, first, end - first);
    }
}

/* ---- distances ------------------------------------------------------------------------------------------ */

static near_piece look(const piece *p, double x, double y) {
    double dx = p->x1 - p->x0, dy = p->y1 - p->y0, length = hypot(dx, dy);
    double along = ((x - p->x0) * dx + (y - p->y0) * dy) / length;
    double across = ((y - p->y0) * dx - (x - p->x0) * dy) / length; /* negative inside */
    double beyond = along < 0 ? -along : along > length ? along - length : 0;
    near_piece near = {hypot(across, beyond), 0, -across};
    near.steepness = near.distance > 0 ? beyond / near.distance : 0;
    return near;
}

static void take_nearer(void *context, size_t i, size_t texel, double x, double y) {
    const field *f = context;
    near_piece near = look(&f->s->pieces[i], x, y);
    for (int channel = 0; channel < 3; channel++) {
        near_piece *best = &f->nearest[3 * texel + (size_t)channel];
        if (!(f->colours[i] >> channel & 1) || near.distance > best->distance + tie)
            continue;
        if (near.distance < best->distance - tie || near.steepness < best->steepness)
            *best = near;
    }
}

static int median(int a, int b, int c) {
    return a > b ? (b > c ? b : a > c ? c : a) : (a > c ? a : b > c ? c : b);
}

static int median_of(const uint8_t *t) {
    return median(t[0], t[1], t[2]);
}

/* ---- where interpolation errs --------------------------------------------------------------------------- */

static int median_between(const uint8_t *a, const uint8_t *b, int share) {
    int v[3];
    for (int i = 0; i < 3; i++)
        v[i] = a[i] * (8 - share) + b[i] * share;
    return median(v[0], v[1], v[2]);
}

/* Both texels and what is between them are on one side, but the median goes over to the other on the way. */
static int errs_between(const shape *s, size_t grid, const uint8_t *a, const uint8_t *b, const double from[2],
                        const double step[2]) {
    int inside = median_of(a) > 127;
    if (inside != (median_of(b) > 127))
        return 0;
    for (int share = 1; share < 8; share++) {
        if ((median_between(a, b, share) > 127 * 8 + 4) == inside)
            continue;
        double x = from[0] + step[0] * share / 8, y = from[1] + step[1] * share / 8;
        if (shape_inside(s, x / (double)grid, y / (double)grid) == inside)
            return 1;
    }
    return 0;
}

static void make_one(uint8_t *t) {
    t[0] = t[1] = t[2] = (uint8_t)median_of(t);
}

static int distance_from_half(const uint8_t *t) {
    return abs(2 * median_of(t) - 255);
}

static void correct(const shape *s, size_t grid, uint8_t *texels) {
    static const int steps[4][2] = {{1, 0}, {0, 1}, {1, 1}, {-1, 1}};
    for (size_t i = 0; i < grid * grid; i++) {
        size_t x = i % grid, y = i / grid;
        for (int k = 0; k < 4; k++) {
            if ((steps[k][0] > 0 && x + 1 == grid) || (steps[k][0] < 0 && x == 0) || (steps[k][1] && y + 1 == grid))
                continue;
            size_t j = (size_t)((ptrdiff_t)i + steps[k][0] + steps[k][1] * (ptrdiff_t)grid);
            uint8_t *a = texels + 3 * i, *b = texels + 3 * j;
            double from[2] = {(double)x + 0.5, (double)y + 0.5}, step[2] = {steps[k][0], steps[k][1]};
            if (errs_between(s, grid, a, b, from, step))
                make_one(distance_from_half(a) > distance_from_half(b) ? a : b);
        }
    }
}

/* A texel that shows the wrong side is mirrored. */
static void correct_side(int inside, uint8_t *t) {
    if ((median_of(t) > 127) == inside)
        return;
    for (int channel = 0; channel < 3; channel++)
        t[channel] = (uint8_t)(255 - t[channel]);
}

void msdf_make(const shape *s, size_t grid, uint8_t *out) {
    double n = (double)grid, range = MSDF_RANGE / n, far = 1e9;
    field f = {s, bench_alloc(s->count, 1), bench_alloc(3 * grid * grid, sizeof(near_piece))};
    uint8_t *inside = bench_alloc(grid, 1);
    colour_pieces(s, f.colours);
    for (size_t i = 0; i < 3 * grid * grid; i++)
        f.nearest[i].distance = far;
    shape_visit(s, grid, reach_factor * range, take_nearer, &f);
    for (size_t y = 0; y < grid; y++) {
        shape_row(s, ((double)y + 0.5) / n, 0.5 / n, 1 / n, grid, inside);
        for (size_t i = 3 * y * grid; i < 3 * (y + 1) * grid; i++) {
            double side = inside[i / 3 % grid] ? range : -range;
            out[i] = sdf_code(f.nearest[i].distance < far ? f.nearest[i].signed_distance : side, range);
        }
        for (size_t x = 0; x < grid; x++)
            correct_side(inside[x], out + 3 * (y * grid + x));
    }
    correct(s, grid, out);
    free(f.colours);
    free(f.nearest);
    free(inside);
}
