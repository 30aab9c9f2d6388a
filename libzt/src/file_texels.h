/* SPDX-License-Identifier: Apache-2.0 */
/* Texels as the mip filters see them: four floats, linear light, premultiplied; or vectors, for normal maps. */
#ifndef ZT_FILE_TEXELS_H
#define ZT_FILE_TEXELS_H

#include <stdbool.h>

#include "zt/zt.h"

typedef struct zt__texels {
    const zt_format_info *format;
    uint32_t transfer;
    bool straight; /* colours are multiplied by the fourth channel */
    bool is_normal;
    float least_alpha; /* below it a texel is invisible when stored, and has no colour */
} zt__texels;

void zt__texels_init(zt__texels *texels, const zt_format_info *format, uint32_t transfer, uint8_t alpha_mode,
                     bool is_normal);

/* Stored texels to floats. True when a value is negative, so that negative results are meant. */
bool zt__texels_load(const zt__texels *texels, const uint8_t *src, size_t count, float *dst);

/* Filtered floats to stored texels; work is changed on the way. */
void zt__texels_store(const zt__texels *texels, float *work, bool negative, size_t count, uint8_t *dst);

#endif
