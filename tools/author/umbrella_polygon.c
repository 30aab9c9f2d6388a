/* SPDX-License-Identifier: Apache-2.0 */
/* Umbrellas of any form as polygons in cells of their level. */
#include <math.h>
#include <stdlib.h>

#include "umbrella_private.h"

static int64_t cross_of(zt_umbrella_offset a, zt_umbrella_offset b) {
    return (int64_t)a.x * b.y - (int64_t)a.y * b.x;
}

size_t umb_bad_offset(const zt_umbrella_offset *d, size_t count) {
    size_t turns = 0, last = 0;
    for (size_t i = 0; i < count; i++) {
        size_t j = i + 1 < count ? i + 1 : 0;
        if (cross_of(d[i], d[j]) <= 0)
            return i;
        if (d[i].y < 0 && d[j].y >= 0) {
            turns++;
            last = i;
        }
    }
    return turns == 1 ? count : last;
}

/* Of a base, in widths of its picture. */
static author_xy base_point(const zt_umbrella_base *base, zt_umbrella_texel p) {
    double x = ((double)p.x - base->centre.x) / 65535, y = ((double)p.y - base->centre.y) / 65535;
    return (author_xy){x, y * base->aspect / 65536};
}

static size_t parametric(const zt_umbrella_info *info, const zt_umbrella *u, author_xy *out) {
    const zt_umbrella_base *base = &info->bases[u->base];
    const zt_umbrella_texel *vertices = info->base_vertices + base->first_vertex;
    size_t count = base->vertex_count;
    double a = u->a / 65536.0, b = u->b / 65536.0;
    for (size_t i = 0; i < count; i++) {
        author_xy q = base_point(base, vertices[i]);
        if (base->first_morph != ZT_NONE)
            q = umb_mix(q, base_point(base, info->morph_vertices[base->first_morph + i]), u->morph / 255.0);
        if (u->mirrored)
            q.x = -q.x;
        /* Mirroring turns the way round; so the last comes first. */
        out[u->mirrored ? count - 1 - i : i] = (author_xy){a * q.x - b * q.y, b * q.x + a * q.y};
    }
    return count;
}

size_t umb_polygon(const zt_umbrella_info *info, const zt_umbrella *umbrella, uint32_t bits, author_xy *out) {
    if (umbrella->form == ZT_UMBRELLA_PARAMETRIC)
        return parametric(info, umbrella, out);
    const zt_umbrella_offset *d = info->explicit_vertices + umbrella->first_vertex;
    double scale = 1.0 / (double)(UINT32_C(1) << bits);
    for (size_t i = 0; i < umbrella->vertex_count; i++)
        out[i] = (author_xy){d[i].x * scale, d[i].y * scale};
    return umbrella->vertex_count;
}

double umb_radius(const author_xy *polygon, size_t count) {
    double most = 0;
    for (size_t i = 0; i < count; i++)
        most = fmax(most, polygon[i].x * polygon[i].x + polygon[i].y * polygon[i].y);
    return sqrt(most);
}

int umb_covers(const author_xy *polygon, size_t count, author_xy p) {
    for (size_t i = 0; i < count; i++) {
        author_xy a = polygon[i], b = polygon[i + 1 < count ? i + 1 : 0];
        if (umb_cross(a, p) >= 0 && umb_cross(b, p) < 0)
            return umb_cross(umb_less(b, a), umb_less(p, a)) >= 0;
    }
    return p.x == 0 && p.y == 0;
}
