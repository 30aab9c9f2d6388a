/* SPDX-License-Identifier: Apache-2.0 */
/* Little-endian bytes, a bounded reading cursor, and arithmetic that notices overflow. */
#ifndef ZT_BASE_BYTES_H
#define ZT_BASE_BYTES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

static inline uint16_t zt__load16(const uint8_t *p) {
    return (uint16_t)(p[0] | p[1] << 8);
}

static inline uint32_t zt__load32(const uint8_t *p) {
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline uint64_t zt__load64(const uint8_t *p) {
    return (uint64_t)zt__load32(p) | (uint64_t)zt__load32(p + 4) << 32;
}

static inline void zt__store16(uint8_t *p, uint16_t v) {
    p[0] = (uint8_t)v;
    p[1] = (uint8_t)(v >> 8);
}

static inline void zt__store32(uint8_t *p, uint32_t v) {
    zt__store16(p, (uint16_t)v);
    zt__store16(p + 2, (uint16_t)(v >> 16));
}

static inline void zt__store64(uint8_t *p, uint64_t v) {
    zt__store32(p, (uint32_t)v);
    zt__store32(p + 4, (uint32_t)(v >> 32));
}

static inline uint64_t zt__bits_of_double(double d) {
    uint64_t u;
    memcpy(&u, &d, sizeof u);
    return u;
}

static inline double zt__double_of_bits(uint64_t u) {
    double d;
    memcpy(&d, &u, sizeof d);
    return d;
}

static inline float zt__float_of_bits(uint32_t u) {
    float f;
    memcpy(&f, &u, sizeof f);
    return f;
}

static inline uint32_t zt__bits_of_float(float f) {
    uint32_t u;
    memcpy(&u, &f, sizeof u);
    return u;
}

/* False when the result does not fit; *out is then untouched. */
static inline bool zt__add64(uint64_t a, uint64_t b, uint64_t *out) {
    if (a > UINT64_MAX - b)
        return false;
    *out = a + b;
    return true;
}

static inline bool zt__mul64(uint64_t a, uint64_t b, uint64_t *out) {
    if (b != 0 && a > UINT64_MAX / b)
        return false;
    *out = a * b;
    return true;
}

/* Narrows to memory sizes: false where size_t is too small. */
static inline bool zt__to_size(uint64_t v, size_t *out) {
    if (v > SIZE_MAX)
        return false;
    *out = (size_t)v;
    return true;
}

/* [offset, offset + length) lies inside [0, size). */
static inline bool zt__range_ok(uint64_t offset, uint64_t length, uint64_t size) {
    return offset <= size && length <= size - offset;
}

/* v <= 2^63. */
static inline uint64_t zt__align16(uint64_t v) {
    return (v + 15) & ~UINT64_C(15);
}

/* Lays out a part of a block: its place, and *size grows up to the next part. Sums are below 2^63. */
static inline uint64_t zt__take_part(uint64_t *size, uint64_t bytes) {
    uint64_t at = *size;
    *size = zt__align16(at + bytes);
    return at;
}

static inline uint64_t zt__ceil_div(uint64_t a, uint64_t b) {
    return a / b + (a % b != 0);
}

static inline uint32_t zt__min32(uint32_t a, uint32_t b) {
    return a < b ? a : b;
}

static inline uint32_t zt__max32(uint32_t a, uint32_t b) {
    return a > b ? a : b;
}

/* floor(log2(v)), v > 0. */
static inline uint32_t zt__log2(uint32_t v) {
    uint32_t n = 0;
    while (v >>= 1)
        n++;
    return n;
}

/* A sticky cursor: reading past the end yields 0 and sets bad, which is tested before any value sizes a loop or a
 * block. */
typedef struct zt__cursor {
    const uint8_t *data;
    size_t size, at;
    bool bad;
} zt__cursor;

static inline zt__cursor zt__cursor_of(const uint8_t *data, size_t size) {
    zt__cursor c = {data, size, 0, false};
    return c;
}

static inline const uint8_t *zt__take(zt__cursor *c, size_t n) {
    if (c->bad || n > c->size - c->at) {
        c->bad = true;
        return NULL;
    }
    const uint8_t *p = c->data + c->at;
    c->at += n;
    return p;
}

static inline uint8_t zt__take8(zt__cursor *c) {
    const uint8_t *p = zt__take(c, 1);
    return p ? *p : 0;
}

static inline uint16_t zt__take16(zt__cursor *c) {
    const uint8_t *p = zt__take(c, 2);
    return p ? zt__load16(p) : 0;
}

static inline uint32_t zt__take32(zt__cursor *c) {
    const uint8_t *p = zt__take(c, 4);
    return p ? zt__load32(p) : 0;
}

static inline uint64_t zt__take64(zt__cursor *c) {
    const uint8_t *p = zt__take(c, 8);
    return p ? zt__load64(p) : 0;
}

static inline size_t zt__left(const zt__cursor *c) {
    return c->bad ? 0 : c->size - c->at;
}

#endif
