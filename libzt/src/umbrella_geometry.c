/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The sector of a point. Vertices are exact integers, and a linear map brings points to them; all that is asked there,
 * signs and ratios of cross products, does not depend on the map, so that nothing needs a length or an angle.
 */
#include "umbrella_geometry.h"

#include <math.h>

zt__pixel zt__pixel_of(double xx, double yx, double xy, double yy) {
    zt__pixel p = {{xx, yx, xy, yy}, (fabs(xx) + fabs(yx) + fabs(xy) + fabs(yy)) / 2};
    return p;
}

/* ---- contours --------------------------------------------------------------------------------------- */

zt__contour zt__contour_of(const zt_umbrella_info *info, const zt_umbrella *umbrella) {
    zt__contour c = {.count = umbrella->vertex_count};
    if (umbrella->form != ZT_UMBRELLA_PARAMETRIC) {
        c.offsets = info->explicit_vertices + umbrella->first_vertex;
        return c;
    }
    const zt_umbrella_base *base = &info->bases[umbrella->base];
    c.texels = info->base_vertices + base->first_vertex;
    c.centre = base->centre;
    c.count = base->vertex_count;
    if (base->first_morph != ZT_NONE && umbrella->morph != 0) {
        c.moved = info->morph_vertices + base->first_morph;
        c.weight = umbrella->morph;
    }
    return c;
}

zt_umbrella_offset zt__contour_vertex(const zt__contour *contour, uint32_t i) {
    if (contour->offsets)
        return contour->offsets[i];
    zt_umbrella_texel t = contour->texels[i];
    zt_umbrella_offset v = {t.x - contour->centre.x, t.y - contour->centre.y};
    if (contour->weight != 0) {
        v.x = 255 * v.x + contour->weight * (contour->moved[i].x - t.x);
        v.y = 255 * v.y + contour->weight * (contour->moved[i].y - t.y);
    }
    return v;
}

double zt__contour_radius(const zt__contour *c, double stretch) {
    double most = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        zt_umbrella_offset v = zt__contour_vertex(c, i);
        double x = v.x, y = v.y * stretch, length2 = x * x + y * y;
        most = length2 > most ? length2 : most;
    }
    return sqrt(most);
}

void zt__umbrella_units(const zt_umbrella_info *info, const zt_umbrella *umbrella, uint32_t bits, double units[4]) {
    if (umbrella->form != ZT_UMBRELLA_PARAMETRIC) {
        units[0] = units[3] = (double)(UINT32_C(1) << bits);
        units[1] = units[2] = 0;
        return;
    }
    /* The way back from cells to the picture. */
    const zt_umbrella_base *base = &info->bases[umbrella->base];
    bool moved = zt__contour_of(info, umbrella).weight != 0;
    double a = umbrella->a, b = umbrella->b;
    double unit = 65536.0 * 65535 * (moved ? 255 : 1) / (a * a + b * b);
    double across = umbrella->mirrored ? -unit : unit, down = unit * 65536 / base->aspect;
    units[0] = across * a;
    units[1] = across * b;
    units[2] = -down * b;
    units[3] = down * a;
}

/* ---- buckets ---------------------------------------------------------------------------------------- */

/* A quarter turn at most, so that a cross product says which of two directions comes first. Few enough to stay in
 * caches. */
uint32_t zt__bucket_count(uint32_t vertices) {
    uint32_t n = 4;
    while (n < ZT__MOST_BUCKETS && 2 * n < vertices)
        n *= 2;
    return n;
}

/* By a number that grows with the angle: from 0 to 4, and easier to get. */
uint32_t zt__bucket_of(double x, double y, uint32_t count) {
    double t = x / (fabs(x) + fabs(y));
    double turn = y >= 0 ? 1 - t : 3 + t;
    return zt__min32((uint32_t)(turn * (count / 4)), count - 1);
}

/* ---- sectors ---------------------------------------------------------------------------------------- */

static inline double cross(zt_umbrella_offset v, double x, double y) {
    return (double)v.x * y - (double)v.y * x;
}

static inline double cross_at(const zt__contour *c, uint32_t i, double x, double y) {
    return cross(zt__contour_vertex(c, i), x, y);
}

/* The number of a vertex that is a few turns off. */
static inline uint32_t vertex_number(const zt__contour *c, int32_t i) {
    int32_t count = c->count;
    while (i < 0)
        i += count;
    while (i >= count)
        i -= count;
    return (uint32_t)i;
}

/* Step 1. Between the bounds of its bucket the last vertex is sought that does not come after the point. */
static uint32_t find_sector(const zt__contour *c, const zt__bucket *buckets, double x, double y) {
    const zt__bucket *b = &buckets[1 + zt__bucket_of(x, y, zt__bucket_count(c->count))];
    int32_t first = buckets[0].least;
    int32_t least = b->least, most = b->most;
    while (least < most) {
        int32_t middle = least + (most - least + 1) / 2;
        if (cross_at(c, vertex_number(c, first + middle - 1), x, y) >= 0)
            least = middle;
        else
            most = middle - 1;
    }
    return vertex_number(c, first + least - 1);
}

/* Sets all but the coverage. A direction next to a bucket's side may be rounded to the wrong one, and a morph may turn
 * a vertex far: the sector is then one of the next. Without buckets (NULL) it is sought from the first one on. */
static void enter_sector(zt__sector *s, const zt__bucket *buckets) {
    const zt__contour *c = &s->contour;
    bool at_centre = s->x == 0 && s->y == 0;
    s->i = at_centre || !buckets ? 0 : find_sector(c, buckets, s->x, s->y);
    s->a = zt__contour_vertex(c, s->i);
    s->k = cross(s->a, s->x, s->y);
    for (uint32_t n = 0; s->k < 0 && n < c->count; n++) {
        s->i = s->i == 0 ? c->count - 1U : s->i - 1;
        s->a = zt__contour_vertex(c, s->i);
        s->k = cross(s->a, s->x, s->y);
    }
    s->j = s->i + 1 == c->count ? 0 : s->i + 1;
    s->b = zt__contour_vertex(c, s->j);
    s->g = -cross(s->b, s->x, s->y);
    for (uint32_t n = 0; s->g <= 0 && !at_centre && n < c->count; n++) {
        s->i = s->j;
        s->a = s->b;
        s->k = -s->g;
        s->j = s->i + 1 == c->count ? 0 : s->i + 1;
        s->b = zt__contour_vertex(c, s->j);
        s->g = -cross(s->b, s->x, s->y);
    }
    /* Exact: a flat sector's area may have 62 bits that cancel. */
    s->area = (double)((int64_t)s->a.x * s->b.y - (int64_t)s->a.y * s->b.x);
}

/* Half of a pixel across a direction, times the direction's length. */
static double reach_of(double nx, double ny, const double d[4]) {
    return (fabs(nx * d[0] + ny * d[1]) + fabs(nx * d[2] + ny * d[3])) / 2;
}

/* How far a point outside is beyond the further vertex, negative, over the reach of the edge: all in cells. */
static double beyond_tip(const zt__sector *s, double x, double y, const zt__pixel *pixel) {
    const double *m = s->placed->units;
    double det = m[0] * m[3] - m[1] * m[2];
    double ax = (m[3] * s->a.x - m[1] * s->a.y) / det, ay = (m[0] * s->a.y - m[2] * s->a.x) / det;
    double bx = (m[3] * s->b.x - m[1] * s->b.y) / det, by = (m[0] * s->b.y - m[2] * s->b.x) / det;
    double ex = bx - ax, ey = by - ay, length = sqrt(ex * ex + ey * ey);
    double a2 = ax * ax + ay * ay, b2 = bx * bx + by * by;
    return (sqrt(a2 > b2 ? a2 : b2) - sqrt(x * x + y * y)) * length / reach_of(-ey, ex, pixel->d);
}

/* Step 2: the edge's part of it times the length of the edge, in units. x, y: the point in cells. */
static double coverage_of(const zt__sector *s, double x, double y, const zt__pixel *pixel) {
    const double *m = s->placed->units;
    double ex = (double)s->b.x - (double)s->a.x, ey = (double)s->b.y - (double)s->a.y;
    double distance = ex * (s->y - (double)s->a.y) - ey * (s->x - (double)s->a.x);
    double reach = 0;
    if (pixel->reach > 0) {
        double nx = ex * m[2] - ey * m[0], ny = ex * m[3] - ey * m[1];
        reach = reach_of(nx, ny, pixel->d);
    }
    if (distance >= reach)
        return 1;
    if (!(distance > -reach))
        return 0;
    double in_reaches = distance / reach;
    if (in_reaches < 0)
        in_reaches = fmin(in_reaches, beyond_tip(s, x, y, pixel));
    return in_reaches > -1 ? (1 + in_reaches) / 2 : 0;
}

/* Section 3, but for the coverage. x, y: the point in cells. */
static void find_point(zt__sector *s, const zt_umbrella_info *info, const zt_umbrella *umbrella, const zt__placed *p,
                       const zt__bucket *buckets, double x, double y) {
    s->placed = p;
    s->contour = zt__contour_of(info, umbrella);
    s->x = p->units[0] * x + p->units[1] * y;
    s->y = p->units[2] * x + p->units[3] * y;
    enter_sector(s, buckets);
}

double zt__umbrella_coverage(const zt__umbrellas *umbrellas, const zt__umbrella_scene *scene, uint32_t umbrella,
                             double x, double y, const zt__pixel *pixel, zt__sector *sector) {
    const zt__placed *p = &scene->placed[umbrella];
    double far = p->radius * 1.000001 + pixel->reach;
    sector->coverage = 0;
    if (x * x + y * y > far * far)
        return 0;
    const zt_umbrella_info *info = &umbrellas->view;
    find_point(sector, info, &info->umbrellas[umbrella], p, scene->buckets + p->buckets, x, y);
    sector->coverage = coverage_of(sector, x, y, pixel);
    return sector->coverage;
}

void zt_umbrella_sector_at(const zt_umbrella_info *info, const zt_umbrella_level *level, const zt_umbrella *umbrella,
                           double x, double y, const double pixel[4], zt_umbrella_sector *out) {
    zt__pixel around = zt__pixel_of(pixel[0], pixel[1], pixel[2], pixel[3]);
    zt__placed placed = {.x = 0};
    zt__sector s;
    zt__umbrella_units(info, umbrella, level->bits, placed.units);
    find_point(&s, info, umbrella, &placed, NULL, x, y);
    *out = (zt_umbrella_sector){s.i, s.j, s.g / s.area, s.k / s.area, coverage_of(&s, x, y, &around)};
}

double zt__umbrella_radius(const zt__umbrellas *umbrellas, const zt__umbrella_scene *scene, uint32_t umbrella) {
    const zt__placed *p = &scene->placed[umbrella];
    const zt_umbrella *u = &umbrellas->view.umbrellas[umbrella];
    zt__contour c = zt__contour_of(&umbrellas->view, u);
    if (c.weight == 0)
        return p->radius;
    double stretch = (double)umbrellas->view.bases[u->base].aspect / 65536;
    double a = u->a, b = u->b;
    return zt__contour_radius(&c, stretch) * sqrt(a * a + b * b) / (65535.0 * 255 * 65536);
}
