/* SPDX-License-Identifier: Apache-2.0 */
#include "base_hash_xxh3.h"

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
