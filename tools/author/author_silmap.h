/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Silmaps out of drawings and pictures (Sen, Graphics Hardware 2004; spec/silmap.md): labels say which region each
 * place of a drawing belongs to, the fit chooses points and cuts that hold the regions apart, and the samples get the
 * colours of their own regions. Analysis by synthesis: what is compared with the original is the silmap as it will be
 * looked up.
 */
#ifndef ZTEX_AUTHOR_SILMAP_H
#define ZTEX_AUTHOR_SILMAP_H

#include "author.h"

#ifdef __cplusplus
extern "C" {
#endif

/* A closed polygon or an open chain of straight segments, in coordinates of the unit square (0,0 top left). Curves have
 * been flattened to an error that is far below a cell. */
typedef struct author_path {
    const double *points; /* x, y */
    size_t count;
    int closed;
} author_path;

/* A colour inside of closed paths, painted over what is there already. */
typedef struct author_silmap_shape {
    size_t first, count; /* of author_silmap_input.paths */
    int even_odd;        /* inside is where the paths wind an odd number of times; 0: where they wind at all */
    uint32_t within;     /* 1 + the number of a shape before it, outside of which nothing of it is seen; 0: none */
    int bounds;          /* it is not painted: others are within it */
    float colour[4];     /* a texel of the picture, but for its alpha */
    float opacity;       /* 0 to 1; colours mix as displayed, as drawing programs do it */
} author_silmap_shape;

/* What a silmap is made of. The picture is wanted always; the rest adds what is known beyond it. */
typedef struct author_silmap_input {
    /* The original at a resolution well above the cells (8 to 16 texels a cell is good): colours in linear light, alpha
     * straight. Values that are no colours: as they are. */
    const author_picture *picture;
    /* Region of each texel of the picture, or NULL: found in the picture (edges to sub-pixel, hysteresis, chains).
     * Labels of flat art are exact; they are any numbers. */
    const uint32_t *labels;
    /* Edges that an artist or a vector drawing gives: where there are paths the cuts follow them, and nothing else is
     * cut if paths_only (nothing at all if there are none). Exact: no resampling. */
    const author_path *paths;
    size_t path_count;
    int paths_only;
    /* A flat drawing: all paths belong to these shapes, the first is the lowest. Nothing below them is 0 in all
     * channels. Regions are what has one colour, with exact borders; the picture should be that of author_silmap_draw.
     * Labels and paths_only are not looked at. */
    const author_silmap_shape *shapes;
    size_t shape_count;
    int repeat_x, repeat_y; /* the texture repeats: its sides meet */
} author_silmap_input;

typedef struct author_silmap_options {
    uint32_t cells_x,
        cells_y;    /* required unless quality is given; then the largest that may be tried, 0: half of the picture */
    double quality; /* dB; not 0: the smallest grid that reaches it */
    zt_silmap_filter filter;
    double edge_low,
        edge_high; /* hysteresis on the gradient of the picture, in units of the full range; 0: chosen by the picture */
    int no_least_squares; /* 1: samples are the means of their deformed cells alone */
    int plain;            /* 1: the values are no colours: errors are measured on them as they are, not sRGB-coded */
} author_silmap_options;

/* Why a cell could not be held. */
typedef enum author_silmap_defect {
    AUTHOR_SILMAP_THIN = 1,    /* a feature thinner than a cell: a side is crossed an even number of times */
    AUTHOR_SILMAP_JUNCTION = 2 /* more regions meet in the cell than its four corners tell apart */
} author_silmap_defect;

typedef struct author_silmap_result {
    uint32_t cells_x, cells_y;
    uint8_t *cells; /* spec/silmap.md section 2 */
    author_picture
        samples; /* (cells_x + 1) x (cells_y + 1), one less in a repeating direction; channels of the picture */
    author_picture minified; /* cells_x x cells_y */
    /* dB against all texels of the picture: the mean over each texel's box, of 25 places where a line passes through it
     * (the fit has 16 others), of colours as displayed (sRGB-coded, premultiplied). */
    double psnr;
    double bilinear_psnr; /* of a bilinear texture of the same grid, its texels the best by least squares */
    double box_psnr;      /* of one whose texels are means over boxes, as they are made usually */
    /* Share of the area that shows another region than the original, at 37 x 37 places of each cell that the fit has
     * not seen; 0 where no regions are known. */
    double disagreement;
    uint64_t cut_cells, thin_cells, junction_cells;
    float *error;     /* cells_x x cells_y: root mean square error of each cell */
    uint8_t *defects; /* cells_x x cells_y: author_silmap_defect bits */
} author_silmap_result;

/* The picture of input's shapes: each texel is the exact mean over its box, of colours as displayed. picture: created;
 * its channels say which; input's own is not looked at. plain: as in the options. Errors: AUTHOR_BAD_INPUT,
 * AUTHOR_NO_MEMORY, AUTHOR_CANCELLED. */
author_result author_silmap_draw(author_run *run, const author_silmap_input *input, int plain, author_picture *picture);

/* Edges are those of shapes, or of closed paths; without such, those of the labels; without these, those of the regions
 * if the picture is flat art; else chains of maxima of its gradient, and open paths, which hold only where they make
 * the picture better. Paths and labels are taken as they are. psnr is never below bilinear_psnr, unless
 * no_least_squares: where cuts do not pay, there are none. Errors: AUTHOR_BAD_INPUT, also if the quality is not
 * reached; AUTHOR_NO_MEMORY, AUTHOR_CANCELLED. */
author_result author_silmap_fit(author_run *run, const author_silmap_input *input, const author_silmap_options *options,
                                author_silmap_result *out);
void author_silmap_release(author_silmap_result *result);

/* Where the picture's unit square lies in that of the texture. */
typedef struct author_silmap_place {
    double x, y, width, height;
} author_silmap_place;

/* Hinting: where a drawing best lies, so that most of the length of its edges along the axes is where points can stand;
 * with paths or shapes, where the least area is wrong, of some places that are tried. input: the drawing as it fills
 * the texture, as for the fit; to be drawn again at *out. Each side goes out by up to half a cell and none comes in: no
 * place moves by more than that, and what is beyond the texture's sides is cut off. It stays as it is where little
 * would be won. Thin features may fare worse there: fit both, and keep what author_silmap_is_better says. */
author_result author_silmap_hint(author_run *run, const author_silmap_input *input, uint32_t cells_x, uint32_t cells_y,
                                 int plain, author_silmap_place *out);
/* Whether a drawing that lies at place was moved at all. */
int author_silmap_is_moved(const author_silmap_place *place);
/* Whether a fit shows its original better than another one of the same original, in the same cells: of one channel
 * whose regions are known by the disagreement, else, and where that is equal, by the PSNR. */
int author_silmap_is_better(const author_silmap_result *fit, const author_silmap_result *other);

#ifdef __cplusplus
}
#endif

#endif
