/* SPDX-License-Identifier: Apache-2.0 */
/* Texel formats (spec/registry.md): what is known of each number, and conversion of texels to and from floats. */
#ifndef ZT_FILE_FORMAT_H
#define ZT_FILE_FORMAT_H

#include <stdbool.h>

#include "zt/zt.h"

/* CICP transfer numbers that code names (spec/registry.md). */

/* Coded values are linear light already. */
static inline bool zt__transfer_is_identity(uint32_t transfer) {
    return transfer == ZT_TRANSFER_UNSPECIFIED || transfer == ZT_TRANSFER_LINEAR;
}

/* Inverse transfer of the first three channels in place, count texels of four floats. */
void zt__linearise(uint32_t transfer, float *rgba, size_t count);

/* The reverse. */
void zt__delinearise(uint32_t transfer, float *rgba, size_t count);

/* zt_unpack_texels and zt__linearise in one, to the same bits; fast where formats are 8-bit. format is plain, transfer
 * known. src needs no alignment. */
void zt__unpack_linear(const zt_format_info *format, uint32_t transfer, const void *src, size_t count, float *rgba);

/* zt__delinearise and zt_pack_texels in one, to the same bits; fast where formats are 8-bit and sRGB or linear. rgba is
 * left as it is. */
void zt__pack_linear(const zt_format_info *format, uint32_t transfer, const float *rgba, size_t count, void *dst);

/* x^p for x >= 0 from IEEE operations alone: the same bits on every machine. Relative error below 1e-11 for results in
 * the range of float. */
double zt__power(double x, double p);

enum {
    ZT__SRGB_FIRST_OCTAVE = 13, /* below 2^-13 all linear values have code 0 */
    ZT__SRGB_BUCKET_BITS = 7,   /* of the mantissa: so a bucket holds at most one threshold */
    ZT__SRGB_BUCKETS = ZT__SRGB_FIRST_OCTAVE << ZT__SRGB_BUCKET_BITS
};

/* file_format_table.c, written by `test_format --table` and checked by test_format. */
extern const float zt__unorm8_values[256];    /* k / 255 */
extern const float zt__srgb8_values[256];     /* zt_transfer_decode(13, k / 255) */
extern const float zt__srgb8_thresholds[256]; /* [k]: smallest linear value whose code is above k; [255]: infinity */
extern const uint8_t zt__srgb8_starts[ZT__SRGB_BUCKETS]; /* code of the least value of each bucket */

/* zt_pack of one channel to 8 bits: clamps, rounds to nearest, ties to even; NaN becomes 0. */
uint8_t zt__unorm8_of(float value);
/* The same behind zt_transfer_encode(13, ...), by table. */
uint8_t zt__srgb8_of(float linear);

uint16_t zt__half_of_float(float value);
float zt__float_of_half(uint16_t half);

#endif
