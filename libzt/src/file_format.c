/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The table of texel formats (spec/registry.md) and the conversion of plain texels to and from floats. Transfers are in
 * file_transfer.c.
 */
#include "file_format.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base_bytes.h"

/* ---- the table ------------------------------------------------------------------------------ */

#define UNORM(number, name, bytes, channels, alpha, bits) \
    { number, name, 1, 1, bytes, channels, alpha, 0, 1, bits, 0 }
#define SRGB(number, name, bytes, channels, alpha) \
    { number, name, 1, 1, bytes, channels, alpha, 1, 1, 8, 0 }
#define FLOATS(number, name, bytes, channels, alpha, bits) \
    { number, name, 1, 1, bytes, channels, alpha, 0, 1, bits, 1 }
#define BLOCK(number, name, bytes, channels, alpha, srgb, is_float) \
    { number, name "_BLOCK", 4, 4, bytes, channels, alpha, srgb, 0, 0, is_float }
#define ASTC(number, width, height)                                                               \
    {number, "ASTC_" #width "x" #height "_UNORM_BLOCK", width, height, 16, 4, 1, 0, 0, 0, 0}, {   \
        number + 1, "ASTC_" #width "x" #height "_SRGB_BLOCK", width, height, 16, 4, 1, 1, 0, 0, 0 \
    }

static const zt_format_info formats[] = {
    UNORM(9, "R8_UNORM", 1, 1, 0, 8),
    SRGB(15, "R8_SRGB", 1, 1, 0),
    UNORM(16, "R8G8_UNORM", 2, 2, 0, 8),
    SRGB(22, "R8G8_SRGB", 2, 2, 0),
    UNORM(23, "R8G8B8_UNORM", 3, 3, 0, 8),
    SRGB(29, "R8G8B8_SRGB", 3, 3, 0),
    UNORM(37, "R8G8B8A8_UNORM", 4, 4, 1, 8),
    SRGB(43, "R8G8B8A8_SRGB", 4, 4, 1),
    UNORM(70, "R16_UNORM", 2, 1, 0, 16),
    FLOATS(76, "R16_SFLOAT", 2, 1, 0, 16),
    UNORM(77, "R16G16_UNORM", 4, 2, 0, 16),
    FLOATS(83, "R16G16_SFLOAT", 4, 2, 0, 16),
    UNORM(84, "R16G16B16_UNORM", 6, 3, 0, 16),
    FLOATS(90, "R16G16B16_SFLOAT", 6, 3, 0, 16),
    UNORM(91, "R16G16B16A16_UNORM", 8, 4, 1, 16),
    FLOATS(97, "R16G16B16A16_SFLOAT", 8, 4, 1, 16),
    FLOATS(100, "R32_SFLOAT", 4, 1, 0, 32),
    FLOATS(103, "R32G32_SFLOAT", 8, 2, 0, 32),
    FLOATS(106, "R32G32B32_SFLOAT", 12, 3, 0, 32),
    FLOATS(109, "R32G32B32A32_SFLOAT", 16, 4, 1, 32),
    FLOATS(123, "E5B9G9R9_UFLOAT_PACK32", 4, 3, 0, 0),
    BLOCK(131, "BC1_RGB_UNORM", 8, 3, 0, 0, 0),
    BLOCK(132, "BC1_RGB_SRGB", 8, 3, 0, 1, 0),
    BLOCK(133, "BC1_RGBA_UNORM", 8, 4, 1, 0, 0),
    BLOCK(134, "BC1_RGBA_SRGB", 8, 4, 1, 1, 0),
    BLOCK(135, "BC2_UNORM", 16, 4, 1, 0, 0),
    BLOCK(136, "BC2_SRGB", 16, 4, 1, 1, 0),
    BLOCK(137, "BC3_UNORM", 16, 4, 1, 0, 0),
    BLOCK(138, "BC3_SRGB", 16, 4, 1, 1, 0),
    BLOCK(139, "BC4_UNORM", 8, 1, 0, 0, 0),
    BLOCK(140, "BC4_SNORM", 8, 1, 0, 0, 0),
    BLOCK(141, "BC5_UNORM", 16, 2, 0, 0, 0),
    BLOCK(142, "BC5_SNORM", 16, 2, 0, 0, 0),
    BLOCK(143, "BC6H_UFLOAT", 16, 3, 0, 0, 1),
    BLOCK(144, "BC6H_SFLOAT", 16, 3, 0, 0, 1),
    BLOCK(145, "BC7_UNORM", 16, 4, 1, 0, 0),
    BLOCK(146, "BC7_SRGB", 16, 4, 1, 1, 0),
    BLOCK(147, "ETC2_R8G8B8_UNORM", 8, 3, 0, 0, 0),
    BLOCK(148, "ETC2_R8G8B8_SRGB", 8, 3, 0, 1, 0),
    BLOCK(149, "ETC2_R8G8B8A1_UNORM", 8, 4, 1, 0, 0),
    BLOCK(150, "ETC2_R8G8B8A1_SRGB", 8, 4, 1, 1, 0),
    BLOCK(151, "ETC2_R8G8B8A8_UNORM", 16, 4, 1, 0, 0),
    BLOCK(152, "ETC2_R8G8B8A8_SRGB", 16, 4, 1, 1, 0),
    BLOCK(153, "EAC_R11_UNORM", 8, 1, 0, 0, 0),
    BLOCK(154, "EAC_R11_SNORM", 8, 1, 0, 0, 0),
    BLOCK(155, "EAC_R11G11_UNORM", 16, 2, 0, 0, 0),
    BLOCK(156, "EAC_R11G11_SNORM", 16, 2, 0, 0, 0),
    ASTC(157, 4, 4),
    ASTC(159, 5, 4),
    ASTC(161, 5, 5),
    ASTC(163, 6, 5),
    ASTC(165, 6, 6),
    ASTC(167, 8, 5),
    ASTC(169, 8, 6),
    ASTC(171, 8, 8),
    ASTC(173, 10, 5),
    ASTC(175, 10, 6),
    ASTC(177, 10, 8),
    ASTC(179, 10, 10),
    ASTC(181, 12, 10),
    ASTC(183, 12, 12),
};

enum { FORMAT_COUNT = sizeof formats / sizeof formats[0] };

const zt_format_info *zt_find_format(uint32_t format) {
    size_t low = 0;
    size_t high = FORMAT_COUNT;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (formats[middle].format < format)
            low = middle + 1;
        else
            high = middle;
    }
    return low < FORMAT_COUNT && formats[low].format == format ? &formats[low] : NULL;
}

const zt_format_info *zt_find_format_name(const char *name) {
    static const char prefix[] = "VK_FORMAT_";
    if (!name)
        return NULL;
    if (strncmp(name, prefix, sizeof prefix - 1) == 0)
        name += sizeof prefix - 1;
    for (size_t i = 0; i < FORMAT_COUNT; i++) {
        if (strcmp(formats[i].name, name) == 0)
            return &formats[i];
    }
    return NULL;
}

const zt_format_info *zt_get_format(uint32_t i) {
    return i < FORMAT_COUNT ? &formats[i] : NULL;
}

/* ---- single values -------------------------------------------------------------------------- */

/* value x top for value in 0 ... 1, rounded to nearest, ties to even. The product of a float and a number of 16 bits is
 * exact in binary64, so there is one rounding only, and it is done in integers. */
static uint32_t unorm_of(float value, double top) {
    if (!(value > 0.0f)) /* NaN too */
        return 0;
    if (value >= 1.0f)
        return (uint32_t)top;
    double scaled = (double)value * top;
    uint32_t whole = (uint32_t)scaled;
    double rest = scaled - (double)whole;
    return whole + (uint32_t)(rest > 0.5 || (rest == 0.5 && (whole & 1) != 0));
}

uint8_t zt__unorm8_of(float value) {
    return (uint8_t)unorm_of(value, 255.0);
}

uint8_t zt__srgb8_of(float linear) {
    uint32_t bits = zt__bits_of_float(linear);
    const uint32_t least = (127u - ZT__SRGB_FIRST_OCTAVE) << 23;
    if (!(linear > 0.0f) || bits < least)
        return 0;
    if (linear >= 1.0f)
        return 255;
    uint32_t code = zt__srgb8_starts[(bits - least) >> (23 - ZT__SRGB_BUCKET_BITS)];
    return (uint8_t)(code + (uint32_t)(linear >= zt__srgb8_thresholds[code]));
}

/* Binary16 by integers. Finite values beyond the range become the largest finite half (zt.h: packing clamps); infinity
 * and NaN stay what they are. */
uint16_t zt__half_of_float(float value) {
    uint32_t bits = zt__bits_of_float(value);
    uint32_t sign = bits >> 16 & 0x8000u;
    uint32_t size = bits & 0x7FFFFFFFu;
    if (size > 0x7F800000u)
        return (uint16_t)(sign | 0x7E00u);
    if (size == 0x7F800000u)
        return (uint16_t)(sign | 0x7C00u);
    if (size >= 0x477FE000u) /* 65504 */
        return (uint16_t)(sign | 0x7BFFu);
    if (size < 0x33000000u) /* below 2^-25, half of the least denormal */
        return (uint16_t)sign;
    uint32_t shift = 13;
    uint32_t mantissa = size - (112u << 23); /* normal: the exponent goes from bias 127 to 15 */
    if (size < 0x38800000u) {                /* below 2^-14: denormal */
        shift = 126 - (size >> 23);
        mantissa = (size & 0x7FFFFFu) | 0x800000u;
    }
    uint32_t half = mantissa >> shift;
    uint32_t rest = mantissa & ((1u << shift) - 1);
    uint32_t middle = 1u << (shift - 1);
    half += (uint32_t)(rest > middle || (rest == middle && (half & 1) != 0));
    if (half > 0x7BFFu)
        half = 0x7BFFu;
    return (uint16_t)(sign | half);
}

float zt__float_of_half(uint16_t half) {
    uint32_t sign = (uint32_t)(half & 0x8000u) << 16;
    uint32_t exponent = half >> 10 & 31u;
    uint32_t mantissa = half & 0x3FFu;
    if (exponent == 31)
        return zt__float_of_bits(sign | 0x7F800000u | mantissa << 13);
    if (exponent != 0)
        return zt__float_of_bits(sign | (exponent + 112) << 23 | mantissa << 13);
    float small = (float)mantissa * 0x1p-24f; /* exact */
    return sign != 0 ? -small : small;
}

/* VK_FORMAT_E5B9G9R9_UFLOAT_PACK32 (Vulkan 1.3 "Shared Exponent to RGB", EXT_texture_shared_exponent): N = 9, B =
 * 15. */
static void unpack_shared(uint32_t word, float *rgba) {
    /* 2^(exponent - 24) is a normal float for every exponent. */
    float scale = zt__float_of_bits(((word >> 27) + (127 - 24)) << 23);
    rgba[0] = (float)(word & 511) * scale;
    rgba[1] = (float)(word >> 9 & 511) * scale;
    rgba[2] = (float)(word >> 18 & 511) * scale;
    rgba[3] = 1.0f;
}

/* The definition's floor(x / 2^(exponent - 24) + 0.5), exact in binary64. */
static uint32_t shared_mantissa(float value, uint32_t exponent) {
    double inverse = zt__double_of_bits((uint64_t)(1023 + 24 - exponent) << 52);
    return (uint32_t)((double)value * inverse + 0.5);
}

static uint32_t pack_shared(const float *rgba) {
    float clamped[3];
    float largest = 0.0f;
    for (int c = 0; c < 3; c++) {
        clamped[c] = rgba[c] > 0.0f ? rgba[c] : 0.0f;
        if (clamped[c] > 65408.0f)
            clamped[c] = 65408.0f;
        if (clamped[c] > largest)
            largest = clamped[c];
    }
    /* max(-16, floor(log2(largest))) + 16; the exponent field of a float is floor(log2) + 127. */
    uint32_t field = zt__bits_of_float(largest) >> 23;
    uint32_t exponent = field > 127 - 16 ? field - (127 - 16) : 0;
    if (shared_mantissa(largest, exponent) == 512)
        exponent++;
    return shared_mantissa(clamped[0], exponent) | shared_mantissa(clamped[1], exponent) << 9 |
           shared_mantissa(clamped[2], exponent) << 18 | exponent << 27;
}

/* ---- rows ----------------------------------------------------------------------------------- */

/* Channels that the format has not got. */
static inline void fill_missing(float *rgba, uint32_t channels) {
    static const float missing[4] = {0.0f, 0.0f, 0.0f, 1.0f};
    for (uint32_t c = channels; c < 4; c++)
        rgba[c] = missing[c];
}

/* first: table of the channels 0 to 2; the fourth is always linear. */
static void unpack8(const float *first, uint32_t channels, const uint8_t *src, size_t count, float *rgba) {
    if (channels == 4) { /* unrolled: the hot case */
        for (size_t i = 0; i < count; i++, src += 4, rgba += 4) {
            rgba[0] = first[src[0]];
            rgba[1] = first[src[1]];
            rgba[2] = first[src[2]];
            rgba[3] = zt__unorm8_values[src[3]];
        }
        return;
    }
    for (size_t i = 0; i < count; i++, src += channels, rgba += 4) {
        for (uint32_t c = 0; c < channels; c++)
            rgba[c] = first[src[c]];
        fill_missing(rgba, channels);
    }
}

static void unpack_row(const zt_format_info *format, const uint8_t *src, size_t count, float *rgba) {
    uint32_t channels = format->channels;
    if (format->channel_bits == 8) {
        unpack8(zt__unorm8_values, channels, src, count, rgba);
        return;
    }
    for (size_t i = 0; i < count; i++, src += format->block_bytes, rgba += 4) {
        if (format->channel_bits == 0) {
            unpack_shared(zt__load32(src), rgba);
            continue;
        }
        for (uint32_t c = 0; c < channels; c++) {
            if (format->channel_bits == 32)
                rgba[c] = zt__float_of_bits(zt__load32(src + 4 * c));
            else if (format->is_float)
                rgba[c] = zt__float_of_half(zt__load16(src + 2 * c));
            else
                rgba[c] = (float)zt__load16(src + 2 * c) / 65535.0f;
        }
        fill_missing(rgba, channels);
    }
}

static void pack_row(const zt_format_info *format, const float *rgba, size_t count, uint8_t *dst) {
    uint32_t channels = format->channels;
    for (size_t i = 0; i < count; i++, dst += format->block_bytes, rgba += 4) {
        if (format->channel_bits == 0) {
            zt__store32(dst, pack_shared(rgba));
            continue;
        }
        for (uint32_t c = 0; c < channels; c++) {
            if (format->channel_bits == 8)
                dst[c] = zt__unorm8_of(rgba[c]);
            else if (format->channel_bits == 32)
                zt__store32(dst + 4 * c, zt__bits_of_float(rgba[c]));
            else if (format->is_float)
                zt__store16(dst + 2 * c, zt__half_of_float(rgba[c]));
            else
                zt__store16(dst + 2 * c, (uint16_t)unorm_of(rgba[c], 65535.0));
        }
    }
}

zt_result zt_unpack_texels(uint32_t format, const void *src, size_t count, float *rgba) {
    const zt_format_info *info = zt_find_format(format);
    if (count != 0 && (!src || !rgba))
        return ZT_BAD_ARGUMENT;
    if (!info || !info->is_plain)
        return ZT_UNSUPPORTED;
    unpack_row(info, src, count, rgba);
    return ZT_OK;
}

zt_result zt_pack_texels(uint32_t format, const float *rgba, size_t count, void *dst) {
    const zt_format_info *info = zt_find_format(format);
    if (count != 0 && (!rgba || !dst))
        return ZT_BAD_ARGUMENT;
    if (!info || !info->is_plain)
        return ZT_UNSUPPORTED;
    pack_row(info, rgba, count, dst);
    return ZT_OK;
}

void zt__unpack_linear(const zt_format_info *format, uint32_t transfer, const void *src, size_t count, float *rgba) {
    if (format->channel_bits == 8 && transfer == ZT_TRANSFER_SRGB) {
        unpack8(zt__srgb8_values, format->channels, src, count, rgba);
        return;
    }
    unpack_row(format, src, count, rgba);
    zt__linearise(transfer, rgba, count);
}

static void pack_srgb8(uint32_t channels, const float *rgba, size_t count, uint8_t *dst) {
    for (size_t i = 0; i < count; i++, rgba += 4, dst += channels) {
        for (uint32_t c = 0; c < channels && c < 3; c++)
            dst[c] = zt__srgb8_of(rgba[c]);
        if (channels == 4)
            dst[3] = zt__unorm8_of(rgba[3]);
    }
}

void zt__pack_linear(const zt_format_info *format, uint32_t transfer, const float *rgba, size_t count, void *dst) {
    if (zt__transfer_is_identity(transfer)) {
        pack_row(format, rgba, count, dst);
        return;
    }
    if (format->channel_bits == 8 && transfer == ZT_TRANSFER_SRGB) {
        pack_srgb8(format->channels, rgba, count, dst);
        return;
    }
    enum { STEP = 64 };
    float coded[4 * STEP];
    uint8_t *out = dst;
    while (count != 0) {
        size_t n = count < STEP ? count : STEP;
        memcpy(coded, rgba, n * 4 * sizeof(float));
        zt__delinearise(transfer, coded, n);
        pack_row(format, coded, n, out);
        rgba += 4 * n;
        out += n * format->block_bytes;
        count -= n;
    }
}
