/* SPDX-License-Identifier: Apache-2.0 */
/* Tiles of codec 2 with a frame: samples become the same texels again and their hash, for every form, transform, shape
 * and kernel, without touching a byte between or behind the rows; the normal transform adds what the specification
 * says, the same in every kernel; and tiles that any effort codes decode to their texels, none larger than raw. */
#define _DEFAULT_SOURCE
#include <stdlib.h>
#include <string.h>

#include "base_hash.h"
#include "fence.h"
#include "file_codec.h"
#include "file_pred_frame.h"
#include "test.h"

static uint64_t seed = 88172645463325252u;

static uint32_t below(uint32_t n) {
    return test_below(&seed, n);
}

static void slopes_are_right(void) {
    uint8_t slopes[ZT__PRED_SLOPES];
    zt__pred_fill_slopes(slopes);
    for (int r = 0; r < 256; r++)
        for (int g = 0; g < 256; g++) {
            int s = 255 * 255 - (2 * r - 255) * (2 * r - 255) - (2 * g - 255) * (2 * g - 255), root = 0;
            while (s > 0 && (root + 1) * (root + 1) <= s)
                root++;
            int expected = s > 0 ? (256 + root) >> 1 : 128;
            CHECK(zt__pred_slope(slopes, (uint8_t)r, (uint8_t)g) == expected);
        }
}

static const zt__pred_kernel *kernels[ZT__PRED_KERNELS];
static uint32_t kernel_count;

/* All pairs of the first two channels, in rows of every length up to a few vectors, against the table. */
static void slopes_of_kernels(uint32_t channels) {
    uint8_t slopes[ZT__PRED_SLOPES], texels[41 * 4], again[sizeof texels];
    fence rows = fence_open(sizeof texels);
    zt__pred_fill_slopes(slopes);
    for (uint32_t pair = 0, width = 1; pair < 65536; pair += width, width = 1 + width % 41) {
        size_t size = (size_t)width * channels;
        for (size_t i = 0; i < size; i++) {
            uint32_t channel = (uint32_t)(i % channels), value = pair + (uint32_t)(i / channels);
            texels[i] = (uint8_t)(channel == 0 ? value : channel == 1 ? value >> 8 : below(256));
        }
        memcpy(again, texels, size);
        zt__pred_add_slopes(slopes, again, channels, width);
        for (uint32_t k = 0; k < kernel_count; k++) {
            uint8_t *row = fence_block(&rows, size, below(2) != 0);
            memcpy(row, texels, size);
            zt__pred_finish_slopes(kernels[k], slopes, row, channels, width);
            CHECK(memcmp(row, again, size) == 0);
        }
    }
    fence_close(&rows);
}

static void paint(uint8_t *texels, size_t size, uint32_t content) {
    for (size_t i = 0; i < size; i++)
        texels[i] = (uint8_t)(content == 0 ? below(256) : content == 1 ? i / 40 % 7 * 36 : below(30) ? i % 52 : 255);
}

static void check_rows(const uint8_t *out, const uint8_t *texels, size_t row, size_t pitch, uint32_t height) {
    for (uint32_t y = 0; y < height; y++) {
        CHECK(memcmp(out + y * pitch, texels + y * pitch, row) == 0);
        for (size_t i = row; y + 1 < height && i < pitch; i++)
            CHECK(out[y * pitch + i] == 0xA5);
    }
}

/* Fenced memory on all sides: rows with a gap behind each but the last. */
static void form_round_trip(const zt__pred_shape *shape, const zt__pred_form *form, uint32_t content) {
    size_t row = (size_t)shape->width * shape->channels * shape->channel_bytes, size = row * shape->height;
    size_t gap = below(3) * 5, pitch = row + gap, whole = size + gap * (shape->height - 1);
    uint8_t *texels = malloc(whole), *values = malloc(size + row);
    fence samples = fence_open(size), dst = fence_open(whole);
    uint8_t *middle = fence_block(&samples, size, below(2) != 0), *out = fence_block(&dst, whole, below(2) != 0);
    CHECK(texels && values);
    paint(texels, whole, content);
    zt__pred_to_samples(shape, form, texels, pitch, values, middle);
    for (uint32_t k = 0; k < kernel_count; k++) {
        zt__hasher hasher;
        memset(out, 0xA5, whole);
        zt__hash_begin(&hasher);
        zt__pred_from_samples(kernels[k], shape, form, middle, out, pitch, k % 2 ? NULL : &hasher);
        CHECK(k % 2 || zt__hash_end(&hasher) == zt__hash_rows(texels, row, shape->height, pitch));
        check_rows(out, texels, row, pitch, shape->height);
    }
    fence_close(&samples);
    fence_close(&dst);
    free(texels);
    free(values);
}

static void form_bytes(const zt__pred_shape *shape, const zt__pred_form *form) {
    uint8_t bytes[ZT__PRED_FORM_SIZE];
    zt__pred_form again;
    zt__pred_put_form(form, bytes);
    CHECK(zt__pred_has_frame(bytes, sizeof bytes));
    CHECK(zt__pred_take_form(shape, bytes, sizeof bytes, &again) == 0);
    CHECK(again.transform == form->transform && again.predictor == form->predictor && again.by_texel == form->by_texel);
    CHECK(zt__pred_take_form(shape, bytes, 1, &again) == 5313);
    CHECK(zt__pred_take_form(shape, bytes, 0, &again) == 5302);
}

static const uint32_t transforms[] = {0, ZT__PRED_COLOUR, ZT__PRED_NORMAL};

static void forms(void) {
    static const uint32_t sizes[][2] = {{1, 1}, {2, 1}, {1, 5}, {7, 3}, {64, 8}, {65, 9}, {130, 4}};
    for (uint32_t i = 0; i < sizeof sizes / sizeof sizes[0] * 8 * 3 * ZT__PRED_FORMS; i++) {
        const uint32_t *size = sizes[i / (8 * 3 * ZT__PRED_FORMS)], kind = i / (3 * ZT__PRED_FORMS) % 8;
        zt__pred_shape shape = {size[0], size[1], 1 + kind % 4, 1 + kind / 4};
        zt__pred_form form = zt__pred_form_at(i % ZT__PRED_FORMS, transforms[i / ZT__PRED_FORMS % 3]);
        if (!zt__pred_transform_ok(&shape, form.transform))
            continue;
        form_bytes(&shape, &form);
        for (uint32_t content = 0; content < 3; content++)
            form_round_trip(&shape, &form, content);
    }
}

/* Kinds of texels: a few that repeat themselves, where frames win, and others. */
static void paint_tile(const zt__pred_shape *shape, uint32_t content, uint8_t *texels) {
    uint32_t n = shape->channels * shape->channel_bytes;
    uint8_t slopes[ZT__PRED_SLOPES], motif[977];
    zt__pred_fill_slopes(slopes);
    paint(motif, sizeof motif, 0);
    for (size_t i = 0; i < (size_t)shape->width * shape->height; i++)
        for (uint32_t c = 0; c < n; c++) {
            uint8_t *t = texels + i * n;
            size_t x = i % shape->width;
            if (content == 0)
                t[c] = motif[(i * n + c) % sizeof motif];
            else if (content == 1)
                t[c] = (uint8_t)(motif[x % 90] + i / shape->width * 3);
            else if (content == 2 && c == 2 && shape->channel_bytes == 1)
                t[c] = zt__pred_slope(slopes, t[0], t[1]);
            else
                t[c] = (uint8_t)(content == 3 ? 77 + c : 100 + below(60));
        }
}

static void check_tile(zt__encoder *encoder, zt__decoder *decoder, const zt__pred_shape *shape, uint32_t content,
                       uint32_t effort, uint32_t *framed, uint32_t *normal) {
    size_t row = (size_t)shape->width * shape->channels * shape->channel_bytes, size = row * shape->height, stored;
    uint8_t *texels = malloc(size), *again = malloc(size), *coded = malloc(zt__encode_bound(size)), codec;
    zt__sink sink = {0};
    CHECK(texels && again && coded);
    paint_tile(shape, content, texels);
    zt__tile_form form = {.shape = *shape};
    CHECK(zt__encode_tile(encoder, effort, &form, texels, size, coded, zt__encode_bound(size), &codec, &stored, NULL) ==
          ZT_OK);
    CHECK(stored <= size && (stored < size || codec == ZT__CODEC_RAW));
    uint64_t hash = zt__hash(texels, size);
    if (codec == ZT__CODEC_PRED)
        CHECK(zt__decode_pred(&sink, decoder, shape, coded, stored, again, row, hash, 0) == ZT_OK);
    else
        CHECK(zt__decode_stored(&sink, decoder, codec, coded, stored, again, size, hash, 5203, 0) == ZT_OK);
    CHECK(memcmp(again, texels, size) == 0);
    *framed += codec == ZT__CODEC_PRED && zt__pred_has_frame(coded, stored);
    *normal += codec == ZT__CODEC_PRED && (coded[0] & ZT__PRED_NORMAL) != 0;
    if (content == 3) /* one colour: nothing but the header */
        CHECK(size < 16 || (codec == ZT__CODEC_PRED && stored == 3 + shape->channels * shape->channel_bytes));
    free(texels);
    free(again);
    free(coded);
}

static void tiles(void) {
    zt__memory memory;
    zt__encoder encoder;
    zt__decoder decoder;
    uint32_t framed = 0, normal = 0;
    zt__memory_init(&memory, NULL, UINT64_C(1) << 30);
    CHECK(zt__encoder_init(&encoder, &memory, 3, false, NULL) == ZT_OK);
    zt__decoder_init(&decoder, &memory);
    for (uint32_t i = 0; i < 9 * 8 * 5; i++) {
        uint32_t kind = i / 5 % 8;
        zt__pred_shape shape = {1 + below(150), 1 + below(40), 1 + kind % 4, 1 + kind / 4};
        check_tile(&encoder, &decoder, &shape, i % 5, 1 + i / 40, &framed, &normal);
    }
    CHECK(framed > 0 && normal > 0); /* else nothing was tested */
    zt__encoder_free(&encoder);
    zt__decoder_free(&decoder);
}

int main(void) {
    kernel_count = zt__pred_kernels(kernels);
    slopes_of_kernels(3);
    slopes_of_kernels(4);
    slopes_are_right();
    forms();
    tiles();
    return test_end();
}
