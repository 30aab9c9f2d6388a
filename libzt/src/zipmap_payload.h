/* SPDX-License-Identifier: Apache-2.0 */
/* Zipmaps (spec/zipmap.md): the payload, its checks, coding, the patch grid. */
#ifndef ZT_ZIPMAP_PAYLOAD_H
#define ZT_ZIPMAP_PAYLOAD_H

#include "file_open.h"

typedef struct zt__zipmap {
    uint32_t patch_count, layer_count;
    uint64_t block_size;   /* bytes of the one block that all of this is in */
    uint32_t *parents;     /* patch_count */
    uint8_t *source_kinds; /* 0 images, 1 texture */
    uint32_t *sources;     /* [layer][patch] */
    uint32_t *masks;       /* ZT_NONE: none */
    double (*matrices)[9]; /* [patch]: parent to patch */
    double (*composed)[9]; /* [patch]: root to patch */
} zt__zipmap;

/* Rules 8101 to 8111 over a decoded payload; composed is filled. Used by loader, validator and writer. */
zt_result zt__check_zipmap(zt__sink *sink, zt__zipmap *zipmap, const zt__payload_scope *scope, uint64_t offset);

/* Decodes a ZPMP chunk; *out is one block, freed with zt__free(memory, z, 1, z->block_size). */
zt_result zt__decode_zipmap(zt__sink *sink, zt__memory *memory, zt__decoder *decoder, const zt_limits *limits,
                            const uint8_t *data, size_t size, const zt__payload_scope *scope, uint64_t offset,
                            zt__zipmap **out);

/* Allocates a zipmap with its arrays, all zero. */
zt_result zt__zipmap_new(zt__memory *memory, uint32_t patch_count, uint32_t layer_count, zt_diag *diag,
                         zt__zipmap **out);

/* Codes the ZPMP chunk; *out has *out_capacity bytes allocated, *out_size used. */
zt_result zt__encode_zipmap(zt__encoder *encoder, const zt__zipmap *zipmap, zt_diag *diag, uint8_t **out,
                            uint64_t *out_capacity, size_t *out_size);

/* A = adjugate of m, and the determinant in the order of spec/zipmap.md. */
double zt__adjugate(const double m[9], double a[9]);
/* out = p q, in the order of spec/zipmap.md. */
void zt__multiply(const double p[9], const double q[9], double out[9]);

/*
 * The patch grid over root space: for each cell the patches that may touch it, front to back (descending index), root
 * left out. A cell whose list is long because many small patches crowd in it has a grid of its own.
 */
typedef struct zt__grid_cell {
    uint32_t first; /* into patches; or a grid's index */
    uint32_t count; /* ZT_NONE: a grid */
} zt__grid_cell;

typedef struct zt__grid_node {
    double x0, y0, x1, y1;   /* the box that holds the parts of patches that are here: no patch is outside of it */
    double scale_x, scale_y; /* cells for one unit of root space */
    uint32_t width, height, first_cell, depth;
} zt__grid_node;

/* A growing array. */
typedef struct zt__grid_array {
    void *data;
    uint64_t count, capacity;
} zt__grid_array;

typedef struct zt__patch_grid {
    zt__grid_node top;   /* the outermost grid; 0 x 0 when no patch is in the unit square */
    uint32_t longest;    /* list */
    uint64_t list_total; /* of all lists */
    zt__grid_array nodes, cells, patches;
} zt__patch_grid;

zt_result zt__build_patch_grid(zt__memory *memory, const zt__zipmap *zipmap, zt_diag *diag, zt__patch_grid **out);
void zt__free_patch_grid(zt__memory *memory, zt__patch_grid *grid); /* NULL is allowed */

/* The list for a point of the unit square: *first to *first + the result. */
uint32_t zt__patches_at(const zt__patch_grid *grid, double u, double v, const uint32_t **first);

#endif
