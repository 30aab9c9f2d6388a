/* SPDX-License-Identifier: Apache-2.0 */
/* Tiles of codec 2 whose samples are one zstd frame (spec/ztex.md section 6.4), and the normal transform. Neither
 * touches zstd: callers code and decode the frame. */
#ifndef ZT_FILE_PRED_FRAME_H
#define ZT_FILE_PRED_FRAME_H

#include "base_hash.h"
#include "file_pred_job.h"

enum {
    ZT__PRED_FORM_SIZE = 2, /* bytes in front of the frame */
    ZT__PRED_FORMS = 6,
    ZT__PRED_SLOPES = 8128 /* entries of the table of the normal transform */
};

typedef enum zt__pred_predictor { ZT__PRED_NONE = 0, ZT__PRED_LEFT = 1, ZT__PRED_ABOVE = 2 } zt__pred_predictor;

/* How the samples of a frame come about. */
typedef struct zt__pred_form {
    uint32_t transform; /* ZT__PRED_COLOUR, ZT__PRED_NORMAL or 0 */
    zt__pred_predictor predictor;
    bool by_texel; /* samples texel by texel; else plane by plane */
} zt__pred_form;

/* The form that comes i-th, 0 to ZT__PRED_FORMS - 1. */
zt__pred_form zt__pred_form_at(uint32_t i, uint32_t transform);

/* A transform byte of the format is possible for the shape (rule 5303). */
bool zt__pred_transform_ok(const zt__pred_shape *shape, uint32_t transform);

/* Whether a stored tile has a frame. */
bool zt__pred_has_frame(const uint8_t *stored, size_t size);

/* Reads the bytes in front of the frame. Returns 0, or the number of the rule that they break (5302, 5303, 5313). */
uint32_t zt__pred_take_form(const zt__pred_shape *shape, const uint8_t *stored, size_t size, zt__pred_form *out);
void zt__pred_put_form(const zt__pred_form *form, uint8_t out[ZT__PRED_FORM_SIZE]);

/* Samples of a tile, as many bytes as it has. values: as many and a row of texels more, for work. */
void zt__pred_to_samples(const zt__pred_shape *shape, const zt__pred_form *form, const uint8_t *src, size_t src_pitch,
                         uint8_t *values, uint8_t *samples);
/* And back. hasher: goes on with the texels of each row while they are hot; or NULL. */
void zt__pred_from_samples(const zt__pred_kernel *kernel, const zt__pred_shape *shape, const zt__pred_form *form,
                           const uint8_t *samples, uint8_t *dst, size_t dst_pitch, zt__hasher *hasher);

/* Undoes the colour transform of a row of texels: adds channel 1 to the channels 0 and 2. */
void zt__pred_add_green(const zt__pred_shape *shape, uint8_t *texels);

/* The third component of unit vectors: entry s / 8 is for s = 255^2 - x^2 - y^2, x and y being odd. */
void zt__pred_fill_slopes(uint8_t slopes[ZT__PRED_SLOPES]);

/* What is added to channel 2 of texels whose channels 0 and 1 are r and g. */
static inline uint8_t zt__pred_slope(const uint8_t slopes[ZT__PRED_SLOPES], uint8_t r, uint8_t g) {
    int32_t x = 2 * r - 255, y = 2 * g - 255, s = 65025 - x * x - y * y;
    return s > 0 ? slopes[s >> 3] : 128;
}

/* Adds it to a row of texels of 8-bit channels: the kernel's own way, which needs no table, or by the table. */
static inline void zt__pred_prepare_slopes(const zt__pred_kernel *kernel, uint8_t slopes[ZT__PRED_SLOPES]) {
    if (!kernel->add_slopes)
        zt__pred_fill_slopes(slopes);
}

void zt__pred_finish_slopes(const zt__pred_kernel *kernel, const uint8_t slopes[ZT__PRED_SLOPES], uint8_t *texels,
                            uint32_t channels, uint32_t width);

/* Adds it by the table, or takes it away. */
void zt__pred_add_slopes(const uint8_t slopes[ZT__PRED_SLOPES], uint8_t *texels, uint32_t channels, uint32_t width);
void zt__pred_subtract_slopes(const uint8_t slopes[ZT__PRED_SLOPES], uint8_t *texels, uint32_t channels,
                              uint32_t width);

#endif
