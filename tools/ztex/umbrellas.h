/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Umbrella textures in `ztex make`: the member "umbrellas" of a texture (scene_umbrellas.c, scene_bases.c) becomes
 * bases out of pictures (umbrellas_bases.c), an arrangement, coarser levels fitted to what the finest one shows
 * (umbrellas_truth.c), and chunks (umbrellas_store.c). umbrellas_report.c tells how good the levels are.
 */
#ifndef ZTEX_UMBRELLAS_H
#define ZTEX_UMBRELLAS_H

#include <author_umbrella.h>

#include "make.h"

#define UMBRELLAS_NOMINAL 64 /* texels that a cell counts for where a patch is placed by texels */
#define UMBRELLAS_PIXELS 8   /* along each side of a cell, where a level alone is looked up */
#define UMBRELLAS_PHASES 16  /* along each side of a cell: texels of author_umbrella_phases */
#define UMBRELLAS_FINE 32    /* along each side of a cell of level 1: what they are averages of */
#define UMBRELLAS_LEVELS 14  /* most that a grid of 8192 cells has */

typedef struct make_variant {
    const make_image *image; /* NULL: a tint */
    author_variant variant;  /* but its picture */
} make_variant;

/* An outline of a base: drawn, or a list; else found in the picture. */
typedef struct make_outline {
    const char *drawing; /* SVG; NULL: points */
    author_xy *points;   /* of the unit square of the picture */
    size_t count;
} make_outline;

typedef struct make_umbrella_base {
    const char *name;
    const make_image *image; /* NULL: texture */
    uint32_t texture;        /* an earlier texture of the scene */
    make_outline outline, morph;
    author_base_input input; /* but what comes out of files; the centre is of the unit square */
    float key[3];            /* of input */
    make_variant *variants;
    author_species species;
    const char *pointer;
} make_umbrella_base;

/* What was made, for the report. */
typedef struct umbrellas_made {
    const char *name;
    uint32_t grid_x, grid_y, bases, umbrellas, vertices, longest, entries;
    uint32_t level_count;
    int repeat[2];
    author_level_report levels[UMBRELLAS_LEVELS];
    author_picture truth; /* of level 1: 32 x 32 pixels a cell, premultiplied linear light */
} umbrellas_made;

struct make_umbrellas {
    uint64_t seed;
    zt_umbrella_colour_mode colour_mode;
    zt_background_kind background_kind;
    float background[4]; /* premultiplied linear light */
    const make_image *background_image;
    uint32_t background_texture;
    make_umbrella_base *bases;
    uint32_t base_count;
    author_arrangement arrangement;
    double taper[2];
    uint32_t level_count; /* 0: all */
    author_levels levels;
    umbrellas_made *made; /* gets what was made; NULL: nobody asks */
};

/* umbrellas_bases.c: all bases of a texture; *out has base_count of them, malloc'd. sizes: of all textures of the
 * scene. */
int umbrellas_make_bases(make_store *store, const make_texture *texture, const make_size *sizes, author_run *run,
                         author_base **out);

/* umbrellas_truth.c: what a file in memory shows. */
typedef struct umbrellas_view {
    uint32_t width, height; /* pixels on the unit square */
    uint32_t samples;       /* samples x samples places in each are averaged */
    const double *step;     /* the derivatives of u and v along x and y, or NULL */
    int phases;             /* one sample at each texel of author_umbrella_phases instead */
} umbrellas_view;
/* Premultiplied linear light, 4 channels. */
int umbrellas_look(author_run *run, const zt_file *file, uint32_t texture, const umbrellas_view *view,
                   author_picture *out);
/* Steps of a pixel that shows this level alone, an eighth of what its cell would be if every grid were halved
 * exactly. */
void umbrellas_step(uint32_t grid_x, uint32_t grid_y, uint32_t level, double step[2]);

/* umbrellas_store.c: the texture into the writer. */
/* sizes gets its own. */
int make_store_umbrellas(make_store *store, const make_texture *texture, make_size *sizes);
void umbrellas_made_release(umbrellas_made *made);

/* umbrellas_report.c: how good the levels of the file are that was written, into made. */
int umbrellas_measure(cmd_args *args, umbrellas_made *made, const char *output);
/* As .json or as a page. */
int umbrellas_write_report(cmd_args *args, umbrellas_made *made, const char *output, const char *path);
/* The same figures on standard output. */
int umbrellas_print(const umbrellas_made *made, const char *output);

#endif
