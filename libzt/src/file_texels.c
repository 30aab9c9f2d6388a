/* SPDX-License-Identifier: Apache-2.0 */
#include "file_texels.h"

#include <math.h>
#include <string.h>

#include "base_bytes.h"
#include "base_diag.h"
#include "file_format.h"

/* Sums of such values stay finite over all levels; a file may hold any float. */
#define LARGEST 7.9228162514264338e28f /* 2^96 */

/* ---- set-up ------------------------------------------------------------------------------------- */

void zt__texels_init(zt__texels *texels, const zt_format_info *format, uint32_t transfer, uint8_t alpha_mode,
                     bool is_normal) {
    memset(texels, 0, sizeof *texels);
    texels->format = format;
    texels->transfer = is_normal ? ZT_TRANSFER_LINEAR : transfer;
    texels->straight = alpha_mode == ZT_ALPHA_STRAIGHT && format->has_alpha && !is_normal;
    texels->is_normal = is_normal;
    texels->least_alpha = 9.5367431640625e-7f; /* 2^-20 */
    if (!format->is_float)
        texels->least_alpha = format->channel_bits == 8 ? 0.5f / 255.0f : 0.5f / 65535.0f;
}

/* ---- loading ------------------------------------------------------------------------------------ */

/* Files may hold NaN and infinities: whose sums would differ between machines in their bits. */
static bool tame(float *values, size_t count) {
    bool negative = false;
    for (size_t i = 0; i < count; i++) {
        float v = values[i];
        v = v < LARGEST ? v : v >= LARGEST ? LARGEST : 0.0f;
        v = v > -LARGEST ? v : -LARGEST;
        negative |= v < 0.0f;
        values[i] = v;
    }
    return negative;
}

static void multiply_alpha(float *rgba, size_t count) {
    for (size_t i = 0; i < count; i++, rgba += 4) {
        rgba[0] *= rgba[3];
        rgba[1] *= rgba[3];
        rgba[2] *= rgba[3];
    }
}

static void load_normals(const zt__texels *texels, size_t count, float *v) {
    for (size_t i = 0; i < count; i++, v += 4) {
        for (int c = 0; c < 3 && !texels->format->is_float; c++)
            v[c] = 2.0f * v[c] - 1.0f;
        if (texels->format->channels == 2) {
            float rest = 1.0f - v[0] * v[0] - v[1] * v[1];
            v[2] = rest > 0.0f ? sqrtf(rest) : 0.0f;
        }
    }
}

bool zt__texels_load(const zt__texels *texels, const uint8_t *src, size_t count, float *dst) {
    const zt_format_info *format = texels->format;
    if (!format->is_float) {
        zt__unpack_linear(format, texels->transfer, src, count, dst);
    } else {
        (void)zt_unpack_texels(format->format, src, count, dst);
        (void)tame(dst, 4 * count);
        zt__linearise(texels->transfer, dst, count);
    }
    if (texels->is_normal) {
        load_normals(texels, count, dst);
        return true;
    }
    if (texels->straight)
        multiply_alpha(dst, count);
    return format->is_float && tame(dst, 4 * count);
}

/* ---- storing ------------------------------------------------------------------------------------ */

static void divide_alpha(const zt__texels *texels, float *rgba, size_t count) {
    for (size_t i = 0; i < count; i++, rgba += 4) {
        float alpha = rgba[3];
        bool visible = alpha >= texels->least_alpha;
        for (int c = 0; c < 3; c++)
            rgba[c] = visible ? rgba[c] / alpha : 0.0f;
    }
}

static void store_normals(const zt__texels *texels, float *v, size_t count) {
    for (size_t i = 0; i < count; i++, v += 4) {
        float square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        bool vanishes = !(square > 1e-20f);
        float length = vanishes ? 1.0f : sqrtf(square);
        v[0] = vanishes ? 0.0f : v[0] / length;
        v[1] = vanishes ? 0.0f : v[1] / length;
        v[2] = vanishes ? 1.0f : v[2] / length;
        for (int c = 0; c < 3 && !texels->format->is_float; c++)
            v[c] = 0.5f * v[c] + 0.5f;
    }
}

void zt__texels_store(const zt__texels *texels, float *work, bool negative, size_t count, uint8_t *dst) {
    if (texels->is_normal) {
        store_normals(texels, work, count);
    } else if (!negative) {
        for (size_t i = 0; i < 4 * count; i++)
            work[i] = work[i] > 0.0f ? work[i] : 0.0f;
    }
    if (texels->straight)
        divide_alpha(texels, work, count);
    zt__pack_linear(texels->format, texels->transfer, work, count, dst);
}
