/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Mip levels of one image while its level 0 streams by. Separable: rows are filtered along x as they come, kept in a
 * ring, and combined along y when all rows that an output row needs are there; volumes likewise along z, in a ring of
 * slices.
 *
 * Each level is made from the floats of the level before, linear and premultiplied, before anything that is done for
 * storing: rounding, clamping of the filters' negative lobes, division by alpha, renormalising, and the zero border
 * (level 0's is zeroed before).
 *
 * With the wrap mode repeat, an output row near the top needs the last source rows. Nothing waits for them: the level
 * begins with the first output row that has all its source rows behind it, goes round, and ends with the few rows left
 * out. So its rows come in cyclic order, from row 3 or so; the next level takes them in that order. The same holds for
 * slices along z.
 */
#ifndef ZT_FILE_MIP_H
#define ZT_FILE_MIP_H

#include "base_memory.h"
#include "file_geometry.h"
#include "file_texels.h"

typedef struct zt__mip_desc {
    const zt__image_record *record; /* plain format */
    const zt_format_info *format;
    uint8_t filter;                 /* zt_mip_filter */
    uint8_t wrap_u, wrap_v, wrap_w; /* zt_wrap */
    bool is_normal;
} zt__mip_desc;

/* Where rows of levels above 0 go. */
typedef struct zt__mip_sink {
    void *user;
    /* The place of rows y, y + 1, ... of a slice: *n of them, set lower if not all are together. */
    zt_result (*place)(void *user, uint32_t level, uint32_t z, uint32_t y, uint32_t *n, uint8_t **dst, zt_diag *diag);
    /* They have been written there. */
    zt_result (*commit)(void *user, uint32_t level, uint32_t z, uint32_t y, uint32_t n, zt_diag *diag);
} zt__mip_sink;

enum {
    ZT__MIP_BATCH = 32 /* most rows pushed at once */
};

typedef struct zt__mip zt__mip;

zt_result zt__mip_new(zt__memory *memory, const zt_parallel *parallel, const zt__mip_desc *desc,
                      const zt__mip_sink *sink, zt_diag *diag, zt__mip **out);
void zt__mip_free(zt__mip *mip); /* NULL is allowed */

/* The next n <= ZT__MIP_BATCH rows of level 0, within one slice. After the last row of the last slice the next layer
 * begins. */
zt_result zt__mip_push(zt__mip *mip, const uint8_t *rows, uint32_t n, size_t pitch, zt_diag *diag);

/* First row of each slice in which a level's rows come (repeat); 0 else. For level 0 and up. */
uint32_t zt__mip_first_row(const zt__mip *mip, uint32_t level);

#endif
