/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Umbrella textures (Wang, Shi, Chen, Popescu, Computer Graphics Forum 2013; spec/umbrella.md): outlines of elements
 * out of their pictures, colour variants out of pictures of similar elements, arrangements of many copies, the exact
 * lists of the cells, and the coarser levels, whose colours are fitted to what the finest one shows.
 *
 * What ends in a file comes out of integers and of + - * / and square roots of doubles alone, so that it is the same on
 * every machine.
 */
#ifndef ZTEX_AUTHOR_UMBRELLA_H
#define ZTEX_AUTHOR_UMBRELLA_H

#include "author.h"

#ifdef __cplusplus
extern "C" {
#endif

#define AUTHOR_VERTICES 4096 /* of an umbrella, the format's limit */

/* ---- outlines --------------------------------------------------------------------------------------------- */

typedef struct author_xy {
    double x, y;
} author_xy;

/* A closed polygon, clockwise as one sees it (x right, y down). */
typedef struct author_outline {
    author_xy *points;
    size_t count;
} author_outline;

void author_outline_release(author_outline *outline);

/* The outline of the largest region of a one-channel picture where the value is at least threshold, in texels, (0, 0)
 * being the outer corner of the first one; along the picture's edge it runs there. To a part of a texel. Errors:
 * AUTHOR_BAD_INPUT when there is no such region. */
author_result author_umbrella_trace(author_run *run, const author_picture *coverage, double threshold,
                                    author_outline *out);

/* Coverage by colour: 0 where the picture is like key (linear light), 1 where it differs by tolerance and more (of
 * sRGB-coded values, the channel that differs most), for pictures of 3 channels and more. key NULL: the median of the
 * picture's border. */
author_result author_umbrella_key(author_run *run, const author_picture *picture, const float *key, double tolerance,
                                  author_picture *coverage);

/* At most `most` vertices (3 at least), none of the area being lost: reflex vertices are dropped, and sides between two
 * others are replaced by the point where their neighbours meet, those first that add the least area. Errors:
 * AUTHOR_BAD_INPUT when it gets stuck. */
author_result author_umbrella_simplify(author_run *run, author_outline *outline, size_t most);

double author_outline_area(const author_outline *outline); /* positive for clockwise ones */
author_xy author_outline_centroid(const author_outline *outline);
/* The point from which every side is seen, and which is farthest from the lines of all sides: returns that distance, or
 * -1 when there is none. scale: the length that counts as 1, such as the diameter. */
double author_outline_kernel(const author_outline *outline, author_xy *centre);
/* The first vertex i for which centre, vertex i, vertex i + 1 have no positive area; count when there is none and the
 * outline goes around once. */
size_t author_outline_bad_vertex(const author_outline *outline, author_xy centre);
/* The smallest star-shaped polygon about the centre that has all of the outline in it (but for a hair). Errors:
 * AUTHOR_BAD_INPUT if the centre is too far outside for one. */
author_result author_outline_repair(author_run *run, author_outline *outline, author_xy centre);

/* ---- bases ------------------------------------------------------------------------------------------------ */

typedef enum author_centre {
    AUTHOR_CENTRE_KERNEL = 0,
    AUTHOR_CENTRE_CENTROID = 1,
    AUTHOR_CENTRE_GIVEN = 2
} author_centre;

/* One colour variant: out of a picture, or of one or two tints. */
typedef struct author_variant {
    const author_picture
        *picture;            /* a similar element on a clear ground, cut out by its alpha or the base's key; or NULL */
    int offsets;             /* 1: centre and rim are offsets themselves, not colours that are aimed at */
    float centre[3], rim[3]; /* linear light */
    double spread;           /* random, for each vertex: 0 to 1 */
} author_variant;

typedef struct author_base_input {
    const author_picture *picture; /* NULL: the base shows a texture, and outline is given */
    uint32_t width, height;        /* texels of the texture, where picture is NULL: its aspect */
    const author_outline *outline; /* in texels; NULL: traced. Simplified, too, unless there is a morph */
    const author_outline *morph;   /* in texels, as many vertices as outline; NULL: none, or generated */
    double morph_amount;           /* 0: none is generated; else how far vertices move, in distances from the centre */
    int keyed;                     /* 1: by colour; 0: by alpha */
    const float *key;              /* linear light; NULL: that of the border */
    double tolerance;              /* of keyed; 0: 0.1 */
    double threshold;              /* of coverage; 0: 0.1 */
    uint32_t most_vertices;        /* 0: 48 */
    author_centre centre_kind;
    author_xy centre; /* in texels */
    int repair;       /* 1: what is not star-shaped becomes so */
    uint32_t texels;  /* the picture is reduced to at most so many along its longer side; 0: 256 */
    const author_variant *variants;
    uint32_t variant_count; /* at most 255 */
    uint64_t seed, stream;  /* of the morph and of spread */
} author_base_input;

typedef struct author_base {
    author_picture picture;       /* cut out, 4 channels; colours go on where alpha is 0. Empty for a texture */
    zt_umbrella_base record;      /* but source, ellipsoid, height and curvature */
    zt_umbrella_texel *vertices;  /* record.vertex_count */
    zt_umbrella_texel *morph;     /* as many, or NULL */
    zt_umbrella_colour *colours;  /* record.variant_count x (1 + vertex_count) */
    double box_width, box_height; /* of the outline, in widths of the picture */
    double radius;                /* largest distance of a vertex or its second position from the centre, likewise */
    double clearance;             /* smallest distance of a side's line from the centre, likewise */
    float mean[3];                /* colour where it is opaque, linear light */
} author_base;

/* Outline, centre, cut-out, morph and variants, in the file's integers, by which the star shape is checked again (rules
 * 8307 and 8308). Errors: AUTHOR_BAD_INPUT, naming the first bad vertex; AUTHOR_NO_MEMORY. */
author_result author_umbrella_base(author_run *run, const author_base_input *input, author_base *out);
void author_base_release(author_base *base);

/* ---- arrangement ------------------------------------------------------------------------------------------ */

typedef struct author_range {
    double low, high;
} author_range;

/* How copies of a base vary. Chance is even within each range. */
typedef struct author_species {
    uint32_t base;
    double weight;         /* how often, compared with the others */
    author_range size;     /* cells: the longer side of the outline's box */
    author_range rotation; /* turns, clockwise */
    author_range morph;    /* 0 to 1; ignored without a morph */
    author_range strength; /* f of the colour offsets, 0 to 1 */
    double mirrored;       /* share of mirrored ones */
    zt_umbrella_ellipsoid ellipsoid;
    author_range height;    /* in radii of the umbrella (largest distance of a vertex) */
    author_range curvature; /* above 0, up to 1 */
    author_range lift;      /* cells */
} author_species;

typedef enum author_method {
    AUTHOR_POISSON = 0, /* no two closer than can be, at this density */
    AUTHOR_JITTERED = 1,
    AUTHOR_TILING = 2,
    AUTHOR_PLACES = 3
} author_method;

typedef enum author_order { AUTHOR_ORDER_RANDOM = 0, AUTHOR_ORDER_SIZE = 1, AUTHOR_ORDER_GIVEN = 2 } author_order;

/* A given place; values that are not finite are drawn by chance. */
typedef struct author_place {
    uint32_t species;
    double x, y;                        /* cells */
    double size, rotation, morph, lift; /* NaN: by chance */
    double height;                      /* in radii */
    int variant;                        /* -1: two by chance and mixed; else this one alone */
    int mirrored;                       /* 0, 1; -1: by chance */
} author_place;

typedef struct author_arrangement {
    uint32_t grid_x, grid_y;
    int repeat_x, repeat_y;
    author_method method;
    author_order order;
    double density;             /* umbrellas for each cell, AUTHOR_POISSON and AUTHOR_JITTERED */
    double jitter;              /* AUTHOR_JITTERED: 0 to 1, of the lattice's step; 1 by default */
    uint32_t columns, rows;     /* AUTHOR_TILING */
    double row_shift;           /* AUTHOR_TILING: of every second row, in columns */
    const author_place *places; /* AUTHOR_PLACES */
    size_t place_count;
    const author_species *species;
    uint32_t species_count;
    int is_explicit;      /* 1: every umbrella of form 1 */
    double vertex_jitter; /* of explicit ones: how far vertices move, in their distance from the centre */
    double colour_jitter; /* and how much each vertex's colour offset varies: 0 to 1 */
    double prism_height;  /* cells; 0: the least that holds all */
    uint64_t seed;
} author_arrangement;

/* All arrays of an umbrella texture; info points to them. Sources of bases and of the background are the caller's to
 * set, and so is background itself. */
typedef struct author_umbrellas {
    zt_umbrella_info info;
    zt_umbrella_level *levels;
    zt_umbrella_base *bases;
    zt_umbrella_texel *base_vertices, *morph_vertices;
    zt_umbrella_colour *variant_colours;
    zt_umbrella *umbrellas;
    zt_umbrella_offset *explicit_vertices;
    zt_umbrella_colour *explicit_colours;
    uint32_t *list_starts, *entries;
} author_umbrellas;

/* Level 0 with its lists. Errors: AUTHOR_BAD_INPUT; AUTHOR_NO_MEMORY. */
author_result author_umbrella_arrange(author_run *run, const author_base *bases, uint32_t base_count,
                                      const author_arrangement *how, author_umbrellas *out);
void author_umbrellas_release(author_umbrellas *umbrellas);

/* A picture averaged over the areas of fewer texels, which need not divide it. */
author_result author_umbrella_average(author_run *run, const author_picture *picture, uint32_t width, uint32_t height,
                                      author_picture *out);

/* ---- coarser levels --------------------------------------------------------------------------------------- */

typedef struct author_level_report {
    uint32_t width, height, umbrellas, longest, vertices;
    double psnr,
        linear_psnr; /* of what the file will show in the middles of pixels: premultiplied, sRGB-coded and linear */
    double between_psnr, between_linear_psnr; /* at other phases */
    double mipmap_psnr;                       /* there, sRGB-coded, of a mipmap with the same pixels */
    double alpha_psnr;                        /* at all of these places */
} author_level_report;

/* Squared errors, sRGB-coded and linear. */
typedef struct author_error {
    double coded, linear;
    size_t count;
} author_error;

/* Colours in the middles of pixels, and of pixels at other phases; alpha of all. */
typedef struct author_phase_errors {
    author_error pixels, between, alpha;
} author_phase_errors;

/* What pixels show at several phases: out has width x 2 height texels, 2 x 4 for each pixel. Texel (x, y) is the mean
 * of the picture over the pixel around the point (x / width, y / height) of the unit square, in the lower half ((x +
 * 1/2) / width, (y + 1/2) / height) with y from there; so the middles of pixels are the texels of the upper half that
 * are odd in x and y. */
author_result author_umbrella_phases(author_run *run, const author_picture *picture, uint32_t width, uint32_t height,
                                     const int repeat[2], author_picture *out);
void author_umbrella_compare(const author_picture *shown, const author_picture *wanted, author_phase_errors *errors);
/* As if what is shown were a texture of the pixels, looked up bilinearly. */
void author_umbrella_bilinear(const author_picture *wanted, const int repeat[2], author_phase_errors *errors);
/* The figures of a report. mipmap: those of the function before. */
void author_umbrella_figures(const author_phase_errors *errors, const author_phase_errors *mipmap,
                             author_level_report *report);

typedef struct author_levels {
    int repeat_x, repeat_y;
    /* Premultiplied linear light, 4 channels: what level 0 shows, averaged over 32 x 32 pixels for each cell of level 1
     * (without it over any). */
    const author_picture *truth;
    /* What the background shows at the phases, 16 x (2 x 16) for each cell; of levels 1 to level_count - 1. */
    const author_picture *background;
    uint32_t level_count; /* with level 0 */
    uint32_t longest; /* of a cell's list; 0: that of level 0, at least 8, and up to 49 where the quality needs it */
    uint32_t most_vertices; /* 0: 12 */
    double quality; /* dB that will do at all phases; 0: 31, and between pixels as good as a mipmap, but at most 40 */
    uint32_t bits;  /* of vertices, in a cell; 0: 6 */
    uint64_t seed;
} author_levels;

/* Adds levels 1 to level_count - 1 behind level 0, and sets mean. reports: level_count - 1 of them, or NULL. */
author_result author_umbrella_levels(author_run *run, author_umbrellas *umbrellas, const author_levels *how,
                                     author_level_report *reports);

#ifdef __cplusplus
}
#endif

#endif
