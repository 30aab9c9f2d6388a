/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The exact area of what a cell shows wrongly.
 *
 * Let e_k(x, y) be how wrong it is to show corner k's region at a place, and E_k its integral over y from the top of
 * the cell. By Green's theorem the integral of e_k over the polygon of quadrant k is that of E_k dx around it. Each arm
 * borders on two quadrants, so what a cell costs is a sum over its arms of integrals of E_k - E_m along them, plus what
 * the cell would cost if all of it showed the region of corner 11. A line is the arm of one cell and the opposite arm
 * of the next; it counts only where the regions on its two sides differ. So the cost of the whole silmap is a sum over
 * lines, each of which depends on two points and nothing else.
 *
 * Squares are of one region each: within a column of them E is linear in y between the borders of squares, and its
 * integral along a segment is found without error from E and from the integral G of E over y.
 */
#include "silmap_fit.h"

#include <math.h>

double silmap_weight(const silmap_labels *labels, uint32_t shown, uint32_t wanted) {
    if (shown == wanted)
        return 0;
    const silmap_region *a = &labels->truth->regions[shown], *b = &labels->truth->regions[wanted];
    double sum = 0.01; /* regions of equal colour are apart too */
    for (uint32_t ch = 0; ch < labels->truth->picture->channels; ch++) {
        double d = (double)a->coded[ch] - (double)b->coded[ch];
        sum += d * d;
    }
    return sum;
}

static silmap_half half_of(const silmap_labels *labels, size_t c, uint32_t plus, uint32_t minus, double *memory) {
    const silmap_block *block = labels->blocks[c];
    const uint32_t *regions = block ? block->regions : &labels->uniform[c];
    double differences[SILMAP_LOCAL];
    uint32_t count = block ? block->count : 1;
    for (uint32_t r = 0; r < count; r++)
        differences[r] = silmap_weight(labels, plus, regions[r]) - silmap_weight(labels, minus, regions[r]);
    if (count == 1)
        return (silmap_half){.used = 1, .level = differences[0]};
    if (count == 2)
        return (silmap_half){1, differences[0], differences[1] - differences[0], block->table};
    silmap_table_fill(block->places, labels->edge, labels->finer, differences, memory);
    return (silmap_half){1, 0, 1, memory};
}

/* Which arm of the first cell, and of the second, the line is; the corners of the cell on its two sides. */
static const struct {
    int plus, minus;
} sides[2][2] = {
    /* left to right: E of the first, W of the second */
    {{ZT_SILMAP_10, ZT_SILMAP_11}, {ZT_SILMAP_00, ZT_SILMAP_01}},
    /* downwards: S of the first, N of the second */
    {{ZT_SILMAP_01, ZT_SILMAP_11}, {ZT_SILMAP_00, ZT_SILMAP_10}}};

void silmap_line_set(const silmap_labels *labels, size_t first, size_t second, int vertical, double *memory,
                     silmap_line *out) {
    *out = (silmap_line){.vertical = vertical};
    size_t c = first != SIZE_MAX ? first : second;
    if (c == SIZE_MAX)
        return;
    int part = first != SIZE_MAX ? 0 : 1;
    uint32_t plus = labels->sample[silmap_corner(labels->grid, c, sides[vertical][part].plus)];
    uint32_t minus = labels->sample[silmap_corner(labels->grid, c, sides[vertical][part].minus)];
    if (plus == minus)
        return;
    out->used = 1;
    if (first != SIZE_MAX)
        out->first = half_of(labels, first, plus, minus, memory);
    if (second != SIZE_MAX)
        out->second = half_of(labels, second, plus, minus, memory + silmap_table_size(labels->edge));
}

/* The integral of E over dx along a piece of a segment within one column, from ya to yb. */
static double strip(const double *column, uint32_t edge, double ya, double yb, double dx) {
    uint32_t i = ya <= 0 ? 0 : ya >= edge ? edge - 1 : (uint32_t)ya;
    uint32_t j = yb <= 0 ? 0 : yb >= edge ? edge - 1 : (uint32_t)yb;
    const double *a = column + 2 * (size_t)i, *b = column + 2 * (size_t)j;
    double ta = ya - i, tb = yb - j;
    double da = a[2] - a[0], db = b[2] - b[0];
    if (i == j)
        return dx * (a[0] + da * (ta + tb) / 2);
    double ga = a[1] + ta * (a[0] + ta * da / 2);
    double gb = b[1] + tb * (b[0] + tb * db / 2);
    return dx * (gb - ga) / (yb - ya);
}

static double along_table(const double *table, uint32_t edge, double x0, double y0, double x1, double y1) {
    if (x1 < x0)
        return -along_table(table, edge, x1, y1, x0, y0);
    if (!(x1 - x0 > 1e-12))
        return 0;
    double slope = (y1 - y0) / (x1 - x0), sum = 0;
    double x = x0, y = y0;
    for (uint32_t c = (uint32_t)x0; c < edge && x < x1; c++) {
        double end = c + 1 < x1 ? c + 1 : x1;
        double to = end < x1 ? y0 + slope * (end - x0) : y1;
        sum += strip(table + (size_t)c * (edge + 1) * 2, edge, y, to, end - x);
        x = end;
        y = to;
    }
    return sum;
}

static double along(const silmap_half *half, uint32_t edge, double x0, double y0, double x1, double y1) {
    double sum = half->level * (x1 - x0) * (y0 + y1) / 2;
    return half->table ? sum + half->rise * along_table(half->table, edge, x0, y0, x1, y1) : sum;
}

/* The integral of E at the bottom from 0 to x. */
static double along_bottom(const silmap_half *half, uint32_t edge, double x) {
    double sum = half->level * edge * x;
    if (!half->table)
        return sum;
    const double *bottom = half->table + (size_t)edge * (edge + 1) * 2;
    uint32_t c = x >= edge ? edge - 1 : (uint32_t)x;
    return sum + half->rise * (bottom[c] + (bottom[c + 1] - bottom[c]) * (x - c));
}

double silmap_line_cost(const silmap_line *line, uint32_t edge, unsigned first, unsigned second) {
    if (!line->used)
        return 0;
    double e = edge;
    double ax = silmap_coordinate(first & 7) * e, ay = silmap_coordinate(first >> 3) * e;
    double bx = silmap_coordinate(second & 7) * e, by = silmap_coordinate(second >> 3) * e;
    double sum = 0;
    if (line->vertical) {
        double x = ax + (bx - ax) * (e - ay) / (by + e - ay);
        if (line->first.used)
            sum += along(&line->first, edge, x, e, ax, ay) + along_bottom(&line->first, edge, x);
        if (line->second.used)
            sum += along(&line->second, edge, bx, by, x, 0);
    } else {
        double y = ay + (by - ay) * (e - ax) / (bx + e - ax);
        if (line->first.used)
            sum += along(&line->first, edge, ax, ay, e, y);
        if (line->second.used)
            sum += along(&line->second, edge, 0, y, bx, by);
    }
    return sum / (e * e);
}

double silmap_base_cost(const silmap_labels *labels, size_t c) {
    uint32_t shown = labels->sample[silmap_corner(labels->grid, c, ZT_SILMAP_11)];
    const silmap_block *block = labels->blocks[c];
    if (!block)
        return silmap_weight(labels, shown, labels->uniform[c]);
    double sum = 0;
    for (uint32_t r = 0; r < block->count; r++)
        sum += block->shares[r] * silmap_weight(labels, shown, block->regions[r]);
    return sum;
}
