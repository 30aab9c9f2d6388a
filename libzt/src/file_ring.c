/* SPDX-License-Identifier: Apache-2.0 */
#include "file_ring.h"

#include "base_diag.h"
#include "zt/zt.h"

/* The line of zeros, as an index. */
static uint32_t zero_line(const zt__ring *ring) {
    return ring->capacity + ring->head_count;
}

static uint32_t line_count(const zt__ring *ring) {
    return zero_line(ring) + (ring->axis.wrap == ZT_WRAP_BORDER ? 1U : 0U);
}

zt_result zt__ring_init(zt__ring *ring, zt__memory *memory, const zt__axis *axis, uint64_t length, uint32_t batch,
                        uint32_t start, zt_diag *diag) {
    void *block;
    memset(ring, 0, sizeof *ring);
    ring->axis = *axis;
    ring->length = length;
    ring->start = start;
    ring->capacity = axis->taps + batch + 1;
    if (axis->wrap == ZT_WRAP_REPEAT) {
        ring->head_count = zt__min32(axis->n, axis->taps - 1);
        while (zt__axis_first(axis, ring->first_output) < (int64_t)start)
            ring->first_output++;
    }
    uint64_t floats;
    if (!zt__mul64(line_count(ring), length, &floats))
        floats = UINT64_MAX;
    ZT_TRY(zt__alloc_raw(memory, floats, sizeof(float), diag, &block));
    ring->lines = block;
    ZT_TRY(zt__alloc(memory, line_count(ring), sizeof(bool), diag, &block));
    ring->negative = block;
    if (axis->wrap == ZT_WRAP_BORDER)
        memset(ring->lines + zero_line(ring) * length, 0, (size_t)length * sizeof(float));
    return ZT_OK;
}

void zt__ring_free(zt__ring *ring, zt__memory *memory) {
    zt__free(memory, ring->lines, line_count(ring) * ring->length, sizeof(float));
    zt__free(memory, ring->negative, line_count(ring), sizeof(bool));
    ring->lines = NULL;
    ring->negative = NULL;
}

void zt__ring_reset(zt__ring *ring) {
    ring->pushed = 0;
    ring->done = 0;
}

float *zt__ring_slot(zt__ring *ring, uint32_t ahead) {
    return ring->lines + (ring->pushed + ahead) % ring->capacity * ring->length;
}

void zt__ring_mark(zt__ring *ring, uint32_t ahead, bool negative) {
    ring->negative[(ring->pushed + ahead) % ring->capacity] = negative;
}

void zt__ring_commit(zt__ring *ring, uint32_t n) {
    for (uint32_t i = 0; i < n; i++, ring->pushed++) {
        if (ring->pushed >= ring->head_count)
            continue;
        uint64_t slot = ring->pushed % ring->capacity, head = ring->capacity + ring->pushed;
        memcpy(ring->lines + head * ring->length, ring->lines + slot * ring->length,
               (size_t)ring->length * sizeof(float));
        ring->negative[head] = ring->negative[slot];
    }
}

/* Which of the lines since the start index j means: n and more with repeat, going round; -1: zeros. */
static int64_t line_number(const zt__ring *ring, int64_t j) {
    if (ring->axis.wrap == ZT_WRAP_REPEAT)
        return j - (int64_t)ring->start;
    return zt__axis_wrap(&ring->axis, j);
}

static uint32_t line_index(const zt__ring *ring, int64_t j) {
    int64_t number = line_number(ring, j), n = ring->axis.n;
    if (number < 0)
        return zero_line(ring);
    if (number >= n)
        return ring->capacity + (uint32_t)((number - n) % n);
    return (uint32_t)((uint64_t)number % ring->capacity);
}

static int64_t first_of(const zt__ring *ring, uint64_t output) {
    return zt__axis_first(&ring->axis, ring->first_output + (int64_t)output);
}

static bool is_ready(const zt__ring *ring, uint64_t output) {
    if (ring->pushed == ring->axis.n)
        return true;
    int64_t first = first_of(ring, output);
    for (uint32_t t = 0; t < ring->axis.taps; t++) {
        if (line_number(ring, first + (int64_t)t) >= (int64_t)ring->pushed)
            return false;
    }
    return true;
}

uint32_t zt__ring_ready(const zt__ring *ring, uint32_t most) {
    uint32_t n = 0;
    while (n < most && ring->done + n < ring->axis.n2 && is_ready(ring, ring->done + n))
        n++;
    return n;
}

void zt__ring_take(zt__ring *ring, uint32_t n) {
    ring->done += n;
}

bool zt__ring_complete(const zt__ring *ring) {
    return ring->pushed == ring->axis.n && ring->done == ring->axis.n2;
}

uint32_t zt__ring_place(const zt__ring *ring, uint64_t output) {
    return (uint32_t)(((uint64_t)ring->first_output + output) % ring->axis.n2);
}

bool zt__ring_negative(const zt__ring *ring, uint64_t output) {
    int64_t first = first_of(ring, output);
    bool negative = false;
    for (uint32_t t = 0; t < ring->axis.taps; t++)
        negative |= ring->negative[line_index(ring, first + (int64_t)t)];
    return negative;
}

/* As along x, differences to the middle line keep constants exact. Blocks of 16 floats stay in registers. */
static void combine_block(const float *const *lines, const float *weights, uint32_t taps, uint64_t at, float *dst) {
    const float *middle = lines[taps / 2] + at;
    zt__v4 m0 = zt__load4(middle), m1 = zt__load4(middle + 4);
    zt__v4 m2 = zt__load4(middle + 8), m3 = zt__load4(middle + 12);
    zt__v4 s0 = {0}, s1 = {0}, s2 = {0}, s3 = {0};
    for (uint32_t t = 0; t < taps; t++) {
        const float *line = lines[t] + at;
        s0 += weights[t] * (zt__load4(line) - m0);
        s1 += weights[t] * (zt__load4(line + 4) - m1);
        s2 += weights[t] * (zt__load4(line + 8) - m2);
        s3 += weights[t] * (zt__load4(line + 12) - m3);
    }
    zt__store4(dst, m0 + s0);
    zt__store4(dst + 4, m1 + s1);
    zt__store4(dst + 8, m2 + s2);
    zt__store4(dst + 12, m3 + s3);
}

void zt__ring_combine(const zt__ring *ring, uint64_t output, uint64_t from, uint64_t length, float *dst) {
    uint32_t taps = ring->axis.taps;
    float weights[ZT__MAX_TAPS];
    const float *lines[ZT__MAX_TAPS];
    int64_t first = first_of(ring, output);
    zt__axis_weights(&ring->axis, ring->first_output + (int64_t)output, weights);
    for (uint32_t t = 0; t < taps; t++)
        lines[t] = ring->lines + line_index(ring, first + (int64_t)t) * ring->length + from;
    uint64_t at = 0;
    for (; at + 16 <= length; at += 16)
        combine_block(lines, weights, taps, at, dst + at);
    for (; at < length; at += 4) {
        zt__v4 middle = zt__load4(lines[taps / 2] + at), sum = {0};
        for (uint32_t t = 0; t < taps; t++)
            sum += weights[t] * (zt__load4(lines[t] + at) - middle);
        zt__store4(dst + at, middle + sum);
    }
}
