/* SPDX-License-Identifier: Apache-2.0 */
/* What the two forms of ztex inspect share. */
#ifndef ZTEX_INSPECT_H
#define ZTEX_INSPECT_H

#include "elements.h"

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

/* What an umbrella texture stores, as the paper counts it and as it is. Words have four bytes. */
typedef struct ins_umbrellas {
    zt_umbrella_info info;
    uint32_t forms[3];      /* umbrellas of each form, all levels */
    uint64_t paper_words;   /* J, equation 2: pictures, bases, umbrellas of level 0, lists as long as the longest */
    element_scale scale;    /* of level 0 */
    double whole_words[3];  /* T, equation 3: a conventional texture as fine as the least, the mean, the finest */
    uint64_t stored;        /* bytes of the texture's chunk in the file */
    uint64_t stored_images; /* and of the images that it shows itself */
} ins_umbrellas;

/* 0, or -1: the texture is no umbrella texture. */
int ins_umbrellas_of(const zt_file *file, uint32_t texture, ins_umbrellas *out);

/* Entries and the longest of the lists of a level. */
void ins_lists(const zt_umbrella_info *info, uint32_t level, uint64_t *entries, uint32_t *longest);

const char *ins_ellipsoid_name(unsigned ellipsoid);       /* "flat", ... */
const char *ins_background_name(zt_background_kind kind); /* "colour", ... */
const char *ins_mode_name(zt_umbrella_colour_mode mode);  /* "barycentric", ... */

/* inspect_umbrella.c: the two forms of the texture's part. */
void ins_umbrella_text(const zt_file *file, uint32_t texture);
json_t *ins_umbrella_json(const zt_file *file, uint32_t texture);

/* Bytes in the file of the chunk that belongs to a texture of this kind; 0: not known. */
uint64_t ins_stored_chunk(const zt_file *file, uint32_t texture, zt_kind kind, const char *type);

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
