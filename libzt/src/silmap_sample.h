/* SPDX-License-Identifier: Apache-2.0 */
/* Looking up silmaps (spec/silmap.md section 6). */
#ifndef ZT_SILMAP_SAMPLE_H
#define ZT_SILMAP_SAMPLE_H

#include "file_sample.h"
#include "silmap_payload.h"

/* One layer of a silmap. */
typedef struct zt__silmap_view {
    const zt__silmap *silmap;
    uint32_t samples;  /* places in the image set */
    uint32_t minified; /* ZT_NONE: there is none */
} zt__silmap_view;

/* A cell with what stands on its corners. */
typedef struct zt__silmap_corners {
    const zt__silmap *silmap; /* NULL: empty */
    uint32_t samples, layer, x, y;
    zt_silmap_shape shape;
    double colour[4][4]; /* [corner][channel] */
} zt__silmap_corners;

/* The cells that the last lookups met, so that points close to each other fetch the samples of a cell once.
 * Zero-initialised is empty; of one call. */
typedef struct zt__silmap_scratch {
    zt__silmap_corners near[8];
} zt__silmap_scratch;

/* wraps: of the coordinates: the texture's own, or clamp where a patch shows it. */
zt_result zt__sample_silmap(zt__sample_call *call, zt__silmap_scratch *scratch, const zt__silmap_view *view,
                            const uint8_t wraps[3], const zt_point *point, float rgba[4]);

#endif
