/* SPDX-License-Identifier: Apache-2.0 */
/* What a sampler prepares for umbrellas: it takes as long as there are umbrellas and stored vertices, however many
 * vertices the umbrellas of a base share. */
#include <math.h>

#include "umbrella_geometry.h"

/* While a scene is made. */
typedef struct making {
    const zt__umbrellas *umbrellas;
    zt__umbrella_scene *scene;
    uint32_t used; /* of its buckets */
} making;

/* ---- buckets ---------------------------------------------------------------------------------------- */

/* The first vertex that a turn from the x axis on meets: rules 8307, 8308 and 8312 say that there is one. */
static uint32_t first_vertex(const zt__contour *c) {
    for (uint32_t i = 0; i < c->count; i++) {
        uint32_t j = i + 1 == c->count ? 0 : i + 1;
        if (zt__contour_vertex(c, i).y < 0 && zt__contour_vertex(c, j).y >= 0)
            return j;
    }
    return 0;
}

/* counts[b + 1]: how many vertices lie in bucket b or before. */
static void count_vertices(const zt__contour *c, int16_t *counts, uint32_t buckets) {
    for (uint32_t b = 0; b <= buckets; b++)
        counts[b] = 0;
    for (uint32_t i = 0; i < c->count; i++) {
        zt_umbrella_offset v = zt__contour_vertex(c, i);
        counts[1 + zt__bucket_of(v.x, v.y, buckets)]++;
    }
    for (uint32_t b = 0; b < buckets; b++)
        counts[b + 1] = (int16_t)(counts[b + 1] + counts[b]);
}

/* By how many vertices the first one of the moved contour lies behind that of the contour; before it: negative. A
 * vertex moves by less than half a turn. */
static int32_t turned_by(const zt__contour *c, uint32_t first, const zt__contour *moved) {
    uint32_t i = first_vertex(moved);
    zt_umbrella_offset from = zt__contour_vertex(c, i), to = zt__contour_vertex(moved, i);
    int32_t behind = (int32_t)(i >= first ? i - first : i + c->count - first);
    bool came_over = from.y < 0 && to.y >= 0 && (int64_t)from.x * to.y - (int64_t)from.y * to.x > 0;
    return came_over ? behind - c->count : behind;
}

/* Makes the buckets of a contour; moved: its other form, or NULL. A vertex's direction goes from the one to the other
 * without turning back, so that what holds for both holds between them. */
static uint32_t make_buckets(making *m, const zt__contour *c, const zt__contour *moved) {
    int16_t counts[ZT__MOST_BUCKETS + 1], others[ZT__MOST_BUCKETS + 1];
    uint32_t n = zt__bucket_count(c->count), at = m->used, first = first_vertex(c);
    zt__bucket *out = m->scene->buckets + at;
    int32_t turned = moved ? turned_by(c, first, moved) : 0;
    count_vertices(c, counts, n);
    count_vertices(moved ? moved : c, others, n);
    out[0] = (zt__bucket){(int16_t)first, 0};
    for (uint32_t b = 0; b < n; b++) {
        int32_t least = others[b] + turned, most = others[b + 1] + turned;
        out[1 + b].least = (int16_t)(least < counts[b] ? least : counts[b]);
        out[1 + b].most = (int16_t)(most > counts[b + 1] ? most : counts[b + 1]);
    }
    m->used += 1 + n;
    return at;
}

/* ---- placing ---------------------------------------------------------------------------------------- */

static void make_base(making *m, uint32_t index) {
    const zt_umbrella_info *info = &m->umbrellas->view;
    const zt_umbrella_base *base = &info->bases[index];
    zt__base_shape *out = &m->scene->bases[index];
    double stretch = (double)base->aspect / 65536;
    zt__contour c = {
        .texels = info->base_vertices + base->first_vertex, .centre = base->centre, .count = base->vertex_count};
    zt__contour moved = c;
    out->radius = out->morph_radius = zt__contour_radius(&c, stretch) / 65535;
    if (base->first_morph == ZT_NONE) {
        out->buckets = make_buckets(m, &c, NULL);
        return;
    }
    moved.texels = info->morph_vertices + base->first_morph;
    out->morph_radius = zt__contour_radius(&moved, stretch) / 65535;
    out->buckets = make_buckets(m, &c, &moved);
}

static void place_parametric(making *m, const zt_umbrella *u, zt__placed *out) {
    const zt__base_shape *shape = &m->scene->bases[u->base];
    double a = u->a, b = u->b, weight = zt__contour_of(&m->umbrellas->view, u).weight / 255.0;
    double radius = (1 - weight) * shape->radius + weight * shape->morph_radius;
    out->radius = radius * sqrt(a * a + b * b) / 65536;
    out->buckets = shape->buckets;
}

static void place(making *m, const zt_umbrella_level *level, uint32_t index) {
    const zt_umbrella_info *info = &m->umbrellas->view;
    const zt_umbrella *u = &info->umbrellas[index];
    zt__placed *out = &m->scene->placed[index];
    out->x = u->x / 65536.0;
    out->y = u->y / 65536.0;
    zt__umbrella_units(info, u, level->bits, out->units);
    if (u->form == ZT_UMBRELLA_PARAMETRIC) {
        place_parametric(m, u, out);
        return;
    }
    zt__contour c = zt__contour_of(info, u);
    out->radius = zt__contour_radius(&c, 1) / out->units[0];
    out->buckets = make_buckets(m, &c, NULL);
}

static void make(making *m) {
    const zt_umbrella_info *info = &m->umbrellas->view;
    for (uint32_t i = 0; i < info->base_count; i++)
        make_base(m, i);
    for (uint32_t l = 0; l < info->level_count; l++) {
        const zt_umbrella_level *level = &info->levels[l];
        for (uint32_t i = 0; i < level->umbrella_count; i++)
            place(m, level, level->first_umbrella + i);
    }
}

static uint64_t bucket_total(const zt_umbrella_info *info) {
    uint64_t total = 0;
    for (uint32_t i = 0; i < info->base_count; i++)
        total += 1 + zt__bucket_count(info->bases[i].vertex_count);
    for (uint32_t i = 0; i < info->umbrella_count; i++) {
        if (info->umbrellas[i].form != ZT_UMBRELLA_PARAMETRIC)
            total += 1 + zt__bucket_count(info->umbrellas[i].vertex_count);
    }
    return total;
}

zt_result zt__umbrella_scene_open(zt__memory *memory, const zt__umbrellas *umbrellas, zt_diag *diag,
                                  zt__umbrella_scene **out) {
    const zt_umbrella_info *info = &umbrellas->view;
    /* All counts have 32 bits, and no sum comes near 64. */
    uint64_t placed_at = zt__align16(sizeof(zt__umbrella_scene));
    uint64_t bases_at = zt__align16(placed_at + (uint64_t)info->umbrella_count * sizeof(zt__placed));
    uint64_t buckets_at = zt__align16(bases_at + (uint64_t)info->base_count * sizeof(zt__base_shape));
    uint64_t size = buckets_at + bucket_total(info) * sizeof(zt__bucket);
    void *block;
    *out = NULL;
    ZT_TRY(zt__alloc(memory, size, 1, diag, &block));
    char *base = block;
    zt__umbrella_scene *scene = block;
    scene->block_size = size;
    scene->placed = (zt__placed *)(void *)(base + placed_at);
    scene->bases = (zt__base_shape *)(void *)(base + bases_at);
    scene->buckets = (zt__bucket *)(void *)(base + buckets_at);
    making m = {umbrellas, scene, 0};
    make(&m);
    *out = scene;
    return ZT_OK;
}

void zt__umbrella_scene_close(zt__memory *memory, zt__umbrella_scene *scene) {
    if (scene)
        zt__free(memory, scene, scene->block_size, 1);
}
