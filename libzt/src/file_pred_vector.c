/* SPDX-License-Identifier: Apache-2.0 */
/* The decoder's loops with 16-byte vectors of the compiler, for whatever the machine has (SSE2, NEON, WASM): texels are
 * restored by vectors, samples decoded by the loops in plain C (file_pred.h). Little-endian machines. */
#include "file_pred_job.h"

#include <string.h>

#include "base_bytes.h"

#if defined(__has_builtin) && (defined(__SSE2__) || defined(__ARM_NEON) || defined(__wasm_simd128__))
#if __has_builtin(__builtin_shufflevector) && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__
#define VECTORS 1
#endif
#endif

#ifdef VECTORS

typedef uint8_t bytes16 __attribute__((vector_size(16)));
typedef uint16_t halves8 __attribute__((vector_size(16)));
typedef uint32_t words4 __attribute__((vector_size(16)));
typedef uint64_t longs2 __attribute__((vector_size(16)));

static inline words4 load(const void *p) {
    words4 v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline void store(void *p, words4 v) {
    memcpy(p, &v, sizeof v);
}

/* left + up - (corner between left and up) + r for 16 bytes. */
static inline words4 restore8(words4 left, words4 up, words4 corner, words4 r) {
    bytes16 a = (bytes16)left, b = (bytes16)up, c = (bytes16)corner;
    bytes16 less = (bytes16)(a < b), least = (a & less) | (b & ~less), most = (b & less) | (a & ~less);
    bytes16 low = (bytes16)(c < least);
    c = (least & low) | (c & ~low);
    bytes16 high = (bytes16)(c > most);
    c = (most & high) | (c & ~high);
    return (words4)(a + b + (bytes16)r - c);
}

/* For 8 numbers of 16 bits. */
static inline words4 restore16(words4 left, words4 up, words4 corner, words4 r) {
    halves8 a = (halves8)left, b = (halves8)up, c = (halves8)corner;
    halves8 less = (halves8)(a < b), least = (a & less) | (b & ~less), most = (b & less) | (a & ~less);
    halves8 low = (halves8)(c < least);
    c = (least & low) | (c & ~low);
    halves8 high = (halves8)(c > most);
    c = (most & high) | (c & ~high);
    return (words4)(a + b + (halves8)r - c);
}

static inline void transpose4(words4 r[4]) {
    words4 a = __builtin_shufflevector(r[0], r[1], 0, 4, 1, 5), b = __builtin_shufflevector(r[0], r[1], 2, 6, 3, 7);
    words4 c = __builtin_shufflevector(r[2], r[3], 0, 4, 1, 5), d = __builtin_shufflevector(r[2], r[3], 2, 6, 3, 7);
    r[0] = __builtin_shufflevector(a, c, 0, 1, 4, 5);
    r[1] = __builtin_shufflevector(a, c, 2, 3, 6, 7);
    r[2] = __builtin_shufflevector(b, d, 0, 1, 4, 5);
    r[3] = __builtin_shufflevector(b, d, 2, 3, 6, 7);
}

/* Residuals of 8 rows of 4-byte texels become values. One row is one column behind the row above it, so all that a
 * texel is predicted from is there: row i is lane i, and a step goes one column on. Left of a row all stays zero. */
static void wave8(uint8_t *texels, size_t pitch, const uint8_t *top, uint32_t width) {
    words4 left[2] = {{0}}, corner[2] = {{0}};
    for (uint32_t x = 0; x < width + 7; x += 4) {
        words4 r[8];
        uint8_t *at[8];
        for (uint32_t i = 0; i < 8; i++) {
            at[i] = texels + i * pitch + (size_t)x * 4 - i * 4;
            r[i] = load(at[i]);
        }
        transpose4(r);
        transpose4(r + 4);
        for (uint32_t i = 0; i < 4; i++) {
            words4 first = {0, 0, 0, zt__load32(top + (size_t)(x + i) * 4)};
            words4 up[2] = {__builtin_shufflevector(first, left[0], 3, 4, 5, 6),
                            __builtin_shufflevector(left[0], left[1], 3, 4, 5, 6)};
            for (uint32_t h = 0; h < 2; h++) {
                left[h] = restore8(left[h], up[h], corner[h], r[i + 4 * h]);
                corner[h] = up[h];
                r[i + 4 * h] = left[h];
            }
        }
        transpose4(r);
        transpose4(r + 4);
        for (uint32_t i = 0; i < 8; i++)
            store(at[i], r[i]);
    }
}

/* 8 rows of 8 bytes, two in a vector. */
static inline void transpose_bytes(words4 r[4]) {
    halves8 a[4], b[4];
    for (uint32_t i = 0; i < 4; i++) {
        bytes16 even = (bytes16)r[i], odd = (bytes16)__builtin_shufflevector(r[i], r[i], 2, 3, 2, 3);
        a[i] = (halves8)__builtin_shufflevector(even, odd, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
    }
    for (uint32_t i = 0; i < 4; i += 2) {
        b[i] = __builtin_shufflevector(a[i], a[i + 1], 0, 8, 1, 9, 2, 10, 3, 11);
        b[i + 1] = __builtin_shufflevector(a[i], a[i + 1], 4, 12, 5, 13, 6, 14, 7, 15);
    }
    for (uint32_t i = 0; i < 2; i++) {
        r[2 * i] = __builtin_shufflevector((words4)b[i], (words4)b[i + 2], 0, 4, 1, 5);
        r[2 * i + 1] = __builtin_shufflevector((words4)b[i], (words4)b[i + 2], 2, 6, 3, 7);
    }
}

/* The same for the one byte plane of a tile with one channel. The upper 8 bytes of the vectors do not matter. */
static void wave1(uint8_t *texels, size_t pitch, const uint8_t *top, uint32_t width) {
    words4 left = {0}, corner = {0};
    for (uint32_t x = 0; x < width + 7; x += 8) {
        words4 r[4];
        uint8_t *at[8];
        for (uint32_t i = 0; i < 8; i++)
            at[i] = texels + i * pitch + x - i;
        for (uint32_t i = 0; i < 4; i++)
            r[i] = (words4)(longs2){zt__load64(at[2 * i]), zt__load64(at[2 * i + 1])};
        transpose_bytes(r);
        for (uint32_t i = 0; i < 8; i++) {
            words4 row = r[i / 2], up = (words4)(((longs2)left << 8) | (longs2){top[x + i], 0});
            left = restore8(left, up, corner, i % 2 ? __builtin_shufflevector(row, row, 2, 3, 2, 3) : row);
            corner = up;
            r[i / 2] = i % 2 ? __builtin_shufflevector(row, left, 0, 1, 4, 5)
                             : __builtin_shufflevector(left, row, 0, 1, 6, 7);
        }
        transpose_bytes(r);
        for (uint32_t i = 0; i < 8; i++) {
            longs2 rows = (longs2)r[i / 2];
            zt__store64(at[i], rows[i % 2]);
        }
    }
}

/* The same for 8-byte texels, two rows in a vector. */
static void wave16(uint8_t *texels, size_t pitch, const uint8_t *top, uint32_t width) {
    words4 left[4] = {{0}}, corner[4] = {{0}};
    for (uint32_t x = 0; x < width + 7; x += 2) {
        words4 r[2][4];
        uint8_t *at[8];
        for (uint32_t i = 0; i < 8; i++)
            at[i] = texels + i * pitch + (size_t)x * 8 - i * 8;
        for (uint32_t h = 0; h < 4; h++) {
            words4 a = load(at[2 * h]), b = load(at[2 * h + 1]);
            r[0][h] = __builtin_shufflevector(a, b, 0, 1, 4, 5);
            r[1][h] = __builtin_shufflevector(a, b, 2, 3, 6, 7);
        }
        for (uint32_t i = 0; i < 2; i++) {
            words4 above = (words4)(longs2){0, zt__load64(top + (size_t)(x + i) * 8)};
            for (uint32_t h = 0; h < 4; h++) {
                words4 up = __builtin_shufflevector(above, left[h], 2, 3, 4, 5);
                above = left[h];
                left[h] = restore16(left[h], up, corner[h], r[i][h]);
                corner[h] = up;
                r[i][h] = left[h];
            }
        }
        for (uint32_t h = 0; h < 4; h++) {
            store(at[2 * h], __builtin_shufflevector(r[0][h], r[1][h], 0, 1, 4, 5));
            store(at[2 * h + 1], __builtin_shufflevector(r[0][h], r[1][h], 2, 3, 6, 7));
        }
    }
}

static void interleave8(const uint8_t *r, const uint8_t *g, const uint8_t *b, const uint8_t *a,
                        uint8_t *restrict texels, uint32_t width) {
    for (uint32_t x = 0; x < width; x++) {
        uint32_t v = r[x] | (uint32_t)g[x] << 8 | (uint32_t)b[x] << 16 | (uint32_t)a[x] << 24;
        memcpy(texels + (size_t)x * 4, &v, sizeof v);
    }
}

static void interleave16(const uint8_t *high, const uint8_t *low, uint8_t *restrict texels, uint32_t width) {
    for (uint32_t x = 0; x < width; x++) {
        uint16_t z = (uint16_t)(high[x] << 8 | low[x]), r = (uint16_t)(z >> 1 ^ (0 - (z & 1)));
        memcpy(texels + (size_t)x * 8, &r, sizeof r);
    }
}

/* A row of residuals as texels of 4 channels, missing ones zero. */
static void interleave(const zt__pred_job *job, uint32_t row, uint8_t *texels) {
    uint32_t bytes = job->shape.channel_bytes;
    const uint8_t *high[4] = {job->none, job->none, job->none, job->none}, *low[4];
    memcpy(low, high, sizeof low);
    for (uint32_t j = 0; j < job->shape.channels; j++) {
        uint32_t c = zt__pred_channel(job->shape.channels, j);
        high[c] = job->residuals[j * bytes] + row * job->pitch;
        low[c] = job->residuals[(j + 1) * bytes - 1] + row * job->pitch;
    }
    if (bytes == 1)
        interleave8(low[0], low[1], low[2], low[3], texels, job->shape.width);
    for (uint32_t c = 0; bytes == 2 && c < 4; c++)
        interleave16(high[c], low[c], texels + 2 * c, job->shape.width);
}

/* A row of texels of 4 channels with the second one added to the first and the third. */
static void add_green8(uint8_t *restrict texels, uint32_t width) {
    for (uint32_t x = 0; x < width; x++) {
        uint32_t v, even;
        memcpy(&v, texels + (size_t)x * 4, sizeof v);
        even = (v & 0xFF00FF) + (v >> 8 & 0xFF) * 0x10001;
        v = (even & 0xFF00FF) | (v & 0xFF00FF00);
        memcpy(texels + (size_t)x * 4, &v, sizeof v);
    }
}

static void add_green16(uint8_t *restrict texels, uint32_t width) {
    const uint64_t evens = UINT64_C(0x0000FFFF0000FFFF);
    for (uint32_t x = 0; x < width; x++) {
        uint64_t v, green;
        memcpy(&v, texels + (size_t)x * 8, sizeof v);
        green = v >> 16 & 0xFFFF;
        v = (((v & evens) + (green << 32 | green)) & evens) | (v & ~evens);
        memcpy(texels + (size_t)x * 8, &v, sizeof v);
    }
}

/* A row of texels of 4 channels to those of the tile. */
static void finish(const zt__pred_job *job, const uint8_t *texels, uint8_t *restrict dst) {
    uint32_t bytes = job->shape.channel_bytes, n = job->shape.channels * bytes, width = job->shape.width;
    if (job->shape.channels == 4) {
        memcpy(dst, texels, (size_t)width * n);
        if (job->colour)
            (bytes == 2 ? add_green16 : add_green8)(dst, width);
        return;
    }
    uint8_t green = job->colour ? 0xFF : 0;
    for (uint32_t x = 0; n == 3 && x < width; x++) {
        const uint8_t *v = texels + 4 * (size_t)x;
        dst[3 * (size_t)x] = (uint8_t)(v[0] + (v[1] & green));
        dst[3 * (size_t)x + 1] = v[1];
        dst[3 * (size_t)x + 2] = (uint8_t)(v[2] + (v[1] & green));
    }
    for (uint32_t x = 0; (n & 1) == 0 && x < width; x++) { /* 2, 4 or 6 bytes */
        uint8_t texel[8];
        memcpy(texel, texels + (size_t)x * 4 * bytes, 4 * (size_t)bytes);
        if (green) /* only with 3 channels: of 2 bytes here */
            add_green16(texel, 1);
        for (uint32_t i = 0; i < n; i++)
            dst[(size_t)x * n + i] = texel[i];
    }
}

/* The one plane of a tile is its texels. */
static void restore_one(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch) {
    size_t width = job->shape.width;
    for (uint32_t i = 0; i < rows; i++)
        memcpy(job->texels + i * job->texel_pitch, job->residuals[0] + i * job->pitch, width);
    wave1(job->texels, job->texel_pitch, job->top, job->shape.width);
    for (uint32_t i = 0; i < rows; i++)
        memcpy(dst + i * dst_pitch, job->texels + i * job->texel_pitch, width);
    memcpy(job->top, job->texels + (ZT__PRED_STRIP - 1) * job->texel_pitch, width);
}

/* A strip with fewer than 8 rows is restored as one of 8, the rest being whatever was there. */
void zt__pred_restore_vector(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch) {
    bool wide = job->shape.channel_bytes == 2;
    if (job->planes == 1) { /* of four channels three would be for nothing */
        restore_one(job, rows, dst, dst_pitch);
        return;
    }
    for (uint32_t i = 0; i < rows; i++)
        interleave(job, i, job->texels + i * job->texel_pitch);
    (wide ? wave16 : wave8)(job->texels, job->texel_pitch, job->top, job->shape.width);
    for (uint32_t i = 0; i < rows; i++)
        finish(job, job->texels + i * job->texel_pitch, dst + i * dst_pitch);
    memcpy(job->top, job->texels + (ZT__PRED_STRIP - 1) * job->texel_pitch, (size_t)job->shape.width * (wide ? 8 : 4));
}

const zt__pred_kernel *zt__pred_kernel_vector(void) {
    static const zt__pred_kernel kernel = {"vector",           zt__pred_select_c,       zt__pred_symbols_c,
                                           zt__pred_measure_c, zt__pred_restore_vector, NULL};
    return &kernel;
}

#else

const zt__pred_kernel *zt__pred_kernel_vector(void) {
    return NULL;
}

#endif
