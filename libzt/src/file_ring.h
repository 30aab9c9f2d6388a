/* SPDX-License-Identifier: Apache-2.0 */
/* Lines (rows or slices of floats) that stream by, filtered along the axis on which they follow each other. */
#ifndef ZT_FILE_RING_H
#define ZT_FILE_RING_H

#include "base_bytes.h"
#include "base_memory.h"
#include "file_kernel.h"

/* Four floats at once; the compilers make plain code of it where the machine has no such registers. */
typedef float zt__v4 __attribute__((vector_size(16)));

static inline zt__v4 zt__load4(const float *p) {
    zt__v4 v;
    memcpy(&v, p, sizeof v);
    return v;
}

static inline void zt__store4(float *p, zt__v4 v) {
    memcpy(p, &v, sizeof v);
}

/*
 * Lines come in the order start, start + 1, ... modulo the axis' n (start is 0 unless the axis repeats); outputs go in
 * the same way from the first whose lines all come after the first line.
 */
typedef struct zt__ring {
    zt__axis axis;
    uint64_t length; /* floats of a line, a multiple of 4 */
    uint32_t start;
    int64_t first_output;
    uint32_t capacity;     /* lines in the ring */
    uint32_t head_count;   /* repeat: the first lines, kept to the end */
    float *lines;          /* the ring, the head, for border a line of zeros */
    bool *negative;        /* of each of these lines */
    uint64_t pushed, done; /* lines, outputs */
} zt__ring;

/* batch: most lines committed at once. On failure zt__ring_free releases what there is. */
zt_result zt__ring_init(zt__ring *ring, zt__memory *memory, const zt__axis *axis, uint64_t length, uint32_t batch,
                        uint32_t start, zt_diag *diag);
void zt__ring_free(zt__ring *ring, zt__memory *memory);
void zt__ring_reset(zt__ring *ring);

/* Where the line that comes behind `ahead` others is to be written; and whether it holds negative values. */
float *zt__ring_slot(zt__ring *ring, uint32_t ahead);
void zt__ring_mark(zt__ring *ring, uint32_t ahead, bool negative);
void zt__ring_commit(zt__ring *ring, uint32_t n);

/* How many outputs, at most `most`, can be made now; and that they have been made. */
uint32_t zt__ring_ready(const zt__ring *ring, uint32_t most);
void zt__ring_take(zt__ring *ring, uint32_t n);
bool zt__ring_complete(const zt__ring *ring);

/* Index of an output in its level, 0 ... n2 - 1. */
uint32_t zt__ring_place(const zt__ring *ring, uint64_t output);
/* Whether a line that it is made of holds negative values. */
bool zt__ring_negative(const zt__ring *ring, uint64_t output);
/* Floats from ... from + length - 1 of an output that is ready. */
void zt__ring_combine(const zt__ring *ring, uint64_t output, uint64_t from, uint64_t length, float *dst);

#endif
