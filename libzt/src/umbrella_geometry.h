/* SPDX-License-Identifier: Apache-2.0 */
/* Where a point lies in an umbrella (spec/umbrella.md section 3, steps 1 to 3), and what a sampler prepares for
 * that. */
#ifndef ZT_UMBRELLA_GEOMETRY_H
#define ZT_UMBRELLA_GEOMETRY_H

#include "umbrella_payload.h"

/* The directions from a centre are cut into buckets. For directions in one: how many vertices, counted from a first
 * one, come before them at least and at most, whatever the weight of the morph. */
typedef struct zt__bucket {
    int16_t least, most;
} zt__bucket;

/* An umbrella, ready for lookups. Its vertices are integers in units of their own: forms 1 and 2 as they are stored;
 * form 0 in 1/65535 of the picture, with a morph in 1/255 of that. */
typedef struct zt__placed {
    double x, y;      /* centre, in cells of its level */
    double units[4];  /* from cells to units: rows (0, 1) and (2, 3) */
    double radius;    /* no vertex is further, in cells; with a morph a bound, else exact. Coverage ends a pixel's reach
                         behind it */
    uint32_t buckets; /* in zt__umbrella_scene.buckets: the first vertex as `least`, then the buckets */
} zt__placed;

/* What the umbrellas of a base have in common. Lengths are in widths of the picture. */
typedef struct zt__base_shape {
    double radius, morph_radius; /* largest distance of a vertex, and of a second position */
    uint32_t buckets;
} zt__base_shape;

/* Prepared when a sampler opens; never changes. */
typedef struct zt__umbrella_scene {
    uint64_t block_size;
    zt__placed *placed;    /* umbrella_count */
    zt__base_shape *bases; /* base_count */
    zt__bucket *buckets;
} zt__umbrella_scene;

zt_result zt__umbrella_scene_open(zt__memory *memory, const zt__umbrellas *umbrellas, zt_diag *diag,
                                  zt__umbrella_scene **out);
void zt__umbrella_scene_close(zt__memory *memory, zt__umbrella_scene *scene); /* NULL is allowed */

/* The contour of an umbrella, as it is stored. */
typedef struct zt__contour {
    const zt_umbrella_offset *offsets;       /* forms 1 and 2; else NULL */
    const zt_umbrella_texel *texels, *moved; /* form 0; moved: second positions, used if weight is not 0 */
    zt_umbrella_texel centre;
    uint16_t count;
    uint8_t weight;
} zt__contour;

/* One sector of a contour with a point in it. */
typedef struct zt__sector {
    const zt__placed *placed;
    zt__contour contour;
    uint32_t i, j;        /* its vertices */
    zt_umbrella_offset a; /* where they are, in units */
    zt_umbrella_offset b;
    double x, y;     /* the point, in units */
    double area;     /* cross(a, b) */
    double g, k;     /* barycentric coordinates for i and j, times area */
    double coverage; /* 0: the fields above may be left out */
} zt__sector;

/* A pixel around a point: its derivatives in cells, in the order x and y of that for one step in x, then for one in
 * y. */
typedef struct zt__pixel {
    double d[4];
    double reach; /* no line has a larger one */
} zt__pixel;

zt__pixel zt__pixel_of(double xx, double yx, double xy, double yy);

zt__contour zt__contour_of(const zt_umbrella_info *info, const zt_umbrella *umbrella);
zt_umbrella_offset zt__contour_vertex(const zt__contour *contour, uint32_t i);
/* The largest distance of a vertex, in units of x; y is stretched. */
double zt__contour_radius(const zt__contour *contour, double stretch);

enum { ZT__MOST_BUCKETS = 32 };

/* How many buckets the directions of so many vertices are cut into, a power of two, and the bucket of a direction. */
uint32_t zt__bucket_count(uint32_t vertices);
uint32_t zt__bucket_of(double x, double y, uint32_t count);

/* From cells to units, as in zt__placed. bits: those of its level. */
void zt__umbrella_units(const zt_umbrella_info *info, const zt_umbrella *umbrella, uint32_t bits, double units[4]);

/* x, y: the point less the centre, in cells. umbrella: among all levels. Sets *sector, and returns its coverage. */
double zt__umbrella_coverage(const zt__umbrellas *umbrellas, const zt__umbrella_scene *scene, uint32_t umbrella,
                             double x, double y, const zt__pixel *pixel, zt__sector *sector);

/* The umbrella's largest distance of a vertex from the centre, in cells, exactly. */
double zt__umbrella_radius(const zt__umbrellas *umbrellas, const zt__umbrella_scene *scene, uint32_t umbrella);

#endif
