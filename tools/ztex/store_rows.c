/* SPDX-License-Identifier: Apache-2.0 */
/* Rows of a picture as rows of a texture: channels in order, colours in the format's coding, coverage in the alpha. */
#include "make.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static img_type type_of(const zt_format_info *format) {
    if (format->channel_bits == 8)
        return IMG_U8;
    if (format->channel_bits == 16)
        return format->is_float ? IMG_HALF : IMG_U16;
    return IMG_FLOAT;
}

/* ---- the picture's bytes as they are ------------------------------------------------------------------ */

static int is_in_order(const make_rows *r) {
    for (uint32_t c = 0; c < r->channels; c++)
        if (r->map[c] != (int)c)
            return 0;
    return 1;
}

static int read_direct(make_rows *r, uint32_t z, uint32_t y, uint32_t count, void *dst, char *error) {
    img_type type = type_of(r->format);
    size_t size = img_type_size(type), texels = (size_t)r->info->width * count;
    if (is_in_order(r))
        return img_read_rows(r->reader, z, y, count, r->channels, type, dst, 0, error);
    unsigned char *from = (unsigned char *)r->source;
    unsigned char *to = dst;
    if (img_read_rows(r->reader, z, y, count, 0, type, from, 0, error))
        return -1;
    for (size_t i = 0; i < texels; i++)
        for (uint32_t c = 0; c < r->channels; c++) {
            size_t channel = i * r->info->channels + (size_t)r->map[c];
            memcpy(to + (i * r->channels + c) * size, from + channel * size, size);
        }
    return 0;
}

/* ---- through floats -------------------------------------------------------------------------------------- */

static int fill_coverage(make_rows *r, uint32_t y, uint32_t count, char *error) {
    uint32_t w = r->info->width;
    if (r->mask && img_read_rows(r->mask, 0, y, count, 1, IMG_FLOAT, r->coverage, 0, error))
        return -1;
    for (uint32_t row = 0; row < count; row++)
        for (uint32_t x = 0; x < w; x++) {
            float *at = &r->coverage[(size_t)row * w + x];
            *at = (r->mask ? *at : 1.0f) * author_ramp(w, r->info->height, r->ramp, x, y + row);
        }
    return 0;
}

/* sRGB and its like are straight enough over the root of the light. */
static float encode(const make_rows *r, float value) {
    if (!r->table || !(value >= 0.0f && value < 1.0f))
        return zt_transfer_encode(r->transfer_out, value);
    float at = sqrtf(value) * MAKE_TABLE;
    int i = (int)at;
    return r->table[i] + (at - (float)i) * (r->table[i + 1] - r->table[i]);
}

/* Colours of a texel from the picture's coding to the texture's, and from its alpha to the texture's times cover. */
static void convert_texel(const make_rows *r, float *p, float alpha, float cover) {
    int multiply = r->alpha_out == ZT_ALPHA_PREMULTIPLIED;
    int divide = r->alpha_in == IMG_ALPHA_PREMULTIPLIED;
    int changes = r->transfer_in != r->transfer_out || multiply != divide || (multiply && cover != 1.0f);
    for (int c = 0; changes && c < 3; c++) {
        float value = zt_transfer_decode(r->transfer_in, p[c]);
        if (divide)
            value = alpha > 0.0f ? value / alpha : 0.0f;
        if (multiply)
            value *= alpha * cover;
        p[c] = encode(r, value);
    }
    if (r->alpha_out != ZT_ALPHA_NONE)
        p[3] = alpha * cover;
}

static void gather(const make_rows *r, const float *from, float *to) {
    for (uint32_t c = 0; c < 4; c++) {
        int channel = c < r->channels ? r->map[c] : c == 3 ? -2 : -1;
        to[c] = channel >= 0 ? from[channel] : channel == -2 ? 1.0f : 0.0f;
    }
}

/* The next rows as floats into source and coverage, or where they are already. */
static int fetch(make_rows *r, uint32_t z, uint32_t y, uint32_t count, const float **source, const float **cover,
                 char *error) {
    size_t row = r->info->width;
    int covered = r->role == ROLE_COVERED || r->role == ROLE_MASK;
    *source = r->source;
    *cover = covered ? r->coverage : NULL;
    if (r->ready) {
        const author_picture *picture = &r->ready->picture, *coverage = &r->ready->coverage;
        *source = picture->texels + (size_t)y * row * picture->channels;
        *cover = coverage->texels ? coverage->texels + (size_t)y * row : NULL;
        return 0;
    }
    if (img_read_rows(r->reader, z, y, count, 0, IMG_FLOAT, r->source, 0, error))
        return -1;
    return covered ? fill_coverage(r, y, count, error) : 0;
}

int make_rows_read(make_rows *r, uint32_t z, uint32_t y, uint32_t count, void *dst, char *error) {
    size_t texels = (size_t)r->info->width * count;
    size_t channels = r->ready ? r->ready->picture.channels : r->info->channels;
    const float *source, *coverage;
    if (r->direct)
        return read_direct(r, z, y, count, dst, error);
    if (fetch(r, z, y, count, &source, &coverage, error))
        return -1;
    for (size_t i = 0; i < texels; i++) {
        const float *from = source + i * channels;
        float *to = r->rgba + 4 * i;
        float cover = coverage ? coverage[i] : 1.0f;
        /* The coverage of a picture that is ready has its alpha in it. */
        int has_alpha = r->source_alpha >= 0 && !(r->ready && coverage);
        float alpha = has_alpha ? from[r->source_alpha] : 1.0f;
        if (r->role == ROLE_MASK) {
            to[0] = cover * alpha;
            continue;
        }
        gather(r, from, to);
        convert_texel(r, to, alpha, cover);
    }
    if (r->turn && r->role != ROLE_MASK)
        make_turn_rows(r->turn, r, y, count, r->rgba);
    if (zt_pack_texels(r->format->format, r->rgba, texels, dst) != ZT_OK) {
        snprintf(error, IMG_ERROR, "texels of %s cannot be made", r->format->name);
        return -1;
    }
    return 0;
}
