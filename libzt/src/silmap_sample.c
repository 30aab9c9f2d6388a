/* SPDX-License-Identifier: Apache-2.0 */
/* Lookups in silmaps, in the order of spec/silmap.md section 6. */
#include "silmap_sample.h"

#include <math.h>

/* What stays the same for all parts of a lookup. */
typedef struct lookup {
    zt__sample_call *call;
    zt__silmap_scratch *scratch;
    const zt__silmap_view *view;
    zt_silmap_filter filter;
    uint32_t layer;
} lookup;

/* In place of fmin and fmax: nothing here is NaN, and these need no call. */
static inline double least(double a, double b) {
    return a < b ? a : b;
}

static inline double most(double a, double b) {
    return a > b ? a : b;
}

/* ---- cells ---------------------------------------------------------------------------------------- */

static zt_result fetch_corners(const lookup *l, uint32_t x, uint32_t y, double colour[4][4]) {
    const zt__silmap *s = l->view->silmap;
    uint32_t right = s->repeat_x && x + 1 == s->header.cells_x ? 0 : x + 1;
    uint32_t below = s->repeat_y && y + 1 == s->header.cells_y ? 0 : y + 1;
    for (int k = 0; k < 4; k++) {
        float rgba[4];
        ZT_TRY(zt__fetch_texel(l->call, l->view->samples, k & 1 ? right : x, k & 2 ? below : y, l->layer, rgba));
        for (int c = 0; c < 4; c++)
            colour[k][c] = (double)rgba[c];
    }
    return ZT_OK;
}

/* Cells that share a side have different places in the scratch, and so have the layers of samples that one lookup
 * wants. */
static zt_result corners_of(const lookup *l, uint32_t x, uint32_t y, const zt__silmap_corners **out) {
    const zt__silmap *s = l->view->silmap;
    zt__silmap_corners *c = &l->scratch->near[(x & 1) | (y & 1) << 1 | (l->view->samples & 1) << 2];
    *out = c;
    if (c->silmap == s && c->samples == l->view->samples && c->layer == l->layer && c->x == x && c->y == y)
        return ZT_OK;
    uint64_t cell_layer = zt__min32(l->layer, s->header.cell_layers - 1);
    const uint8_t *cells = s->cells + cell_layer * s->header.cells_x * s->header.cells_y;
    zt_silmap_cell cell;
    zt_silmap_cell_at(cells, s->header.cells_x, s->header.cells_y, s->repeat_x, s->repeat_y, x, y, &cell);
    c->silmap = NULL; /* while it is being filled */
    ZT_TRY(fetch_corners(l, x, y, c->colour));
    zt_silmap_shape_of(&cell, &c->shape);
    c->silmap = s;
    c->samples = l->view->samples;
    c->layer = l->layer;
    c->x = x;
    c->y = y;
    return ZT_OK;
}

/* ---- the box (step 3) -------------------------------------------------------------------------------- */

/* Part of the box in one direction: in a cell, with its centre and half extent in the cell's coordinates. */
typedef struct span {
    uint32_t cell;
    double centre, half, share;
} span;

/* A direction: how many cells, whether they go round, and the box. */
typedef struct direction {
    double at, half; /* in cells */
    uint32_t cells;
    bool repeats;
} direction;

static uint32_t cell_index(const direction *d, double floor_of) {
    if (floor_of < 0)
        return d->cells - 1;
    if (floor_of >= d->cells)
        return d->repeats ? 0 : d->cells - 1;
    return (uint32_t)floor_of;
}

static span span_of(const direction *d, double cell, double low, double high, double whole) {
    span s = {cell_index(d, cell), (low + high) / 2 - cell, (high - low) / 2, (high - low) / whole};
    return s;
}

/* One or two spans; the box has at most one cell's extent. */
static int spans_of(const direction *d, span out[2]) {
    double low = d->at - d->half, high = d->at + d->half;
    if (!d->repeats) {
        low = most(low, 0);
        high = least(high, d->cells);
    }
    if (!(low < high)) {
        double cell = least(floor(d->at), (double)d->cells - 1);
        out[0] = (span){(uint32_t)cell, d->at - cell, 0, 1};
        return 1;
    }
    double first = floor(low), side = first + 1;
    if (high <= side) {
        out[0] = span_of(d, first, low, high, high - low);
        return 1;
    }
    out[0] = span_of(d, first, low, side, high - low);
    out[1] = span_of(d, side, side, high, high - low);
    return 2;
}

/* ---- one part (step 4) --------------------------------------------------------------------------------- */

/* The signed distance of (x, y) from a line through (ax, ay) with the normal (nx, ny), over the box's reach along
 * that. */
static double quotient(double x, double y, double bx, double by, double ax, double ay, double nx, double ny) {
    double distance = (x - ax) * nx + (y - ay) * ny;
    double reach = bx * fabs(nx) + by * fabs(ny);
    if (reach > 0)
        return distance / reach;
    return distance >= 0 ? (double)INFINITY : -(double)INFINITY;
}

static double coverage(double d, double e, bool convex) {
    double t = convex ? least(d, e) : most(d, e);
    return least(most((1 + t) / 2, 0), 1);
}

/* How much of the box is to the right of N - p - S. */
static double right_of(const zt_silmap_shape *s, double x, double y, double bx, double by) {
    double nx = s->px - s->nx, ny = s->py - s->ny, sx = s->sx - s->px, sy = s->sy - s->py;
    return coverage(quotient(x, y, bx, by, s->nx, s->ny, ny, -nx), quotient(x, y, bx, by, s->px, s->py, sy, -sx),
                    nx * sy - ny * sx <= 0);
}

/* And how much below W - p - E. */
static double below_of(const zt_silmap_shape *s, double x, double y, double bx, double by) {
    double wx = s->px - s->wx, wy = s->py - s->wy, ex = s->ex - s->px, ey = s->ey - s->py;
    return coverage(quotient(x, y, bx, by, s->wx, s->wy, -wy, wx), quotient(x, y, bx, by, s->px, s->py, -ey, ex),
                    wx * ey - wy * ex >= 0);
}

/* Brings a colour into the range of the corners of a set. */
static void limit(const zt__silmap_corners *c, unsigned set, double colour[4]) {
    for (int channel = 0; channel < 4; channel++) {
        double low = (double)INFINITY, high = -(double)INFINITY;
        for (int k = 0; k < 4; k++) {
            if (set >> k & 1) {
                low = least(low, c->colour[k][channel]);
                high = most(high, c->colour[k][channel]);
            }
        }
        colour[channel] = least(most(colour[channel], low), high);
    }
}

/* Adds the colour of one quadrant's formula. */
static void add_quadrant(const lookup *l, const zt__silmap_corners *c, int quadrant, double x, double y, double share,
                         double sum[4]) {
    double w[4], colour[4];
    unsigned set = zt_silmap_shape_weights(l->filter, &c->shape, quadrant, x, y, w);
    for (int channel = 0; channel < 4; channel++)
        colour[channel] = w[0] * c->colour[0][channel] + w[1] * c->colour[1][channel] + w[2] * c->colour[2][channel] +
                          w[3] * c->colour[3][channel];
    if (set)
        limit(c, set, colour);
    for (int channel = 0; channel < 4; channel++)
        sum[channel] += share * colour[channel];
}

static void add_part(const lookup *l, const zt__silmap_corners *c, const span *h, const span *v, double sum[4]) {
    const zt_silmap_shape *s = &c->shape;
    double x = h->centre, y = v->centre, share = h->share * v->share;
    if (s->cut == 0 && l->filter != ZT_SILMAP_NEAREST) {
        add_quadrant(l, c, 0, x, y, share, sum); /* the same for each quadrant */
        return;
    }
    if (h->half == 0 && v->half == 0) {
        add_quadrant(l, c, zt_silmap_shape_quadrant(s, x, y), x, y, share, sum);
        return;
    }
    double right = right_of(s, x, y, h->half, v->half), below = below_of(s, x, y, h->half, v->half);
    for (int quadrant = 0; quadrant < 4; quadrant++) {
        double mixed = (quadrant & 1 ? right : 1 - right) * (quadrant & 2 ? below : 1 - below);
        if (mixed != 0)
            add_quadrant(l, c, quadrant, x, y, share * mixed, sum);
    }
}

static zt_result add_silmap(const lookup *l, const direction *horizontal, const direction *vertical, double sum[4]) {
    span across[2], down[2];
    int columns = spans_of(horizontal, across), rows = spans_of(vertical, down);
    for (int j = 0; j < rows; j++) {
        for (int i = 0; i < columns; i++) {
            const zt__silmap_corners *c;
            ZT_TRY(corners_of(l, across[i].cell, down[j].cell, &c));
            add_part(l, c, &across[i], &down[j], sum);
        }
    }
    return ZT_OK;
}

/* ---- the lookup ------------------------------------------------------------------------------------------ */

/* The weight of the minified image (step 2). */
static double minified_weight(const lookup *l, const zt_point *p) {
    const zt__silmap_header *h = &l->view->silmap->header;
    if (l->view->minified == ZT_NONE)
        return 0;
    double ux = p->du_dx * h->cells_x, vx = p->dv_dx * h->cells_y;
    double uy = p->du_dy * h->cells_x, vy = p->dv_dy * h->cells_y;
    double lambda = 0.5 * log2(most(ux * ux + vx * vx, uy * uy + vy * vy));
    if (l->call->look.filter != ZT_FILTER_TRILINEAR)
        return lambda > -0.5 ? 1 : 0;
    return least(most(lambda + 1, 0), 1);
}

static double half_extent(const lookup *l, double dx, double dy, uint32_t cells) {
    return l->call->look.filter == ZT_FILTER_TRILINEAR ? least((fabs(dx) + fabs(dy)) * cells / 2, 0.5) : 0;
}

zt_result zt__sample_silmap(zt__sample_call *call, zt__silmap_scratch *scratch, const zt__silmap_view *view,
                            const uint8_t wraps[3], const zt_point *point, float rgba[4]) {
    const zt__silmap *s = view->silmap;
    lookup l = {call, scratch, view, (zt_silmap_filter)s->header.filter,
                zt__min32(point->array_layer, call->set->images[view->samples].layers - 1)};
    double u = point->u, v = point->v, sum[4] = {0, 0, 0, 0};
    float small[4] = {0, 0, 0, 0};
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 0.0f;
    bool inside = zt__wrap_unit(&u, wraps[0]);
    inside = zt__wrap_unit(&v, wraps[1]) && inside;
    if (!inside)
        return ZT_OK;
    if (call->look.filter == ZT_FILTER_NEAREST)
        l.filter = ZT_SILMAP_NEAREST;
    double w = minified_weight(&l, point);
    if (w < 1) {
        direction horizontal = {u * s->header.cells_x, half_extent(&l, point->du_dx, point->du_dy, s->header.cells_x),
                                s->header.cells_x, wraps[0] == ZT_WRAP_REPEAT};
        direction vertical = {v * s->header.cells_y, half_extent(&l, point->dv_dx, point->dv_dy, s->header.cells_y),
                              s->header.cells_y, wraps[1] == ZT_WRAP_REPEAT};
        ZT_TRY(add_silmap(&l, &horizontal, &vertical, sum));
    }
    if (w > 0)
        ZT_TRY(zt__sample_image_at(call, view->minified, wraps, point, small));
    for (int c = 0; c < 4; c++)
        rgba[c] = (float)((1 - w) * sum[c] + w * (double)small[c]);
    return ZT_OK;
}
