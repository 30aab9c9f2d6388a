/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Saving what is intact of a damaged file. What was found is laid out anew as a file that exists only as an io:
 * preamble, directory, heads and padding from memory, stored bytes from the damaged file. The ordinary walk opens that.
 */
#ifndef ZT_RECOVER_H
#define ZT_RECOVER_H

#include "texture.h"
#include "zt/zt_write.h"

/* A chunk whose entry was found, in the directory or in its head. */
typedef struct zt__found {
    zt__entry entry; /* offset: in the damaged file */
    uint32_t index;  /* as the directory or the head says */
    bool sane;       /* its entry breaks no rule */
    bool intact;     /* its hashes are right; for TEXL: its entry has right values */
} zt__found;

/* A run of bytes of the laid-out file. */
typedef struct zt__piece {
    uint64_t at, size;
    const uint8_t *memory; /* NULL: from the damaged file, zeros where that has ended */
    uint64_t source;
} zt__piece;

typedef struct zt__recovery {
    zt__memory memory;
    zt_limits limits;
    const zt_io *damaged;
    const zt_recover_options *options;
    zt_recover_report *report;
    zt_writer *writer;
    zt_diag *diag;
    zt__decoder decoder;
    uint64_t work; /* bytes that may still be hashed and decoded while looking for chunks */

    zt__found *found;
    uint32_t found_count, found_capacity;
    uint64_t texels_size; /* the sum of IMAG's units */

    zt__piece *pieces;
    uint32_t piece_count, texels_piece;
    uint8_t *scaffold; /* preamble, directory, heads */
    uint64_t scaffold_size;
    uint64_t laid_out_size;

    zt_file *file;     /* the laid-out file, opened */
    uint8_t *coverage; /* one byte an image: 1: coverage of patches */
    uint64_t done;     /* tiles, for progress */
    bool no_memory;    /* for filling a tile */
} zt__recovery;

/* Fills found. ZT_OK also when nothing was found. */
zt_result zt__recover_find(zt__recovery *r);

/* The chosen chunk of a type, or NULL. */
const zt__found *zt__recover_chunk(const zt__recovery *r, uint32_t type);

/* Lays the found chunks out and opens them as r->file. lone_texture: with a TEXS chunk of one texture in place of what
 * was found, and no payloads. *usable: images can be read; *textures_ok: TEXS too (payloads that cannot be read are
 * NULL). */
zt_result zt__recover_open(zt__recovery *r, bool lone_texture, bool *usable, bool *textures_ok);
void zt__recover_close(zt__recovery *r);

/* Finds the place of the texels in the damaged file. */
zt_result zt__recover_place_texels(zt__recovery *r);

/* Declares image i in the writer and fills it. */
zt_result zt__recover_image(zt__recovery *r, uint32_t image);

#endif
