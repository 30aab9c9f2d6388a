/* SPDX-License-Identifier: Apache-2.0 */
/* The geometry and the filters of one silmap cell (spec/silmap.md sections 3 to 5 and 7). */
#include <stdbool.h>
#include <stddef.h>

#include "zt/zt_write.h"

/* Bits of a quadrant's number, which is also the number of its corner. */
enum { RIGHT = 1, BELOW = 2 };

/* ---- geometry ---------------------------------------------------------------------------------- */

static double point_x(uint8_t cell) {
    return ((cell & ZT_SILMAP_X) + 0.5) / 8;
}

static double point_y(uint8_t cell) {
    return ((cell & ZT_SILMAP_Y) / 8 + 0.5) / 8;
}

static unsigned arms_cut(const zt_silmap_cell *c) {
    return (c->own & ZT_SILMAP_NORTH ? (unsigned)ZT_SILMAP_CUT_NORTH : 0u) |
           (c->own & ZT_SILMAP_WEST ? (unsigned)ZT_SILMAP_CUT_WEST : 0u) |
           (c->east & ZT_SILMAP_WEST ? (unsigned)ZT_SILMAP_CUT_EAST : 0u) |
           (c->south & ZT_SILMAP_NORTH ? (unsigned)ZT_SILMAP_CUT_SOUTH : 0u);
}

void zt_silmap_shape_of(const zt_silmap_cell *cell, zt_silmap_shape *out) {
    out->px = point_x(cell->own);
    out->py = point_y(cell->own);
    out->wx = point_x(cell->west) - 1;
    out->wy = point_y(cell->west);
    out->nx = point_x(cell->north);
    out->ny = point_y(cell->north) - 1;
    out->ex = point_x(cell->east) + 1;
    out->ey = point_y(cell->east);
    out->sx = point_x(cell->south);
    out->sy = point_y(cell->south) + 1;
    out->cut = arms_cut(cell);
}

/* The one arm that leaves and is cut all the same, because a single edge of the cell runs on over the border; 0: there
 * is none. */
static unsigned arm_run_on(unsigned inside, unsigned leaving) {
    bool single = inside != 0 && (inside & (inside - 1)) == 0;
    unsigned opposite = (inside << 2 | inside >> 2) & 15u;
    if (!single)
        return 0;
    return opposite & leaving ? opposite : leaving & (0u - leaving);
}

/* Section 3: what a cell at the border has in place of the neighbours that are missing. */
static void complete_border(zt_silmap_cell *c, unsigned leaving) {
    unsigned run_on = arm_run_on(arms_cut(c) & ~leaving, leaving);
    uint8_t point = c->own & (ZT_SILMAP_X | ZT_SILMAP_Y);
    if (leaving & ZT_SILMAP_CUT_WEST) {
        c->west = point ^ ZT_SILMAP_X;
        c->own = (uint8_t)((c->own & ~ZT_SILMAP_WEST) | (run_on & ZT_SILMAP_CUT_WEST ? ZT_SILMAP_WEST : 0));
    }
    if (leaving & ZT_SILMAP_CUT_NORTH) {
        c->north = point ^ ZT_SILMAP_Y;
        c->own = (uint8_t)((c->own & ~ZT_SILMAP_NORTH) | (run_on & ZT_SILMAP_CUT_NORTH ? ZT_SILMAP_NORTH : 0));
    }
    if (leaving & ZT_SILMAP_CUT_EAST)
        c->east = (uint8_t)((point ^ ZT_SILMAP_X) | (run_on & ZT_SILMAP_CUT_EAST ? ZT_SILMAP_WEST : 0));
    if (leaving & ZT_SILMAP_CUT_SOUTH)
        c->south = (uint8_t)((point ^ ZT_SILMAP_Y) | (run_on & ZT_SILMAP_CUT_SOUTH ? ZT_SILMAP_NORTH : 0));
}

void zt_silmap_cell_at(const uint8_t *cells, uint32_t cells_x, uint32_t cells_y, int repeat_x, int repeat_y, uint32_t x,
                       uint32_t y, zt_silmap_cell *out) {
    const uint8_t *row = cells + (size_t)y * cells_x;
    const uint8_t *above = y > 0 ? row - cells_x : cells + (size_t)(cells_y - 1) * cells_x;
    const uint8_t *below = y + 1 < cells_y ? row + cells_x : cells;
    unsigned leaving = (y == 0 && !repeat_y ? (unsigned)ZT_SILMAP_CUT_NORTH : 0u) |
                       (x + 1 == cells_x && !repeat_x ? (unsigned)ZT_SILMAP_CUT_EAST : 0u) |
                       (y + 1 == cells_y && !repeat_y ? (unsigned)ZT_SILMAP_CUT_SOUTH : 0u) |
                       (x == 0 && !repeat_x ? (unsigned)ZT_SILMAP_CUT_WEST : 0u);
    out->own = row[x];
    out->west = row[x > 0 ? x - 1 : cells_x - 1];
    out->north = above[x];
    out->east = row[x + 1 < cells_x ? x + 1 : 0];
    out->south = below[x];
    if (leaving)
        complete_border(out, leaving);
}

int zt_silmap_shape_quadrant(const zt_silmap_shape *s, double x, double y) {
    bool below = x < s->px ? (y - s->wy) * (s->px - s->wx) >= (x - s->wx) * (s->py - s->wy)
                           : (y - s->py) * (s->ex - s->px) >= (x - s->px) * (s->ey - s->py);
    bool right = y < s->py ? (x - s->nx) * (s->py - s->ny) >= (y - s->ny) * (s->px - s->nx)
                           : (x - s->px) * (s->sy - s->py) >= (y - s->py) * (s->sx - s->px);
    return (right ? RIGHT : 0) | (below ? BELOW : 0);
}

int zt_silmap_quadrant(const zt_silmap_cell *cell, double x, double y) {
    zt_silmap_shape shape;
    zt_silmap_shape_of(cell, &shape);
    return zt_silmap_shape_quadrant(&shape, x, y);
}

/* ---- weights ------------------------------------------------------------------------------------ */

/* What cut arms make of a cell. */
typedef enum cell_case { UNCUT, CRACK, THROUGH, CORNER, TEE, ALL } cell_case;

/* By the set of cut arms: north 1, east 2, south 4, west 8. */
static const uint8_t case_of[16] = {UNCUT, CRACK,  CRACK,   CORNER, CRACK,  THROUGH, CORNER, TEE,
                                    CRACK, CORNER, THROUGH, TEE,    CORNER, TEE,     TEE,    ALL};

static void bilinear(double x, double y, double w[4]) {
    w[ZT_SILMAP_00] = (1 - x) * (1 - y);
    w[ZT_SILMAP_10] = x * (1 - y);
    w[ZT_SILMAP_01] = (1 - x) * y;
    w[ZT_SILMAP_11] = x * y;
}

static void own_corner(int quadrant, double w[4]) {
    w[0] = w[1] = w[2] = w[3] = 0;
    w[quadrant] = 1;
}

/* Linear between the quadrant's corner and the one to its left or right, along x. */
static void along_x(int quadrant, double x, double w[4]) {
    w[0] = w[1] = w[2] = w[3] = 0;
    w[quadrant & BELOW] = 1 - x;
    w[quadrant | RIGHT] = x;
}

static void along_y(int quadrant, double y, double w[4]) {
    w[0] = w[1] = w[2] = w[3] = 0;
    w[quadrant & RIGHT] = 1 - y;
    w[quadrant | BELOW] = y;
}

static double above_zero(double v) {
    return v > 0 ? v : 0;
}

/* One cut arm: a crack that ends at the point. c and d are the ends of the side that it crosses. */
static void crack(const zt_silmap_shape *s, int quadrant, double x, double y, double w[4]) {
    bool vertical = (s->cut & (ZT_SILMAP_CUT_NORTH | ZT_SILMAP_CUT_SOUTH)) != 0;
    int c = s->cut == ZT_SILMAP_CUT_SOUTH ? ZT_SILMAP_01 : s->cut == ZT_SILMAP_CUT_EAST ? ZT_SILMAP_10 : ZT_SILMAP_00;
    int step = vertical ? RIGHT : BELOW;
    double t = vertical ? x : y;
    double h;
    switch (s->cut) {
    case ZT_SILMAP_CUT_NORTH:
        h = above_zero((s->py - y) / s->py);
        break;
    case ZT_SILMAP_CUT_SOUTH:
        h = above_zero((y - s->py) / (1 - s->py));
        break;
    case ZT_SILMAP_CUT_WEST:
        h = above_zero((s->px - x) / s->px);
        break;
    default:
        h = above_zero((x - s->px) / (1 - s->px));
        break;
    }
    double side = (quadrant & step) != 0 ? 1 - t : -t;
    bilinear(x, y, w);
    w[c + step] += h * side;
    w[c] -= h * side;
}

/* The quadrant between the two arms of the case CORNER. */
static int cut_off_quadrant(unsigned cut) {
    return (cut & ZT_SILMAP_CUT_EAST ? RIGHT : 0) | (cut & ZT_SILMAP_CUT_SOUTH ? BELOW : 0);
}

static void corner_cut_off(int m, double x, double y, double w[4]) {
    double dx = m & RIGHT ? 1 - x : x;
    double dy = m & BELOW ? 1 - y : y;
    bilinear(x, y, w);
    if (dx + dy == 0)
        return;
    double cm = w[m];
    w[m] = 0;
    w[m ^ BELOW] += cm * (dy / (dx + dy));
    w[m ^ RIGHT] += cm * (dx / (dx + dy));
}

/* Three cut arms: only the pair of quadrants at the fourth is joined. */
static void tee(unsigned cut, int quadrant, double x, double y, double w[4]) {
    unsigned joint = ~cut & 15u;
    bool vertical = (joint & (ZT_SILMAP_CUT_NORTH | ZT_SILMAP_CUT_SOUTH)) != 0;
    bool far_side = (joint & (ZT_SILMAP_CUT_SOUTH | ZT_SILMAP_CUT_EAST)) != 0;
    bool joined = ((quadrant & (vertical ? BELOW : RIGHT)) != 0) == far_side;
    if (!joined)
        own_corner(quadrant, w);
    else if (vertical)
        along_x(quadrant, x, w);
    else
        along_y(quadrant, y, w);
}

/* The plane through the corners other than the one left out; the right angle is opposite to that. */
static unsigned plane_without(int left_out, double x, double y, double w[4]) {
    int k = left_out ^ 3;
    double ax = k & RIGHT ? 1 - x : x;
    double ay = k & BELOW ? 1 - y : y;
    w[left_out] = 0;
    w[k] = 1 - ax - ay;
    w[k ^ RIGHT] = ax;
    w[k ^ BELOW] = ay;
    return 15u & ~(1u << left_out);
}

/* With one arm cut; the other quadrant at the arm is the one whose corner is left out. */
static unsigned sen_crack(unsigned cut, int quadrant, double x, double y, double w[4]) {
    bool vertical = (cut & (ZT_SILMAP_CUT_NORTH | ZT_SILMAP_CUT_SOUTH)) != 0;
    bool far_side = (cut & (ZT_SILMAP_CUT_SOUTH | ZT_SILMAP_CUT_EAST)) != 0;
    if (((quadrant & (vertical ? BELOW : RIGHT)) != 0) == far_side)
        return plane_without(quadrant ^ (vertical ? RIGHT : BELOW), x, y, w);
    bilinear(x, y, w);
    return 0;
}

unsigned zt_silmap_shape_weights(zt_silmap_filter filter, const zt_silmap_shape *s, int quadrant, double x, double y,
                                 double w[4]) {
    quadrant &= 3;
    if (filter == ZT_SILMAP_NEAREST) {
        own_corner(quadrant, w);
        return 0;
    }
    switch ((cell_case)case_of[s->cut & 15u]) {
    case UNCUT:
        bilinear(x, y, w);
        return 0;
    case CRACK:
        if (filter == ZT_SILMAP_SEN2004)
            return sen_crack(s->cut, quadrant, x, y, w);
        crack(s, quadrant, x, y, w);
        return 0;
    case THROUGH:
        if (s->cut & ZT_SILMAP_CUT_NORTH)
            along_y(quadrant, y, w);
        else
            along_x(quadrant, x, w);
        return 0;
    case CORNER:
        if (quadrant != cut_off_quadrant(s->cut)) {
            if (filter == ZT_SILMAP_SEN2004)
                return plane_without(cut_off_quadrant(s->cut), x, y, w);
            corner_cut_off(cut_off_quadrant(s->cut), x, y, w);
            return 0;
        }
        break;
    case TEE:
        tee(s->cut, quadrant, x, y, w);
        return 0;
    default:
        break;
    }
    own_corner(quadrant, w);
    return 0;
}

unsigned zt_silmap_weights(zt_silmap_filter filter, const zt_silmap_cell *cell, int quadrant, double x, double y,
                           double weights[4]) {
    zt_silmap_shape shape;
    zt_silmap_shape_of(cell, &shape);
    return zt_silmap_shape_weights(filter, &shape, quadrant, x, y, weights);
}

/* ---- areas --------------------------------------------------------------------------------------- */

/* Corner, crossing, point, crossing: half the cross product of the diagonals. */
static double area(double corner_x, double corner_y, double ax, double ay, double px, double py, double bx, double by) {
    double twice = (px - corner_x) * (by - ay) - (py - corner_y) * (bx - ax);
    return (twice < 0 ? -twice : twice) / 2;
}

void zt_silmap_areas(const zt_silmap_cell *cell, double areas[4]) {
    zt_silmap_shape s;
    zt_silmap_shape_of(cell, &s);
    double north = s.nx + (s.px - s.nx) * s.ny / (s.ny - s.py);
    double south = s.px + (s.sx - s.px) * (1 - s.py) / (s.sy - s.py);
    double west = s.wy + (s.py - s.wy) * s.wx / (s.wx - s.px);
    double east = s.py + (s.ey - s.py) * (1 - s.px) / (s.ex - s.px);
    areas[ZT_SILMAP_00] = area(0, 0, north, 0, s.px, s.py, 0, west);
    areas[ZT_SILMAP_10] = area(1, 0, 1, east, s.px, s.py, north, 0);
    areas[ZT_SILMAP_01] = area(0, 1, 0, west, s.px, s.py, south, 1);
    areas[ZT_SILMAP_11] = area(1, 1, south, 1, s.px, s.py, 1, east);
}

/* ---- the minified image ---------------------------------------------------------------------------- */

static void minify_cell(const zt_silmap_cell *cell, const float *corners[4], float out[4]) {
    double areas[4];
    zt_silmap_areas(cell, areas);
    for (int channel = 0; channel < 4; channel++) {
        double sum = 0;
        for (int k = 0; k < 4; k++)
            sum += areas[k] * (double)corners[k][channel];
        out[channel] = (float)sum;
    }
}

zt_result zt_minify_silmap(const uint8_t *cells, uint32_t cells_x, uint32_t cells_y, const float *samples,
                           uint32_t samples_x, uint32_t samples_y, float *out) {
    bool repeat_x = samples_x == cells_x, repeat_y = samples_y == cells_y;
    if (!cells || !samples || !out || cells_x == 0 || cells_y == 0 || cells_x == UINT32_MAX || cells_y == UINT32_MAX)
        return ZT_BAD_ARGUMENT;
    if ((!repeat_x && samples_x != cells_x + 1) || (!repeat_y && samples_y != cells_y + 1))
        return ZT_BAD_ARGUMENT;
    for (uint32_t y = 0; y < cells_y; y++) {
        const float *above = samples + (size_t)y * samples_x * 4;
        const float *below = samples + (size_t)((y + 1) % samples_y) * samples_x * 4;
        for (uint32_t x = 0; x < cells_x; x++, out += 4) {
            size_t left = (size_t)x * 4, right = (size_t)((x + 1) % samples_x) * 4;
            const float *corners[4] = {above + left, above + right, below + left, below + right};
            zt_silmap_cell cell;
            zt_silmap_cell_at(cells, cells_x, cells_y, repeat_x, repeat_y, x, y, &cell);
            minify_cell(&cell, corners, out);
        }
    }
    return ZT_OK;
}
