/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the codec benchmark that call libzt share. */
#ifndef CODEC_ZT_H
#define CODEC_ZT_H

#include <zt/zt_write.h>

#include "codec.h"

/* effort: CODEC_EFFORT_... */
zt_writer_options codec_zt_options(int effort, const zt_parallel *parallel);

/* NULL for no threads; else 2: a pool that lives as long as the program. From the first call on the calling thread
 * stays on one processor. */
const zt_parallel *codec_zt_parallel(int threads);

/* A file with one texture of one image; rows: of level 0, tight. */
int codec_zt_write(const zt_image_desc *desc, const void *texels, uint32_t rows, const zt_writer_options *options,
                   codec_bytes *out);

#endif
