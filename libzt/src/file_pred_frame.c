/* SPDX-License-Identifier: Apache-2.0 */
/* Samples of tiles for a zstd frame, and back (file_pred_frame.h). Bytes are integers here and nothing else. */
#include "file_pred_frame.h"

#include <string.h>

#include "base_bytes.h"

enum { FLAGS = ZT__PRED_COLOUR | ZT__PRED_FRAME | ZT__PRED_NORMAL, BY_TEXEL = 4 };

/* ---- forms ---- */

zt__pred_form zt__pred_form_at(uint32_t i, uint32_t transform) {
    zt__pred_form form = {transform, (zt__pred_predictor)(i / 2), i % 2 != 0};
    return form;
}

bool zt__pred_transform_ok(const zt__pred_shape *shape, uint32_t transform) {
    if (transform == 0)
        return true;
    return shape->channels >= 3 &&
           (transform == ZT__PRED_COLOUR || (transform == ZT__PRED_NORMAL && shape->channel_bytes == 1));
}

bool zt__pred_has_frame(const uint8_t *stored, size_t size) {
    return size > 0 && (stored[0] & ZT__PRED_FRAME) != 0;
}

uint32_t zt__pred_take_form(const zt__pred_shape *shape, const uint8_t *stored, size_t size, zt__pred_form *out) {
    if (size == 0 || stored[0] >> 6 != 0)
        return 5302;
    out->transform = stored[0] & (ZT__PRED_COLOUR | ZT__PRED_NORMAL);
    if (!zt__pred_transform_ok(shape, out->transform))
        return 5303;
    if (size < ZT__PRED_FORM_SIZE || (stored[0] & ~(unsigned)FLAGS) != 0 || stored[1] >> 3 != 0 || (stored[1] & 3) == 3)
        return 5313;
    out->predictor = (zt__pred_predictor)(stored[1] & 3);
    out->by_texel = (stored[1] & BY_TEXEL) != 0;
    return 0;
}

void zt__pred_put_form(const zt__pred_form *form, uint8_t out[ZT__PRED_FORM_SIZE]) {
    out[0] = (uint8_t)(ZT__PRED_FRAME | form->transform);
    out[1] = (uint8_t)((unsigned)form->predictor | (form->by_texel ? BY_TEXEL : 0u));
}

/* ---- transforms ---- */

void zt__pred_fill_slopes(uint8_t slopes[ZT__PRED_SLOPES]) {
    uint32_t root = 2;
    for (uint32_t i = 0; i < ZT__PRED_SLOPES; i++) {
        root += (root + 1) * (root + 1) <= 8 * i + 7;
        slopes[i] = (uint8_t)((root + 256) >> 1);
    }
}

void zt__pred_add_slopes(const uint8_t slopes[ZT__PRED_SLOPES], uint8_t *texels, uint32_t channels, uint32_t width) {
    for (uint32_t x = 0; x < width; x++, texels += channels)
        texels[2] = (uint8_t)(texels[2] + zt__pred_slope(slopes, texels[0], texels[1]));
}

void zt__pred_finish_slopes(const zt__pred_kernel *kernel, const uint8_t slopes[ZT__PRED_SLOPES], uint8_t *texels,
                            uint32_t channels, uint32_t width) {
    if (kernel->add_slopes)
        kernel->add_slopes(texels, channels, width);
    else
        zt__pred_add_slopes(slopes, texels, channels, width);
}

void zt__pred_subtract_slopes(const uint8_t slopes[ZT__PRED_SLOPES], uint8_t *texels, uint32_t channels,
                              uint32_t width) {
    for (uint32_t x = 0; x < width; x++, texels += channels)
        texels[2] = (uint8_t)(texels[2] - zt__pred_slope(slopes, texels[0], texels[1]));
}

/* Adds channel 1 to the channels 0 and 2 of texels of 3 bytes; or takes it away. */
static void mix3(uint8_t *restrict texels, uint32_t width, bool add) {
    uint8_t sign = add ? 1 : 255;
    for (size_t x = 0; x < width; x++) {
        uint8_t g = (uint8_t)(texels[3 * x + 1] * sign);
        texels[3 * x] = (uint8_t)(texels[3 * x] + g);
        texels[3 * x + 2] = (uint8_t)(texels[3 * x + 2] + g);
    }
}

/* The same for 4 bytes, a texel at a time: its channel 1 is between the two whatever the order of bytes in a number. */
static void mix4(uint8_t *restrict texels, uint32_t width, bool add) {
    static const uint8_t outer[4] = {255, 0, 255, 0}, inner[4] = {0, 255, 0, 0};
    uint32_t outer_mask, inner_mask;
    memcpy(&outer_mask, outer, sizeof outer_mask);
    memcpy(&inner_mask, inner, sizeof inner_mask);
    for (size_t x = 0; x < width; x++) {
        uint32_t v, g;
        memcpy(&v, texels + 4 * x, sizeof v);
        g = add ? v & inner_mask : (~(v & inner_mask) + (inner_mask & (0 - inner_mask))) & inner_mask;
        v = (((v & outer_mask) + (g << 8 | g >> 8)) & outer_mask) | (v & ~outer_mask);
        memcpy(texels + 4 * x, &v, sizeof v);
    }
}

static void mix16(uint8_t *texels, uint32_t channels, uint32_t width, bool add) {
    for (uint32_t x = 0; x < width; x++, texels += 2 * (size_t)channels) {
        uint16_t g = zt__load16(texels + 2);
        g = add ? g : (uint16_t)-g;
        zt__store16(texels, (uint16_t)(zt__load16(texels) + g));
        zt__store16(texels + 4, (uint16_t)(zt__load16(texels + 4) + g));
    }
}

static void mix(const zt__pred_shape *shape, uint8_t *texels, bool add) {
    if (shape->channel_bytes == 1 && shape->channels == 4)
        mix4(texels, shape->width, add);
    else if (shape->channel_bytes == 1)
        mix3(texels, shape->width, add);
    else
        mix16(texels, shape->channels, shape->width, add);
}

void zt__pred_add_green(const zt__pred_shape *shape, uint8_t *texels) {
    mix(shape, texels, true);
}

/* ---- prediction of a row ---- */

/* Rows are bytes of texels, in little-endian channels. step: bytes of a texel. */

static uint16_t zigzag16(uint16_t r) {
    return (uint16_t)(r << 1 ^ (0 - (r >> 15)));
}

static uint16_t unzigzag16(uint16_t z) {
    return (uint16_t)(z >> 1 ^ (0 - (z & 1)));
}

/* Residuals of a row; above: NULL for the first one. */
static void predict(const zt__pred_shape *shape, zt__pred_predictor predictor, const uint8_t *above, const uint8_t *row,
                    uint8_t *out) {
    size_t step = (size_t)shape->channels * shape->channel_bytes, size = step * shape->width;
    bool leftwards = predictor == ZT__PRED_LEFT || (predictor == ZT__PRED_ABOVE && !above);
    const uint8_t *upper = predictor == ZT__PRED_NONE ? NULL : above;
    for (size_t i = 0; i < size; i += shape->channel_bytes) {
        const uint8_t *guess = leftwards && i >= step ? row + i - step : upper ? upper + i : NULL;
        if (shape->channel_bytes == 1)
            out[i] = (uint8_t)(row[i] - (guess ? *guess : 0));
        else
            zt__store16(out + i, zigzag16((uint16_t)(zt__load16(row + i) - (guess ? zt__load16(guess) : 0))));
    }
}

/* row[i] += other[i] for size bytes. */
static void add8(uint8_t *restrict row, const uint8_t *restrict other, size_t size) {
    for (size_t i = 0; i < size; i++)
        row[i] = (uint8_t)(row[i] + other[i]);
}

static void add16(uint8_t *row, const uint8_t *other, size_t size) {
    for (size_t i = 0; i < size; i += 2)
        zt__store16(row + i, (uint16_t)(zt__load16(row + i) + zt__load16(other + i)));
}

/* Each texel of n bytes but the first gets the one to its left added. n is a constant where this is inlined. */
static inline void sum_left(uint8_t *row, uint32_t n, uint32_t width) {
    uint8_t sum[4] = {0};
    for (size_t x = 0; x < width; x++, row += n)
        for (uint32_t c = 0; c < n; c++)
            row[c] = sum[c] = (uint8_t)(sum[c] + row[c]);
}

static void add_left(const zt__pred_shape *shape, uint8_t *row) {
    size_t step = (size_t)shape->channels * shape->channel_bytes;
    if (shape->channel_bytes == 2)
        add16(row + step, row, step * (shape->width - 1));
    else if (step == 4)
        sum_left(row, 4, shape->width);
    else if (step == 3)
        sum_left(row, 3, shape->width);
    else if (step == 2)
        sum_left(row, 2, shape->width);
    else
        sum_left(row, 1, shape->width);
}

/* Residuals become values in their place. */
static void unpredict(const zt__pred_shape *shape, zt__pred_predictor predictor, const uint8_t *above, uint8_t *row) {
    size_t step = (size_t)shape->channels * shape->channel_bytes, size = step * shape->width;
    void (*add)(uint8_t *, const uint8_t *, size_t) = shape->channel_bytes == 1 ? add8 : add16;
    for (size_t i = 0; shape->channel_bytes == 2 && i < size; i += 2)
        zt__store16(row + i, unzigzag16(zt__load16(row + i)));
    if (predictor == ZT__PRED_NONE)
        return;
    if (above)
        add(row, above, predictor == ZT__PRED_ABOVE ? size : step);
    if (!above || predictor == ZT__PRED_LEFT)
        add_left(shape, row);
}

/* ---- order of the samples ---- */

/* Byte of the texel that is plane k: channels in the order of coding, high bytes before low ones. */
static size_t place_of(const zt__pred_shape *shape, uint32_t k) {
    uint32_t bytes = shape->channel_bytes;
    return zt__pred_channel(shape->channels, k / bytes) * bytes + (bytes - 1 - k % bytes);
}

/* planes is a constant where this is inlined. */
static inline void interleave(const uint8_t *const *from, uint32_t planes, uint32_t width, uint8_t *restrict row) {
    for (size_t x = 0; x < width; x++)
        for (uint32_t k = 0; k < planes; k++)
            row[x * planes + k] = from[k][x];
}

/* One row between the planes of the whole tile and its texels. */
static void gather_row(const zt__pred_shape *shape, const uint8_t *samples, uint32_t y, uint8_t *row) {
    const uint8_t *from[ZT__PRED_PLANES]; /* by place in the texel */
    uint32_t planes = shape->channels * shape->channel_bytes;
    for (uint32_t k = 0; k < planes; k++)
        from[place_of(shape, k)] = samples + ((size_t)k * shape->height + y) * shape->width;
    if (planes == 1)
        memcpy(row, from[0], shape->width);
    else if (planes == 4)
        interleave(from, 4, shape->width, row);
    else if (planes == 3)
        interleave(from, 3, shape->width, row);
    else
        interleave(from, planes, shape->width, row);
}

static void scatter_row(const zt__pred_shape *shape, const uint8_t *row, uint32_t y, uint8_t *samples) {
    uint32_t planes = shape->channels * shape->channel_bytes;
    for (uint32_t k = 0; k < planes; k++) {
        uint8_t *to = samples + ((size_t)k * shape->height + y) * shape->width;
        const uint8_t *from = row + place_of(shape, k);
        for (size_t x = 0; x < shape->width; x++)
            to[x] = from[x * planes];
    }
}

/* ---- whole tiles ---- */

void zt__pred_to_samples(const zt__pred_shape *shape, const zt__pred_form *form, const uint8_t *src, size_t src_pitch,
                         uint8_t *values, uint8_t *samples) {
    uint8_t slopes[ZT__PRED_SLOPES];
    size_t row_size = (size_t)shape->width * shape->channels * shape->channel_bytes;
    if (form->transform == ZT__PRED_NORMAL)
        zt__pred_fill_slopes(slopes);
    for (uint32_t y = 0; y < shape->height; y++) {
        uint8_t *row = values + y * row_size;
        memcpy(row, src + y * src_pitch, row_size);
        if (form->transform == ZT__PRED_NORMAL)
            zt__pred_subtract_slopes(slopes, row, shape->channels, shape->width);
        else if (form->transform == ZT__PRED_COLOUR)
            mix(shape, row, false);
    }
    uint8_t *residuals = values + shape->height * row_size;
    for (uint32_t y = 0; y < shape->height; y++) {
        const uint8_t *row = values + y * row_size;
        uint8_t *to = form->by_texel ? samples + y * row_size : residuals;
        predict(shape, form->predictor, y > 0 ? row - row_size : NULL, row, to);
        if (!form->by_texel)
            scatter_row(shape, residuals, y, samples);
    }
}

void zt__pred_from_samples(const zt__pred_kernel *kernel, const zt__pred_shape *shape, const zt__pred_form *form,
                           const uint8_t *samples, uint8_t *dst, size_t dst_pitch, zt__hasher *hasher) {
    uint8_t slopes[ZT__PRED_SLOPES];
    size_t row_size = (size_t)shape->width * shape->channels * shape->channel_bytes;
    if (form->transform == ZT__PRED_NORMAL)
        zt__pred_prepare_slopes(kernel, slopes);
    /* A row is finished once the one below has been predicted from it. */
    for (uint32_t y = 0; y <= shape->height; y++) {
        uint8_t *row = dst + y * dst_pitch, *above = y > 0 ? row - dst_pitch : NULL;
        if (y < shape->height && form->by_texel)
            memcpy(row, samples + y * row_size, row_size);
        else if (y < shape->height)
            gather_row(shape, samples, y, row);
        if (y < shape->height)
            unpredict(shape, form->predictor, above, row);
        if (above && form->transform == ZT__PRED_NORMAL)
            zt__pred_finish_slopes(kernel, slopes, above, shape->channels, shape->width);
        else if (above && form->transform == ZT__PRED_COLOUR)
            mix(shape, above, true);
        if (above && hasher)
            zt__hash_more(hasher, above, row_size);
    }
}
