/* SPDX-License-Identifier: Apache-2.0 */
/* Lookups in umbrellas in 3-D, in the order of spec/umbrella.md sections 5 and 6. */
#include <math.h>

#include "umbrella_sample.h"

enum {
    MOST_WORK = 1 << 22 /* cells and their entries on the way of one ray; a grid's diagonal has 2^14 cells at most */
};

/* Further out there would be no room for a cell's inside in a double. */
static const double farthest = 0x1p40;

/* Rounding opens no crack where a ray goes from cell to cell. */
static const double slack = 0x1p-40;

const zt_hit zt__umbrella_miss = {.normal = {0.0f, 0.0f, 1.0f}, .t = 1.0f, .umbrella = ZT_NONE};

/* ---- ways through the grid --------------------------------------------------------------------------------- */

/* A ray in one direction, in cells; t is 0 to 1 along the ray. */
typedef struct axis {
    double from, delta;
    uint32_t cells;
    uint8_t wrap;
    double cell; /* a whole number */
    double next; /* t at which the ray leaves it */
} axis;

/* A cell of the grid that stands for one anywhere: a place v in that one is sign x (v - origin). */
typedef struct home {
    uint32_t cell;
    double origin, sign;
} home;

typedef struct walk {
    const zt__umbrella_lookup *lookup;
    const zt_umbrella_info *info;
    const zt_ray *ray;
    axis x, y;
    double t, end;
    uint32_t work;
} walk;

static bool wraps_around(const axis *a) {
    return a->wrap == ZT_WRAP_REPEAT || a->wrap == ZT_WRAP_MIRROR;
}

/* Cuts off what is outside of a grid that goes on nowhere. False: all of it. */
static bool clip(const axis *a, double *t, double *end) {
    if (wraps_around(a))
        return true;
    if (a->delta == 0)
        return a->from >= 0 && a->from <= a->cells;
    double first = (0 - a->from) / a->delta, second = (a->cells - a->from) / a->delta;
    double enter = first < second ? first : second, leave = first < second ? second : first;
    *t = enter > *t ? enter : *t;
    *end = leave < *end ? leave : *end;
    return *t < *end;
}

static void set_next(axis *a) {
    if (a->delta > 0)
        a->next = (a->cell + 1 - a->from) / a->delta;
    else if (a->delta < 0)
        a->next = (a->cell - a->from) / a->delta;
    else
        a->next = HUGE_VAL;
}

static void enter_grid(axis *a, double t) {
    a->cell = floor(a->from + t * a->delta);
    if (!wraps_around(a))
        a->cell = fmin(fmax(a->cell, 0), (double)a->cells - 1);
    set_next(a);
}

static void advance(axis *a, double t) {
    if (a->next <= t) {
        a->cell += a->delta > 0 ? 1 : -1;
        set_next(a);
    }
}

static home home_of(const axis *a) {
    double within = fmod(a->cell, a->cells);
    if (within < 0)
        within += a->cells;
    double origin = a->cell - within;
    if (a->wrap == ZT_WRAP_MIRROR && fmod(origin / a->cells, 2) != 0)
        return (home){a->cells - 1 - (uint32_t)within, origin + a->cells, -1};
    return (home){(uint32_t)within, origin, 1};
}

/* ---- a piece of the ray (section 5, steps 1 to 3) --------------------------------------------------------- */

/* What of the ray lies in a cell, bent; places are those of the cell's home, from `from` to `from` + `delta`. */
typedef struct piece {
    double t0, t1; /* of the unbent ray */
    double from[3], delta[3];
    double taper0, taper1;
    double sign_x, sign_y;
} piece;

/* The nearest hit so far. */
typedef struct hit {
    double s; /* along the piece */
    double at[2], normal[3];
    double rgba[4];
    uint32_t entry;
} hit;

static double footprint_at(const walk *w, double t) {
    return w->ray->footprint0 + t * (w->ray->footprint1 - w->ray->footprint0);
}

/* H / h. */
static double taper_at(const walk *w, double t) {
    double start = (double)w->info->taper_start, width = (double)w->info->taper_end - start;
    double x = fmin(fmax((footprint_at(w, t) - start) / width, 0), 1);
    return w->info->prism_height > 0 ? 1 - x * x * (3 - 2 * x) : 0;
}

/* False: the cell is flat. */
static bool bend(const walk *w, double t0, double t1, const home *x, const home *y, piece *p) {
    double z0 = w->ray->z0, dz = w->ray->z1 - w->ray->z0;
    p->t0 = t0;
    p->t1 = t1;
    p->taper0 = taper_at(w, t0);
    p->taper1 = taper_at(w, t1);
    if (p->taper0 <= 1 / 64.0 || p->taper1 <= 1 / 64.0)
        return false;
    p->sign_x = x->sign;
    p->sign_y = y->sign;
    p->from[0] = x->sign * (w->x.from + t0 * w->x.delta - x->origin);
    p->from[1] = y->sign * (w->y.from + t0 * w->y.delta - y->origin);
    p->from[2] = (z0 + t0 * dz) / p->taper0;
    p->delta[0] = x->sign * (t1 - t0) * w->x.delta;
    p->delta[1] = y->sign * (t1 - t0) * w->y.delta;
    p->delta[2] = (z0 + t1 * dz) / p->taper1 - p->from[2];
    return true;
}

/* ---- a ray and an umbrella (section 6) --------------------------------------------------------------------- */

/* An umbrella's shape. Heights are counted from the lift; those of a bowl downwards, from its rim. */
typedef struct shape {
    zt_umbrella_ellipsoid kind;
    double height, curvature, lift;
    double radius;
    double half_height, middle, half_width; /* c, z_0 and A */
} shape;

static shape shape_of(const walk *w, uint32_t umbrella) {
    const zt_umbrella *u = &w->info->umbrellas[umbrella];
    double unit = (double)w->info->prism_height / 65535;
    uint16_t height = u->height, curvature = u->curvature;
    shape s = {.kind = (zt_umbrella_ellipsoid)u->ellipsoid, .lift = u->lift * unit};
    if (u->ellipsoid == ZT_ELLIPSOID_OF_BASE) {
        const zt_umbrella_base *base = &w->info->bases[u->base];
        s.kind = (zt_umbrella_ellipsoid)base->ellipsoid;
        height = base->height;
        curvature = base->curvature;
    }
    s.height = height * unit;
    s.curvature = (curvature + 1) / 65536.0;
    if (!(s.height > 0)) {
        s.kind = ZT_ELLIPSOID_FLAT;
        return s;
    }
    double k = s.curvature;
    s.radius = zt__umbrella_radius(w->lookup->view->umbrellas, w->lookup->view->scene, umbrella);
    s.half_height = s.height / k;
    s.middle = s.height - s.half_height;
    s.half_width = s.radius / sqrt(k * (2 - k));
    return s;
}

/* Whether the piece, seen from above, comes as near to the centre as the radius. */
static bool comes_near(const double from[3], const double delta[3], double radius) {
    double distance2 = from[0] * from[0] + from[1] * from[1], radius2 = radius * radius;
    double length2 = delta[0] * delta[0] + delta[1] * delta[1];
    double along = -(from[0] * delta[0] + from[1] * delta[1]), across = from[0] * delta[1] - from[1] * delta[0];
    if (along <= 0)
        return distance2 <= radius2;
    if (along >= length2)
        return distance2 - 2 * along + length2 <= radius2;
    return across * across <= radius2 * length2;
}

/* Where the piece meets the shape, from the nearer one on; returns how many. from: relative to the centre; both with
 * heights as the shape counts them. */
static int meet(const shape *s, const double from[3], const double delta[3], double out[2]) {
    if (s->kind == ZT_ELLIPSOID_FLAT) {
        out[0] = -from[2] / delta[2];
        return delta[2] != 0;
    }
    double o[3] = {from[0] / s->half_width, from[1] / s->half_width, (from[2] - s->middle) / s->half_height};
    double d[3] = {delta[0] / s->half_width, delta[1] / s->half_width, delta[2] / s->half_height};
    double a = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
    double b = o[0] * d[0] + o[1] * d[1] + o[2] * d[2];
    double c = o[0] * o[0] + o[1] * o[1] + o[2] * o[2] - 1;
    double square = b * b - a * c;
    if (!(square >= 0) || !(a > 0))
        return 0;
    double q = b > 0 ? -b - sqrt(square) : -b + sqrt(square);
    double first = q / a, second = q != 0 ? c / q : first;
    out[0] = first < second ? first : second;
    out[1] = first < second ? second : first;
    return 2;
}

/* Brings the point of a cap to where its arc comes to lie when it is flattened. */
static void flatten(const shape *s, double taper, double z, double q[2]) {
    double r = sqrt(q[0] * q[0] + q[1] * q[1]);
    double cosine = fmin(fmax((z - s->middle) / s->half_height, -1), 1);
    double share = acos(cosine) / acos(1 - s->curvature);
    double factor = r > 0 ? 1 - taper + taper * s->radius * share / r : 0;
    q[0] *= factor;
    q[1] *= factor;
}

/* Turned towards where the ray comes from. In a mirrored cell it is that of the place where the ray is. */
static void set_normal(const shape *s, const piece *p, const double at[3], const double delta[3], double out[3]) {
    double a2 = s->half_width * s->half_width, c2 = s->half_height * s->half_height;
    double n[3] = {0, 0, 1};
    if (s->kind != ZT_ELLIPSOID_FLAT) {
        n[0] = at[0] / a2;
        n[1] = at[1] / a2;
        n[2] = (at[2] - s->middle) / c2;
    }
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    double sign = n[0] * delta[0] + n[1] * delta[1] + n[2] * delta[2] > 0 ? -1 : 1;
    sign = length > 0 ? sign / length : 0;
    out[0] = p->sign_x * sign * n[0];
    out[1] = p->sign_y * sign * n[1];
    out[2] = (s->kind == ZT_ELLIPSOID_CONCAVE ? -sign : sign) * n[2];
}

typedef struct candidate {
    uint32_t entry, umbrella;
    double centre[2]; /* shifted */
    shape shape;
    double from[3], delta[3];
} candidate;

/* One point of a shape: is it a hit? */
static zt_result try_point(const walk *w, const piece *p, const candidate *c, double s, hit *best) {
    const zt__umbrella_view *view = w->lookup->view;
    zt__pixel point = zt__pixel_of(0, 0, 0, 0);
    zt__sector sector;
    double at[3], rgba[4];
    for (int i = 0; i < 3; i++)
        at[i] = c->from[i] + s * c->delta[i];
    double q[2] = {at[0], at[1]};
    if (c->shape.kind != ZT_ELLIPSOID_FLAT) {
        if (!(at[2] >= 0))
            return ZT_OK;
        flatten(&c->shape, p->taper0 + s * (p->taper1 - p->taper0), at[2], q);
    }
    if (!(zt__umbrella_coverage(view->umbrellas, view->scene, c->umbrella, q[0], q[1], &point, &sector) > 0))
        return ZT_OK;
    double rho = footprint_at(w, p->t0 + s * (p->t1 - p->t0));
    zt__pixel pixel = zt__pixel_of(rho, 0, 0, rho);
    ZT_TRY(zt__umbrella_colour(w->lookup, c->umbrella, &sector, &pixel, rgba));
    if (!(rgba[3] >= 0.5))
        return ZT_OK;
    best->s = s;
    best->entry = c->entry;
    for (int i = 0; i < 4; i++)
        best->rgba[i] = rgba[i] / rgba[3];
    best->at[0] = at[0] + c->centre[0];
    best->at[1] = at[1] + c->centre[1];
    set_normal(&c->shape, p, at, c->delta, best->normal);
    return ZT_OK;
}

static zt_result try_entry(const walk *w, const piece *p, uint32_t entry, hit *best) {
    const zt_umbrella_level *level = &w->info->levels[0];
    candidate c = {.entry = entry, .umbrella = level->first_umbrella + (entry & ZT_UMBRELLA_ENTRY)};
    const zt__placed *placed = &w->lookup->view->scene->placed[c.umbrella];
    double s[2];
    c.centre[0] = placed->x + zt__umbrella_shift_x(level, entry);
    c.centre[1] = placed->y + zt__umbrella_shift_y(level, entry);
    for (int i = 0; i < 3; i++) {
        c.from[i] = p->from[i] - (i < 2 ? c.centre[i] : 0);
        c.delta[i] = p->delta[i];
    }
    if (!comes_near(c.from, c.delta, placed->radius * 1.000001))
        return ZT_OK;
    c.shape = shape_of(w, c.umbrella);
    c.from[2] -= c.shape.lift;
    if (c.shape.kind == ZT_ELLIPSOID_CONCAVE) {
        c.from[2] = c.shape.height - c.from[2];
        c.delta[2] = -c.delta[2];
    }
    int n = meet(&c.shape, c.from, c.delta, s);
    for (int i = 0; i < n; i++) {
        double before = best->s;
        if (!(s[i] >= -slack && s[i] <= 1 + slack && s[i] < before))
            continue;
        ZT_TRY(try_point(w, p, &c, s[i], best));
        if (best->s < before)
            return ZT_OK;
    }
    return ZT_OK;
}

/* ---- the ends of a walk -------------------------------------------------------------------------------------- */

static zt_point ground_point(const walk *w) {
    return (zt_point){.u = w->ray->u1,
                      .v = w->ray->v1,
                      .du_dx = w->ray->footprint1 / w->info->grid_x,
                      .dv_dy = w->ray->footprint1 / w->info->grid_y,
                      .array_layer = w->lookup->array_layer};
}

static void set_hit(const walk *w, const piece *p, const hit *h, zt_hit *out) {
    const zt_umbrella_level *level = &w->info->levels[0];
    double rho = footprint_at(w, p->t0 + h->s * (p->t1 - p->t0));
    zt__pixel pixel = zt__pixel_of(rho, 0, 0, rho);
    zt__umbrella_shade shade = zt__umbrella_shade_of(w->lookup, level, h->at[0], h->at[1], &pixel);
    double light = zt__umbrella_light_at(w->lookup, level, &shade, h->entry);
    for (int c = 0; c < 3; c++) {
        out->rgba[c] = (float)(h->rgba[c] * light);
        out->normal[c] = (float)h->normal[c];
    }
    out->rgba[3] = 1.0f;
    out->t = (float)fmin(fmax(p->t0 + h->s * (p->t1 - p->t0), 0), 1);
    out->kind = ZT_HIT_UMBRELLA;
    out->umbrella = h->entry & ZT_UMBRELLA_ENTRY;
}

/* Step 2: where heights have been tapered away. */
static zt_result end_flat(const walk *w, zt_hit *out) {
    zt_point p = ground_point(w);
    if (w->ray->z1 != 0)
        return ZT_OK;
    out->kind = ZT_HIT_FLAT;
    return zt__sample_umbrellas(w->lookup, &p, out->rgba);
}

/* Step 4: behind the last cell. */
static zt_result end_below(const walk *w, zt_hit *out) {
    const zt_umbrella_level *level = &w->info->levels[0];
    zt_point p = ground_point(w);
    if (w->ray->z1 != 0)
        return ZT_OK;
    double s = p.u, t = p.v;
    bool inside = zt__wrap_unit(&s, w->lookup->wraps[0]);
    inside = zt__wrap_unit(&t, w->lookup->wraps[1]) && inside;
    if (!inside)
        return ZT_OK;
    out->kind = ZT_HIT_BACKGROUND;
    zt__pixel pixel = zt__pixel_of(w->ray->footprint1, 0, 0, w->ray->footprint1);
    zt__umbrella_shade shade = zt__umbrella_shade_of(w->lookup, level, s * level->width, t * level->height, &pixel);
    float light = (float)zt__umbrella_light_below(w->lookup, level, &shade);
    ZT_TRY(zt__umbrella_background(w->lookup, &p, out->rgba));
    for (int c = 0; c < 3; c++)
        out->rgba[c] *= light;
    return ZT_OK;
}

/* ---- the walk ------------------------------------------------------------------------------------------------ */

/* One cell, from w->t to `until`. *done: the ray ends here. */
static zt_result visit(walk *w, double until, zt_hit *out, bool *done) {
    home x = home_of(&w->x), y = home_of(&w->y);
    const uint32_t *list;
    hit best = {.s = HUGE_VAL};
    piece p;
    if (!bend(w, w->t, until, &x, &y, &p)) {
        *done = true;
        return end_flat(w, out);
    }
    uint32_t n = zt__umbrella_list(w->info, &w->info->levels[0], x.cell, y.cell, &list);
    *done = n > MOST_WORK - w->work;
    if (*done)
        return ZT_OK;
    w->work += n;
    while (n-- > 0)
        ZT_TRY(try_entry(w, &p, list[n], &best));
    *done = best.s < HUGE_VAL;
    if (*done)
        set_hit(w, &p, &best, out);
    return ZT_OK;
}

static zt_result walk_cells(walk *w, zt_hit *out) {
    bool done = false;
    enter_grid(&w->x, w->t);
    enter_grid(&w->y, w->t);
    for (;;) {
        double until = fmax(fmin(fmin(w->x.next, w->y.next), w->end), w->t);
        if (until > w->t)
            ZT_TRY(visit(w, until, out, &done));
        if (done || ++w->work >= MOST_WORK)
            return ZT_OK;
        if (until >= w->end)
            return end_below(w, out);
        advance(&w->x, until);
        advance(&w->y, until);
        w->t = until;
    }
}

static axis axis_of(double u0, double u1, uint32_t cells, uint8_t wrap) {
    axis a = {.from = u0 * cells, .cells = cells, .wrap = wrap};
    a.delta = u1 * cells - a.from;
    return a;
}

static bool is_near(const axis *a) {
    return fabs(a->from) <= farthest && fabs(a->delta) <= farthest;
}

zt_result zt__sample_umbrella_ray(const zt__umbrella_lookup *lookup, const zt_ray *ray, zt_hit *out) {
    const zt_umbrella_info *info = &lookup->view->umbrellas->view;
    walk w = {.lookup = lookup, .info = info, .ray = ray, .end = 1};
    *out = zt__umbrella_miss;
    w.x = axis_of(ray->u0, ray->u1, info->grid_x, lookup->wraps[0]);
    w.y = axis_of(ray->v0, ray->v1, info->grid_y, lookup->wraps[1]);
    if (!is_near(&w.x) || !is_near(&w.y))
        return ZT_OK;
    if (clip(&w.x, &w.t, &w.end) && clip(&w.y, &w.t, &w.end))
        return walk_cells(&w, out);
    return end_below(&w, out);
}
