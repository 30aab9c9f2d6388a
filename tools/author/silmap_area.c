/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The exact area of what a cell shows wrongly.
 *
 * Let e_k(x, y) be how wrong it is to show corner k's region at a place, and E_k its integral over y from the top of the cell. By Green's
 * theorem the integral of e_k over the polygon of quadrant k is that of E_k dx around it. Each arm borders on two quadrants, so what a cell
 * costs is a sum over its arms of integrals of E_k - E_m along them, plus what the cell would cost if all of it showed the
 * region of corner 11. A line is the arm of one cell and the opposite arm of the next; it counts only where the regions on its two sides
 * differ. So the cost of the whole silmap is a sum over lines, each of which depends on two points and nothing else.
 *
 * Squares are of one region each: within a column of them E is linear in y between the borders of squares, and its integral
 * along a segment is found without error from E and from the integral G of E over y.
 */
#include "silmap_fit.h"

#include <math.h>

/* A table: for each column the pairs (E, G) at the edge + 1 borders, then the sums of E at the bottom over the columns. In squares. */
size_t silmap_table_size(uint32_t edge) {
    return (size_t)edge * (edge + 1) * 2 + edge + 1;
}

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

static void fill_table(const silmap_labels *labels, size_t c, uint32_t plus, uint32_t minus, double *table) {
    uint32_t edge = labels->edge;
    const silmap_block *block = labels->blocks[c];
    double differences[SILMAP_LOCAL];
    uint32_t count = block ? block->count : 1;
    for (uint32_t r = 0; r < count; r++) {
        uint32_t region = block ? block->regions[r] : labels->uniform[c];
        differences[r] = silmap_weight(labels, plus, region) - silmap_weight(labels, minus, region);
    }
    double *bottom = table + (size_t)edge * (edge + 1) * 2;
    bottom[0] = 0;
    for (uint32_t x = 0; x < edge; x++) {
        const uint8_t *column = block ? block->squares + (size_t)x * edge : NULL;
        double e = 0, g = 0;
        for (uint32_t y = 0; y < edge; y++, table += 2) {
            double d = differences[column ? column[y] : 0];
            table[0] = e;
            table[1] = g;
            g += e + d / 2;
            e += d;
        }
        table[0] = e;
        table[1] = g;
        table += 2;
        bottom[x + 1] = bottom[x] + e;
    }
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
    if (first != SIZE_MAX) {
        fill_table(labels, first, plus, minus, memory);
        out->first = memory;
    }
    if (second != SIZE_MAX) {
        memory += silmap_table_size(labels->edge);
        fill_table(labels, second, plus, minus, memory);
        out->second = memory;
    }
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

static double along(const double *table, uint32_t edge, double x0, double y0, double x1, double y1) {
    if (x1 < x0)
        return -along(table, edge, x1, y1, x0, y0);
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

/* The integral of E at the bottom from 0 to x. */
static double along_bottom(const double *table, uint32_t edge, double x) {
    const double *bottom = table + (size_t)edge * (edge + 1) * 2;
    uint32_t c = x >= edge ? edge - 1 : (uint32_t)x;
    return bottom[c] + (bottom[c + 1] - bottom[c]) * (x - c);
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
        if (line->first)
            sum += along(line->first, edge, x, e, ax, ay) + along_bottom(line->first, edge, x);
        if (line->second)
            sum += along(line->second, edge, bx, by, x, 0);
    } else {
        double y = ay + (by - ay) * (e - ax) / (bx + e - ax);
        if (line->first)
            sum += along(line->first, edge, ax, ay, e, y);
        if (line->second)
            sum += along(line->second, edge, 0, y, bx, by);
    }
    return sum / (e * e);
}

double silmap_base_cost(const silmap_labels *labels, size_t c) {
    uint32_t shown = labels->sample[silmap_corner(labels->grid, c, ZT_SILMAP_11)];
    const silmap_block *block = labels->blocks[c];
    if (!block)
        return silmap_weight(labels, shown, labels->uniform[c]);
    double weights[SILMAP_LOCAL], sum = 0;
    for (uint32_t r = 0; r < block->count; r++)
        weights[r] = silmap_weight(labels, shown, block->regions[r]);
    size_t squares = (size_t)labels->edge * labels->edge;
    for (size_t i = 0; i < squares; i++)
        sum += weights[block->squares[i]];
    return sum / (double)squares;
}
