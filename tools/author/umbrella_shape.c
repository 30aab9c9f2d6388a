/* SPDX-License-Identifier: Apache-2.0 */
/* Outlines: area, centre, kernel, star shape, fewer vertices. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "umbrella_private.h"

#define BISECTIONS 50
#define HAIR 0x1p-20 /* of the distance from the centre: between two vertices that a repair puts on one ray */

void author_outline_release(author_outline *outline) {
    free(outline->points);
    *outline = (author_outline){0};
}

static author_xy next_of(const author_outline *o, size_t i) {
    return o->points[i + 1 < o->count ? i + 1 : 0];
}

double author_outline_area(const author_outline *outline) {
    double sum = 0;
    for (size_t i = 1; i + 1 < outline->count; i++)
        sum += umb_cross(umb_less(outline->points[i], outline->points[0]),
                         umb_less(outline->points[i + 1], outline->points[0]));
    return sum / 2;
}

author_xy author_outline_centroid(const author_outline *outline) {
    author_xy origin = outline->points[0], sum = {0, 0};
    double area = 0;
    for (size_t i = 1; i + 1 < outline->count; i++) {
        author_xy a = umb_less(outline->points[i], origin), b = umb_less(outline->points[i + 1], origin);
        double part = umb_cross(a, b);
        sum.x += part * (a.x + b.x);
        sum.y += part * (a.y + b.y);
        area += part;
    }
    return area == 0 ? origin : (author_xy){origin.x + sum.x / (3 * area), origin.y + sum.y / (3 * area)};
}

size_t author_outline_bad_vertex(const author_outline *outline, author_xy centre) {
    size_t turns = 0, last = 0;
    for (size_t i = 0; i < outline->count; i++) {
        author_xy d = umb_less(outline->points[i], centre), e = umb_less(next_of(outline, i), centre);
        if (!(umb_cross(d, e) > 0))
            return i;
        if (d.y < 0 && e.y >= 0) {
            turns++;
            last = i;
        }
    }
    return turns == 1 ? outline->count : last;
}

/* ---- kernel ------------------------------------------------------------------------------------------------ */

/* The part of a convex polygon that lies at least `distance` inside of the line from a to b; room for one point
 * more. */
static size_t clip(author_xy *points, size_t count, author_xy a, author_xy b, double distance, author_xy *scratch) {
    author_xy along = umb_less(b, a);
    double length = sqrt(along.x * along.x + along.y * along.y);
    size_t kept = 0;
    if (length == 0)
        return count;
    for (size_t i = 0; i < count; i++) {
        author_xy p = points[i], q = points[i + 1 < count ? i + 1 : 0];
        double dp = umb_cross(along, umb_less(p, a)) / length - distance;
        double dq = umb_cross(along, umb_less(q, a)) / length - distance;
        if (dp >= 0)
            scratch[kept++] = p;
        if ((dp >= 0) != (dq >= 0))
            scratch[kept++] = umb_mix(p, q, dp / (dp - dq));
    }
    memcpy(points, scratch, kept * sizeof *points);
    return kept;
}

/* The corners of what lies at least `distance` inside of all sides; room for count + 8. */
static size_t inset(const author_outline *o, const author_xy box[2], double distance, author_xy *points,
                    author_xy *scratch) {
    size_t count = 4;
    points[0] = box[0];
    points[1] = (author_xy){box[1].x, box[0].y};
    points[2] = box[1];
    points[3] = (author_xy){box[0].x, box[1].y};
    for (size_t i = 0; i < o->count && count > 0; i++)
        count = clip(points, count, o->points[i], next_of(o, i), distance, scratch);
    return count;
}

static void find_box(const author_outline *o, author_xy box[2]) {
    box[0] = box[1] = o->points[0];
    for (size_t i = 1; i < o->count; i++) {
        box[0] = (author_xy){fmin(box[0].x, o->points[i].x), fmin(box[0].y, o->points[i].y)};
        box[1] = (author_xy){fmax(box[1].x, o->points[i].x), fmax(box[1].y, o->points[i].y)};
    }
}

double author_outline_kernel(const author_outline *outline, author_xy *centre) {
    author_xy box[2];
    size_t room = 2 * outline->count + 16;
    author_xy *points = malloc(2 * room * sizeof *points), *scratch = points + room;
    double low = -1;
    if (!points)
        return -1;
    find_box(outline, box);
    double high = fmin(box[1].x - box[0].x, box[1].y - box[0].y);
    double from = 0;
    for (int i = 0; i <= BISECTIONS; i++) {
        double middle = i == 0 ? 0 : (from + high) / 2;
        size_t count = inset(outline, box, middle, points, scratch);
        if (count == 0 && i == 0)
            break;
        if (count == 0) {
            high = middle;
            continue;
        }
        from = low = middle;
        *centre = (author_xy){0, 0};
        for (size_t k = 0; k < count; k++) {
            centre->x += points[k].x / (double)count;
            centre->y += points[k].y / (double)count;
        }
    }
    free(points);
    return low;
}

/* ---- repair ------------------------------------------------------------------------------------------------ */

double umb_farthest(const author_outline *outline, author_xy centre, author_xy d) {
    double most = 0;
    for (size_t i = 0; i < outline->count; i++) {
        author_xy a = umb_less(outline->points[i], centre), b = umb_less(next_of(outline, i), centre);
        author_xy ab = umb_less(b, a);
        double ca = umb_cross(d, a), cb = umb_cross(d, b), slope = umb_cross(d, ab);
        if ((ca > 0 && cb > 0) || (ca < 0 && cb < 0) || slope == 0)
            continue;
        most = fmax(most, umb_cross(a, ab) / slope);
    }
    return most;
}

static int half_of(author_xy d) {
    return d.y < 0 || (d.y == 0 && d.x < 0);
}

/* By angle from the direction of x on, clockwise as one sees it. */
static int by_angle(const void *left, const void *right) {
    const author_xy *a = left, *b = right;
    if (half_of(*a) != half_of(*b))
        return half_of(*a) - half_of(*b);
    double cross = umb_cross(*a, *b);
    if (cross != 0)
        return cross > 0 ? -1 : 1;
    double length = a->x * a->x + a->y * a->y - b->x * b->x - b->y * b->y;
    return length < 0 ? -1 : length > 0;
}

/* Directions through all vertices, and a hair to either side of them, where another side may take over. */
author_result author_outline_repair(author_run *run, author_outline *outline, author_xy centre) {
    size_t count = outline->count, kept = 0;
    author_xy *d = author_alloc(run, 3 * count, sizeof *d);
    if (!d)
        return AUTHOR_NO_MEMORY;
    for (size_t i = 0; i < count; i++) {
        author_xy v = umb_less(outline->points[i], centre);
        d[3 * i] = v;
        d[3 * i + 1] = (author_xy){v.x - HAIR * v.y, v.y + HAIR * v.x};
        d[3 * i + 2] = (author_xy){v.x + HAIR * v.y, v.y - HAIR * v.x};
    }
    qsort(d, 3 * count, sizeof *d, by_angle);
    for (size_t i = 0; i < 3 * count; i++) {
        double far = umb_farthest(outline, centre, d[i]);
        author_xy p = {far * d[i].x, far * d[i].y};
        if (far > 0 && (kept == 0 || umb_cross(d[kept - 1], p) > 0))
            d[kept++] = p;
    }
    while (kept > 3 && !(umb_cross(d[kept - 1], d[0]) > 0))
        kept--;
    for (size_t i = 0; i < kept; i++)
        d[i] = (author_xy){centre.x + d[i].x, centre.y + d[i].y};
    free(outline->points);
    *outline = (author_outline){d, kept};
    size_t bad = kept < 3 ? 0 : author_outline_bad_vertex(outline, centre);
    if (bad < kept || kept < 3)
        return author_fail(run, AUTHOR_BAD_INPUT,
                           "the outline cannot be repaired: its centre %.1f, %.1f is not inside. Give another one",
                           centre.x, centre.y);
    return AUTHOR_OK;
}

/* ---- fewer vertices ----------------------------------------------------------------------------------------- */

typedef struct change {
    size_t at; /* vertex that goes, or the first of a side that becomes one point */
    int side;
    author_xy point;
    double area;
} change;

static author_xy at(const author_outline *o, size_t i, size_t step) {
    return o->points[(i + step) % o->count];
}

/* What it costs to do without vertex i + 1 (reflex), or to make one of i + 1 and i + 2. */
static void price(const author_outline *o, size_t i, change *best) {
    author_xy a = at(o, i, 0), b = at(o, i, 1), c = at(o, i, 2), d = at(o, i, 3);
    author_xy ab = umb_less(b, a), bc = umb_less(c, b), cd = umb_less(d, c);
    double first = umb_cross(ab, bc), second = umb_cross(bc, cd), both = umb_cross(ab, cd);
    if (first <= 0) {
        if (-first / 2 < best->area)
            *best = (change){(i + 1) % o->count, 0, b, -first / 2};
        return;
    }
    if (second <= 0 || both <= 0)
        return;
    double far = second / both; /* of ab, beyond b */
    double area = first * far / 2;
    if (area < best->area)
        *best = (change){(i + 1) % o->count, 1, {b.x + far * ab.x, b.y + far * ab.y}, area};
}

static void apply(author_outline *o, const change *c) {
    size_t gone = c->at;
    if (c->side) {
        o->points[c->at] = c->point;
        gone = (c->at + 1) % o->count;
    }
    memmove(o->points + gone, o->points + gone + 1, (o->count - gone - 1) * sizeof *o->points);
    o->count--;
}

author_result author_umbrella_simplify(author_run *run, author_outline *outline, size_t most) {
    while (outline->count > most && outline->count > 3) {
        change best = {.area = INFINITY};
        for (size_t i = 0; i < outline->count; i++)
            price(outline, i, &best);
        if (!isfinite(best.area))
            return author_fail(run, AUTHOR_BAD_INPUT, "the outline cannot do with %zu vertices: allow more", most);
        apply(outline, &best);
    }
    return AUTHOR_OK;
}
