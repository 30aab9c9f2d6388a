/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Silmaps in `ztex make`: a drawing, a picture or glyphs (silmap_source.c) are fitted by the authoring library and
 * stored with their other layers (silmap_store.c); silmap_report.c tells what could not be held. A silmap comes from a
 * scene (scene_silmap.c) or from the command line (verb_make_silmap.c).
 */
#ifndef ZTEX_SILMAP_H
#define ZTEX_SILMAP_H

#include <author_silmap.h>

#include "make.h"

#define SILMAP_CELLS 64                       /* along the longer side, when nobody says */
#define SILMAP_CELLS_MOST (UINT32_C(1) << 20) /* the format's limit along a side */

#define SILMAP_REASON 256

typedef enum silmap_mask {
    SILMAP_COLOURS = 0,
    SILMAP_ALPHA = 1,     /* one channel, the alpha */
    SILMAP_BRIGHTNESS = 2 /* one channel, the brightness as it is coded, times alpha */
} silmap_mask;

/* Hinting: what a fit gives where the input was drawn, [0], and at the hinted place, [1]. */
typedef struct silmap_trial {
    int wanted, moved, kept; /* asked for; another place was found; and it was the better one */
    double psnr[2], disagreement[2];
} silmap_trial;

/* What was fitted, for the report. */
typedef struct silmap_made {
    author_silmap_result result;
    uint32_t width, height; /* of the picture that it was fitted to */
    author_silmap_place place;
    silmap_trial trial;
    int exact;                    /* edges are those of paths */
    char not_flat[SILMAP_REASON]; /* why a drawing's are not; empty: it is no drawing */
} silmap_made;

/* How a texture of kind silmap is made. Its pictures are the texture's images; the first is fitted, and of glyphs it is
 * the font. Images of several files are frames of an animation, as many in each layer, or one. */
struct make_silmap {
    const char *text;  /* UTF-8; NULL: no glyphs */
    const char *edges; /* SVG with an artist's edges, or NULL */
    int edges_only;
    int hint;                  /* a drawing or glyphs may lie where it suits the cells, if they do look better there */
    uint32_t cells_x, cells_y; /* 0 and 0: by the longer side */
    uint32_t longer;           /* cells along the longer side; 0: SILMAP_CELLS, or what quality needs */
    double quality;            /* dB; 0: none */
    zt_silmap_filter filter;
    silmap_mask mask;
    int no_minified;
    silmap_made *made; /* gets what was fitted; NULL: nobody asks */
};

/* "96" or "96x64", each up to SILMAP_CELLS_MOST. 0, or -1. */
int silmap_parse_cells(const char *text, make_silmap *silmap);

/* silmap_source.c: what a picture is fitted to. */
typedef struct silmap_source {
    author_picture picture;
    author_path *paths;
    size_t path_count;
    double *points;
    author_silmap_shape *shapes; /* all paths belong to them */
    size_t shape_count;
    char not_flat[SILMAP_REASON]; /* why a drawing has none; else empty */
    author_silmap_place place;    /* of the page; of glyphs that of what they are without hinting */
    int plain;                    /* values, no colours */
    img_type type;                /* of the original */
    uint32_t cells_x, cells_y;    /* 0 with quality: as many as it needs */
} silmap_source;

/* One of a texture's pictures. */
typedef struct silmap_pick {
    uint32_t layer;
    uint32_t frame;            /* a layer of one picture has it in all frames */
    int keep_alpha;            /* where it is opaque, too: another frame is not */
    uint32_t cells_x, cells_y; /* that it is to suit; of the first layer 0: it has a wish for cells itself */
} silmap_pick;

int silmap_source_load(make_store *store, const make_texture *texture, const silmap_pick *pick, silmap_source *out);
/* The first picture at the place that hinting finds in `from`; without texels where that is no other place. */
int silmap_source_hint(make_store *store, const make_texture *texture, const silmap_source *from, silmap_source *out);
void silmap_source_release(silmap_source *source);

/* silmap_layer.c: samples and minified image of a picture, at its place in cells that are there: the means over the
 * quadrants. */
author_result silmap_layer_fit(author_run *run, const author_picture *picture, const author_silmap_place *place,
                               const author_silmap_result *cells, author_picture *samples, author_picture *minified);

/* silmap_store.c: the texture into the writer. */
/* width and height: its cells. */
int make_store_silmap(make_store *store, const make_texture *texture, uint32_t *width, uint32_t *height);

/* silmap_report.c: as .json or as a page. input: what it was made of. */
int silmap_write_report(cmd_args *args, const silmap_made *made, const char *input, const char *output,
                        const char *path);

#endif
