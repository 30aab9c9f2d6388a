/* SPDX-License-Identifier: Apache-2.0 */
#include "base_hash.h"

#define XXH_STATIC_LINKING_ONLY /* for the size of the state: nothing else of it is used */
#include <xxhash.h>

_Static_assert(sizeof(XXH3_state_t) <= sizeof(((zt__hasher *)0)->state), "zt__hasher has room for the state");
_Static_assert(_Alignof(XXH3_state_t) <= 64, "zt__hasher is aligned for the state");

static uint64_t hash(const void *data, size_t size) {
    return XXH3_64bits(data, size);
}

static void begin(zt__hasher *hasher) {
    XXH3_64bits_reset((XXH3_state_t *)(void *)hasher->state);
}

static void more(zt__hasher *hasher, const void *data, size_t size) {
    XXH3_64bits_update((XXH3_state_t *)(void *)hasher->state, data, size);
}

static uint64_t end(const zt__hasher *hasher) {
    return XXH3_64bits_digest((const XXH3_state_t *)(const void *)hasher->state);
}

const zt__hash_kernel *zt__hash_kernel_library(void) {
    static const zt__hash_kernel kernel = {hash, begin, more, end};
    return &kernel;
}

static const zt__hash_kernel *best(void) {
    const zt__hash_kernel *kernel = zt__hash_kernel_avx512();
    kernel = kernel ? kernel : zt__hash_kernel_avx2();
    return kernel ? kernel : zt__hash_kernel_library();
}

uint64_t zt__hash(const void *data, size_t size) {
    return best()->hash(data, size);
}

void zt__hash_begin(zt__hasher *hasher) {
    best()->begin(hasher);
}

void zt__hash_more(zt__hasher *hasher, const void *data, size_t size) {
    best()->more(hasher, data, size);
}

uint64_t zt__hash_end(const zt__hasher *hasher) {
    return best()->end(hasher);
}

void zt__hash_rows_more(zt__hasher *hasher, const void *rows, size_t row_size, size_t count, size_t pitch) {
    const unsigned char *row = rows;
    const zt__hash_kernel *kernel = best();
    if (pitch == row_size) {
        kernel->more(hasher, row, row_size * count);
        return;
    }
    for (size_t y = 0; y < count; y++)
        kernel->more(hasher, row + y * pitch, row_size);
}

uint64_t zt__hash_rows(const void *rows, size_t row_size, size_t count, size_t pitch) {
    zt__hasher hasher;
    if (pitch == row_size)
        return zt__hash(rows, row_size * count);
    zt__hash_begin(&hasher);
    zt__hash_rows_more(&hasher, rows, row_size, count, pitch);
    return zt__hash_end(&hasher);
}
