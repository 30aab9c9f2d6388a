/* SPDX-License-Identifier: Apache-2.0 */
/* Looking up zipmaps (spec/zipmap.md section 3). */
#ifndef ZT_ZIPMAP_SAMPLE_H
#define ZT_ZIPMAP_SAMPLE_H

#include "file_sample.h"
#include "zipmap_payload.h"

/* Where a patch's texels come from: places in the image set, ZT_NONE where they are not needed. */
typedef struct zt__patch_sources {
    uint32_t base;  /* image of layer 0 */
    uint32_t layer; /* image of the layer that is looked up, when that is not layer 0 */
    uint32_t mask;
    uint32_t texture; /* what to hand to `show`; ZT_NONE: the patch shows images */
} zt__patch_sources;

typedef struct zt__zipmap_view {
    const zt__zipmap *zipmap;
    const zt__patch_grid *grid;       /* NULL: the root alone */
    const zt__patch_sources *sources; /* of each patch */
} zt__zipmap_view;

zt_result zt__sample_zipmap(zt__sample_call *call, const zt__zipmap_view *view, const uint8_t wraps[3],
                            const zt_point *point, const zt__show_texture *show, zt__colours out);

#endif
