/* SPDX-License-Identifier: Apache-2.0 */
/* Looking up umbrellas (spec/umbrella.md sections 3 to 6). */
#ifndef ZT_UMBRELLA_SAMPLE_H
#define ZT_UMBRELLA_SAMPLE_H

#include "file_sample.h"
#include "umbrella_geometry.h"

/* A texture with where its pictures are: places in the image set for images, what to hand to `show` for textures. */
typedef struct zt__umbrella_view {
    const zt__umbrellas *umbrellas; /* NULL: empty */
    zt__umbrella_scene *scene;
    uint32_t *sources;   /* of the bases */
    uint32_t background; /* unless it is a colour */
} zt__umbrella_view;

/* A displacement towards the light, in cells of level 0, and how dark shadows are. */
typedef struct zt__umbrella_light {
    double x, y, darkness;
} zt__umbrella_light;

/* What stays the same for all parts of a lookup. */
typedef struct zt__umbrella_lookup {
    zt__sample_call *call;
    const zt__umbrella_view *view;
    const zt__show_texture *show;
    const zt__umbrella_light *light; /* NULL: no shadows */
    const uint8_t *wraps;            /* the texture's own, or clamp where another texture shows it */
    uint32_t array_layer;            /* for the textures that are shown */
} zt__umbrella_lookup;

/* The umbrellas that may cast a shadow on a point, met from the highest to the lowest. */
typedef struct zt__umbrella_shade {
    const uint32_t *list;
    uint32_t left;
    double x, y; /* towards the light */
    zt__pixel pixel;
    double light; /* what comes through */
} zt__umbrella_shade;

/* Section 4, step 5, at (x, y) of a level, in cells, inside of the grid. */
zt__umbrella_shade zt__umbrella_shade_of(const zt__umbrella_lookup *lookup, const zt_umbrella_level *level, double x,
                                         double y, const zt__pixel *pixel);

/* S at an entry of the list, or at the background. Entries are asked for from the highest on. */
double zt__umbrella_light_at(const zt__umbrella_lookup *lookup, const zt_umbrella_level *level,
                             zt__umbrella_shade *shade, uint32_t entry);
double zt__umbrella_light_below(const zt__umbrella_lookup *lookup, const zt_umbrella_level *level,
                                zt__umbrella_shade *shade);

/* Section 3, steps 4 and 5, without the coverage. pixel: for the picture. */
zt_result zt__umbrella_colour(const zt__umbrella_lookup *lookup, uint32_t umbrella, const zt__sector *sector,
                              const zt__pixel *pixel, double rgba[4]);

/* Section 4, step 4. */
zt_result zt__umbrella_background(const zt__umbrella_lookup *lookup, const zt_point *point, float rgba[4]);

/* How the grid is shifted for an entry, in cells. */
static inline double zt__umbrella_shift_x(const zt_umbrella_level *level, uint32_t entry) {
    return ((double)((entry >> ZT_UMBRELLA_SHIFT) % 3) - 1) * level->width;
}

static inline double zt__umbrella_shift_y(const zt_umbrella_level *level, uint32_t entry) {
    return ((double)((entry >> ZT_UMBRELLA_SHIFT) / 3) - 1) * level->height;
}

/* The list of a cell; returns its length. */
static inline uint32_t zt__umbrella_list(const zt_umbrella_info *info, const zt_umbrella_level *level, uint32_t x,
                                         uint32_t y, const uint32_t **out) {
    size_t cell = level->first_cell + (size_t)y * level->width + x;
    *out = info->entries + info->list_starts[cell];
    return info->list_starts[cell + 1] - info->list_starts[cell];
}

/* The coverage at (x, y), in cells, of an entry. */
static inline double zt__umbrella_entry(const zt__umbrella_view *view, const zt_umbrella_level *level, uint32_t entry,
                                        double x, double y, const zt__pixel *pixel, zt__sector *sector) {
    uint32_t umbrella = level->first_umbrella + (entry & ZT_UMBRELLA_ENTRY);
    const zt__placed *p = &view->scene->placed[umbrella];
    return zt__umbrella_coverage(view->umbrellas, view->scene, umbrella, x - p->x - zt__umbrella_shift_x(level, entry),
                                 y - p->y - zt__umbrella_shift_y(level, entry), pixel, sector);
}

/* The lookup in 2-D. */
zt_result zt__sample_umbrellas(const zt__umbrella_lookup *lookup, const zt_point *point, float rgba[4]);

/* What a ray that hits nothing gives. */
extern const zt_hit zt__umbrella_miss;

/* The lookup in 3-D; all numbers of the ray are finite, and the filter is trilinear. */
zt_result zt__sample_umbrella_ray(const zt__umbrella_lookup *lookup, const zt_ray *ray, zt_hit *out);

#endif
