/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What inspect, extract and render have to know of umbrellas (spec/umbrella.md): where each lies in the arrangement,
 * what colour it has, how high it is, and how fine a picture the whole would be.
 */
#ifndef ZTEX_ELEMENTS_H
#define ZTEX_ELEMENTS_H

#include "command.h"

enum { ELEMENTS_VERTICES = 4096 }; /* of an umbrella, the format's limit */

/* An umbrella of a level as a polygon. */
typedef struct element {
    const zt_umbrella *record;
    const zt_umbrella_base *base;             /* NULL: it has none */
    double x, y;                              /* centre, in cells of the level */
    uint32_t count;                           /* vertices */
    double points[ELEMENTS_VERTICES][2];      /* vertices less the centre, in cells */
    double picture[ELEMENTS_VERTICES + 1][2]; /* with a base: texture coordinates, the centre first */
    /* The centre first. With a base: what is added to the picture's colour, times the strength; else the colour itself.
     * Linear light. */
    float colours[ELEMENTS_VERTICES + 1][3];
    /* Of its surface, in cells of level 0; height 0: it is flat. */
    double lift, height, curvature;
    int concave;
} element;

/* Vertices of an umbrella, and of all of a level. */
uint32_t element_vertices(const zt_umbrella_info *info, const zt_umbrella *u);
uint64_t element_all_vertices(const zt_umbrella_info *info, uint32_t level);

/* Umbrella number index of a level. */
void element_of(const zt_umbrella_info *info, uint32_t level, uint32_t index, element *out);

/* Least and largest x and y of the polygon, in cells of its level. */
void element_box(const element *e, double box[4]);

/* Size of the picture that a base shows: that of its image, or of the first layer of its texture. 0, or -1: there is
 * none. */
int element_picture(const zt_file *file, const zt_umbrella_base *base, uint32_t *width, uint32_t *height);

/* The least, mean and largest resolution of level 0, in texels a cell across and down: those of the pictures of its
 * umbrellas (the paper's equation 3). 0 where no umbrella has a picture. */
typedef struct element_scale {
    double across[3], down[3]; /* least, mean, largest */
} element_scale;

void element_scale_of(const zt_file *file, const zt_umbrella_info *info, element_scale *out);

/* A stored colour offset in linear light. */
float element_offset(uint8_t stored);

/* The colour of a base's picture where it is opaque, linear light; a grey where its format is only stored. */
zt_result element_mean(const zt_file *file, const zt_umbrella_base *base, float rgb[3], zt_diag *diag);

#endif
