/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which umbrellas each cell lists: those whose polygon comes within an eighth of a cell (a disc's radius) of it; and
 * where an ellipsoid bends the polygon outwards (section 6), those whose bent outline reaches it. The bent outline is
 * taken at BENT points a side.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "umbrella_private.h"

#define GROWN 0.125       /* cells */
#define BENT_GROWN 0x1p-6 /* what a chord of the bent outline may leave out, and more */
#define BENT 8
#define SLICE 256 /* umbrellas of a task */

typedef struct pair {
    uint32_t cell, entry;
} pair;

typedef struct pairs {
    pair *items;
    size_t count, room;
} pairs;

typedef struct listing {
    const zt_umbrella_info *info;
    const zt_umbrella_level *level;
    const int *repeat;
    pairs *slices;
    author_xy *scratch; /* for each worker: two outlines */
} listing;

typedef struct rect {
    double x0, y0, x1, y1;
} rect;

#define OUTLINE_ROOM ((size_t)AUTHOR_VERTICES * (BENT + 1))

/* ---- distance of a rectangle ---------------------------------------------------------------------------------- */

static double point_to_rect(author_xy p, const rect *r) {
    double dx = fmax(fmax(r->x0 - p.x, p.x - r->x1), 0), dy = fmax(fmax(r->y0 - p.y, p.y - r->y1), 0);
    return dx * dx + dy * dy;
}

static double point_to_side(author_xy p, author_xy a, author_xy b) {
    author_xy ab = umb_less(b, a), ap = umb_less(p, a);
    double square = ab.x * ab.x + ab.y * ab.y, t = square > 0 ? (ap.x * ab.x + ap.y * ab.y) / square : 0;
    author_xy d = umb_less(ap, (author_xy){fmin(fmax(t, 0), 1) * ab.x, fmin(fmax(t, 0), 1) * ab.y});
    return d.x * d.x + d.y * d.y;
}

/* One axis of the clipping of a side by a rectangle: what is left of [from, to]. */
static void clip_axis(double start, double step, double low, double high, double *from, double *to) {
    if (step == 0) {
        if (start < low || start > high)
            *to = -1;
        return;
    }
    double first = (low - start) / step, second = (high - start) / step;
    *from = fmax(*from, fmin(first, second));
    *to = fmin(*to, fmax(first, second));
}

static int side_crosses(author_xy a, author_xy b, const rect *r) {
    double from = 0, to = 1;
    clip_axis(a.x, b.x - a.x, r->x0, r->x1, &from, &to);
    clip_axis(a.y, b.y - a.y, r->y0, r->y1, &from, &to);
    return from <= to;
}

static int side_near(author_xy a, author_xy b, const rect *r, double grown) {
    if (fmin(a.x, b.x) > r->x1 + grown || fmax(a.x, b.x) < r->x0 - grown || fmin(a.y, b.y) > r->y1 + grown ||
        fmax(a.y, b.y) < r->y0 - grown)
        return 0;
    if (side_crosses(a, b, r))
        return 1;
    double least = fmin(point_to_rect(a, r), point_to_rect(b, r));
    least = fmin(least, point_to_side((author_xy){r->x0, r->y0}, a, b));
    least = fmin(least, point_to_side((author_xy){r->x1, r->y0}, a, b));
    least = fmin(least, point_to_side((author_xy){r->x0, r->y1}, a, b));
    least = fmin(least, point_to_side((author_xy){r->x1, r->y1}, a, b));
    return least <= grown * grown;
}

static int near(const author_xy *polygon, size_t count, const rect *r, double grown) {
    for (size_t i = 0; i < count; i++)
        if (side_near(polygon[i], polygon[i + 1 < count ? i + 1 : 0], r, grown))
            return 1;
    return umb_covers(polygon, count, (author_xy){r->x0, r->y0});
}

/* ---- the outline that an ellipsoid bends ------------------------------------------------------------------------ */

/* 0 when there is no ellipsoid. */
static double curvature_of(const zt_umbrella_info *info, const zt_umbrella *u) {
    const zt_umbrella_base *base = u->ellipsoid == ZT_ELLIPSOID_OF_BASE ? &info->bases[u->base] : NULL;
    uint32_t shape = base ? base->ellipsoid : u->ellipsoid, height = base ? base->height : u->height;
    if (shape == ZT_ELLIPSOID_FLAT || height == 0 || !(info->prism_height > 0))
        return 0;
    return ((base ? base->curvature : u->curvature) + 1.0) / 65536;
}

/* Where a lookup at distance l falls, the surface is at R sin(phi_max l / R) / sin(phi_max), which is farther out. */
static size_t bend(const author_xy *polygon, size_t count, double curvature, author_xy *out) {
    double radius = umb_radius(polygon, count), most = umb_arc(1 - curvature);
    double whole = sqrt(curvature * (2 - curvature)), c, s;
    size_t made = 0;
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < BENT; k++) {
            author_xy p = umb_mix(polygon[i], polygon[i + 1 < count ? i + 1 : 0], (double)k / BENT);
            double length = sqrt(p.x * p.x + p.y * p.y);
            umb_turn(most * length / radius, &c, &s);
            double scale = fmax(radius * s / (whole * length), 1);
            out[made++] = (author_xy){p.x * scale, p.y * scale};
        }
    return made;
}

/* ---- lists ------------------------------------------------------------------------------------------------------ */

static int append(pairs *p, uint32_t cell, uint32_t entry) {
    if (p->count == p->room) {
        size_t room = p->room ? 2 * p->room : 1024;
        pair *more = realloc(p->items, room * sizeof *more);
        if (!more)
            return -1;
        p->items = more;
        p->room = room;
    }
    p->items[p->count++] = (pair){cell, entry};
    return 0;
}

typedef struct placed {
    const author_xy *flat, *bent;
    size_t flat_count, bent_count;
    author_xy centre, low, high; /* the box of both, grown, around the centre */
} placed;

static int64_t cell_of(double value, uint32_t cells) {
    double cell = floor(value);
    return cell < 0 ? 0 : cell >= cells ? (int64_t)cells - 1 : (int64_t)cell;
}

static int list_shifted(const listing *l, const placed *p, uint32_t entry, author_xy centre, pairs *out) {
    double w = l->level->width, h = l->level->height;
    double x0 = centre.x + p->low.x, x1 = centre.x + p->high.x, y0 = centre.y + p->low.y, y1 = centre.y + p->high.y;
    if (x1 < 0 || y1 < 0 || x0 > w || y0 > h)
        return 0;
    for (int64_t y = cell_of(y0, l->level->height); y <= cell_of(y1, l->level->height); y++)
        for (int64_t x = cell_of(x0, l->level->width); x <= cell_of(x1, l->level->width); x++) {
            rect r = {(double)x - centre.x, (double)y - centre.y, (double)x + 1 - centre.x, (double)y + 1 - centre.y};
            int meets = near(p->flat, p->flat_count, &r, GROWN) ||
                        (p->bent_count && near(p->bent, p->bent_count, &r, BENT_GROWN));
            if (meets && append(out, (uint32_t)(y * l->level->width + x), entry))
                return -1;
        }
    return 0;
}

static void find_box(placed *p) {
    p->low = p->high = p->flat[0];
    for (size_t i = 0; i < p->flat_count + p->bent_count; i++) {
        author_xy q = i < p->flat_count ? p->flat[i] : p->bent[i - p->flat_count];
        p->low = (author_xy){fmin(p->low.x, q.x), fmin(p->low.y, q.y)};
        p->high = (author_xy){fmax(p->high.x, q.x), fmax(p->high.y, q.y)};
    }
    p->low = (author_xy){p->low.x - GROWN, p->low.y - GROWN};
    p->high = (author_xy){p->high.x + GROWN, p->high.y + GROWN};
}

static author_result too_large(char *error, uint32_t index) {
    snprintf(error, AUTHOR_ERROR,
             "umbrella %u is larger than the texture, which repeats: more cells are wanted, or less size", index);
    return AUTHOR_BAD_INPUT;
}

static author_result list_one(const listing *l, uint32_t index, author_xy *scratch, pairs *out, char *error) {
    const zt_umbrella *u = &l->info->umbrellas[l->level->first_umbrella + index];
    placed p = {.flat = scratch, .bent = scratch + OUTLINE_ROOM, .centre = {u->x / 65536.0, u->y / 65536.0}};
    double curvature = curvature_of(l->info, u), w = l->level->width, h = l->level->height;
    p.flat_count = umb_polygon(l->info, u, l->level->bits, scratch);
    if (curvature > 0)
        p.bent_count = bend(scratch, p.flat_count, curvature, scratch + OUTLINE_ROOM);
    find_box(&p);
    if ((l->repeat[0] && fmax(-p.low.x, p.high.x) > w) || (l->repeat[1] && fmax(-p.low.y, p.high.y) > h))
        return too_large(error, index);
    for (int shift = 0; shift < 9; shift++) {
        int sx = shift % 3 - 1, sy = shift / 3 - 1;
        if ((sx && !l->repeat[0]) || (sy && !l->repeat[1]))
            continue;
        author_xy centre = {p.centre.x + sx * w, p.centre.y + sy * h};
        if (list_shifted(l, &p, index | (uint32_t)shift << ZT_UMBRELLA_SHIFT, centre, out)) {
            snprintf(error, AUTHOR_ERROR, "no memory for the lists of the cells");
            return AUTHOR_NO_MEMORY;
        }
    }
    return AUTHOR_OK;
}

static author_result list_slice(void *context, size_t index, unsigned worker, char *error) {
    listing *l = context;
    uint32_t first = (uint32_t)index * SLICE, end = first + SLICE;
    author_xy *scratch = l->scratch + worker * 2 * OUTLINE_ROOM;
    author_result result = AUTHOR_OK;
    if (end > l->level->umbrella_count)
        end = l->level->umbrella_count;
    for (uint32_t i = first; result == AUTHOR_OK && i < end; i++)
        result = list_one(l, i, scratch, &l->slices[index], error);
    return result;
}

/* Slices ascend, and in each of them the umbrellas; so every list ascends. */
static author_result join(author_run *run, const listing *l, size_t slices, uint32_t *starts, uint32_t **entries,
                          uint32_t *longest) {
    size_t cells = (size_t)l->level->width * l->level->height, total = 0;
    memset(starts, 0, (cells + 1) * sizeof *starts);
    for (size_t s = 0; s < slices; s++) {
        total += l->slices[s].count;
        for (size_t i = 0; i < l->slices[s].count; i++)
            starts[l->slices[s].items[i].cell + 1]++;
    }
    if (total > UINT32_MAX / 2)
        return author_fail(run, AUTHOR_BAD_INPUT, "the lists of the cells are too long: less density is wanted");
    uint32_t *list = author_alloc(run, total, sizeof *list), *next = author_alloc(run, cells, sizeof *next);
    if (!list || !next) {
        free(list);
        free(next);
        return AUTHOR_NO_MEMORY;
    }
    *longest = 0;
    for (size_t c = 0; c < cells; c++) {
        if (starts[c + 1] > *longest)
            *longest = starts[c + 1];
        starts[c + 1] += starts[c];
        next[c] = starts[c];
    }
    for (size_t s = 0; s < slices; s++)
        for (size_t i = 0; i < l->slices[s].count; i++)
            list[next[l->slices[s].items[i].cell]++] = l->slices[s].items[i].entry;
    free(next);
    *entries = list;
    return AUTHOR_OK;
}

author_result umb_lists(author_run *run, const zt_umbrella_info *info, uint32_t level, const int repeat[2],
                        uint32_t *starts, uint32_t **entries, uint32_t *longest) {
    listing l = {.info = info, .level = &info->levels[level], .repeat = repeat};
    size_t slices = (l.level->umbrella_count + SLICE - 1) / SLICE;
    *entries = NULL;
    l.slices = author_alloc(run, slices, sizeof *l.slices);
    l.scratch = author_alloc(run, author_workers(run), 2 * OUTLINE_ROOM * sizeof *l.scratch);
    author_result result = l.slices && l.scratch ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK)
        result = author_for(run, "lists", slices, list_slice, &l);
    if (result == AUTHOR_OK)
        result = join(run, &l, slices, starts, entries, longest);
    for (size_t s = 0; l.slices && s < slices; s++)
        free(l.slices[s].items);
    free(l.slices);
    free(l.scratch);
    return result;
}
