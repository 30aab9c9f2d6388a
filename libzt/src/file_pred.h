/* SPDX-License-Identifier: Apache-2.0 */
/* The predicted texel codec, codec 2 (spec/ztex.md section 6.4): prediction from three neighbours, then interleaved
 * range coding (rANS) with static tables that the activity around a sample selects. */
#ifndef ZT_FILE_PRED_H
#define ZT_FILE_PRED_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    ZT__PRED_MAX_EDGE = 65536, /* texels of a row or column of a tile */
    ZT__PRED_MAX_EFFORT = 9,
    ZT__PRED_DEFAULT_EFFORT = 5,
    ZT__PRED_KERNELS = 6
};

/* What a tile holds: width x height texels of 1 to 4 channels of 1 or 2 bytes, 2-byte channels little-endian, rows
 * without padding. */
typedef struct zt__pred_shape {
    uint32_t width, height; /* 1 to ZT__PRED_MAX_EDGE */
    uint32_t channels;
    uint32_t channel_bytes;
} zt__pred_shape;

/* False: the codec is not for such tiles. The functions below want a shape that is right. */
bool zt__pred_shape_ok(const zt__pred_shape *shape);

/* The inner loops of a decoder, all to the same bits and the same verdicts. */
typedef struct zt__pred_kernel zt__pred_kernel;

const zt__pred_kernel *zt__pred_kernel_c(void);
/* NULL where the machine or the compiler has none. */
const zt__pred_kernel *zt__pred_kernel_vector(void); /* SSE2, NEON, WASM: texels by vectors, samples one by one */
const zt__pred_kernel *zt__pred_kernel_sse41(void);  /* samples by fours */
const zt__pred_kernel *zt__pred_kernel_neon(void);
const zt__pred_kernel *zt__pred_kernel_avx2(void);
const zt__pred_kernel *zt__pred_kernel_avx512(void); /* with VBMI and VNNI: Ice Lake, Zen 4 and later */
/* All that this machine runs, plain C first, the fastest last. Returns how many. */
uint32_t zt__pred_kernels(const zt__pred_kernel *out[ZT__PRED_KERNELS]);
/* The fastest. */
const zt__pred_kernel *zt__pred_kernel_best(void);

/* Bytes of scratch memory that decoding wants: they depend on the shape alone. At most 100 KiB and 200 bytes a
 * column. */
size_t zt__pred_scratch_size(const zt__pred_shape *shape);

/* Decodes the size stored bytes of a tile to dst, whose rows begin dst_pitch bytes apart. Returns 0, or the number of
 * the rule that the bytes break (5302 to 5312); the texels at dst are then undefined. Reads and writes nothing but the
 * three memory blocks, whatever the bytes are, and its work is bounded by the shape. scratch: zt__pred_scratch_size
 * bytes, aligned as malloc does; its content does not matter. */
uint32_t zt__pred_decode(const zt__pred_kernel *kernel, const zt__pred_shape *shape, const uint8_t *stored, size_t size,
                         void *scratch, uint8_t *dst, size_t dst_pitch);

/* The same; *hash becomes that of the texels without what is between the rows, which are hashed while they are hot. */
uint32_t zt__pred_decode_hashed(const zt__pred_kernel *kernel, const zt__pred_shape *shape, const uint8_t *stored,
                                size_t size, void *scratch, uint8_t *dst, size_t dst_pitch, uint64_t *hash);

/* Bytes of work memory that encoding wants. */
size_t zt__pred_work_size(const zt__pred_shape *shape);

/* Encodes a tile whose rows begin src_pitch bytes apart into at most dst_size bytes. Returns the size, or 0 where it
 * would be larger. effort: 1 (fast) to 9 (small). The same texels, effort and dst_size give the same bytes on every
 * machine. work: zt__pred_work_size bytes, aligned as malloc does; its content does not matter. */
size_t zt__pred_encode(const zt__pred_shape *shape, const uint8_t *src, size_t src_pitch, uint32_t effort, void *work,
                       uint8_t *dst, size_t dst_size);

#endif
