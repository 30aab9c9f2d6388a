/* SPDX-License-Identifier: Apache-2.0 */
/* What the two forms of ztex inspect share. */
#ifndef ZTEX_INSPECT_H
#define ZTEX_INSPECT_H

#include "command.h"

enum { INS_SALVAGED = 256 };

/* A chunk of a file that could not be opened. */
typedef struct ins_salvaged {
    zt_chunk_info info;
    int intact;
} ins_salvaged;

typedef struct ins_job {
    cmd_args *args;
    const char *name;    /* as given, for messages and JSON */
    const zt_file *file; /* NULL: not even best effort could open it */
    int whole;           /* 0: best effort, with the error beside it */
    zt_diag error;       /* when not whole */
    int tree, tiles, patches, textconv;
    uint32_t salvaged_count; /* chunks that were found although file is NULL */
    ins_salvaged salvaged[INS_SALVAGED];
} ins_job;

void ins_text(const ins_job *job);
json_t *ins_json(const ins_job *job);

/* "R8G8B8A8_SRGB", or "format 12345" in buffer (at least 24 bytes). */
const char *ins_format_name(uint32_t format, char *buffer, size_t size);
/* A name, or the number in buffer (at least 16 bytes). name may be NULL. */
const char *ins_name(const char *name, uint32_t number, char *buffer, size_t size);
const char *ins_codec_name(uint8_t codec); /* "raw", "zstd", "pred", "fields", NULL */

/* Bytes of an image decoded, and stored in TEXL. */
void ins_image_bytes(const zt_file *file, uint32_t image, uint64_t *decoded, uint64_t *stored);

/* Counts of a silmap's cells, and what they cost. */
typedef struct ins_cells {
    zt_silmap_info info;
    uint64_t cut;    /* cells that have a cut arm */
    uint64_t memory; /* bytes of the cells as they are looked up */
    uint64_t stored; /* bytes of the texture's chunk in the file; 0: not known */
} ins_cells;

/* 0, or -1: the texture is no silmap. */
int ins_silmap(const zt_file *file, uint32_t texture, ins_cells *out);
const char *ins_filter_name(zt_silmap_filter filter); /* "continuous", ... */

/* 1 when the level begins a unit: it has tiles of its own, or is the first of the tail. */
int ins_begins_unit(const zt_image_info *image, uint32_t level);

/* Where a patch lies and how fine it is. */
typedef struct ins_placement {
    int is_box;                 /* 1: offset and scale say all; 0: rotated, sheared or in perspective */
    double offset[2], scale[2]; /* of the patch's unit square in its parent, is_box */
    double box[4];              /* footprint in root coordinates: u0, v0, u1, v1 */
    double corners[4][2];       /* of the patch in root coordinates */
    double finer[2]; /* texels of the patch for one texel of the root, along u and v, in the middle; 0: not known */
    uint32_t width, height; /* of the patch's first image; 0: it shows a texture */
} ins_placement;

void ins_place(const zt_file *file, uint32_t texture, uint32_t patch, ins_placement *out);

#endif
