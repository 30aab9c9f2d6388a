/* SPDX-License-Identifier: Apache-2.0 */
/* XXH3-64 compiled for AVX2 and AVX-512 gives what the library gives, at once, in pieces and by rows, whatever the size
 * and the place. Matters because a file made on one machine is checked on another. */
#include <string.h>

#include "base_hash.h"
#include "test.h"

enum { BYTES = 6000 };

static unsigned char bytes[BYTES + 64];

/* In up to 8 pieces. */
static uint64_t in_pieces(const zt__hash_kernel *kernel, const unsigned char *data, size_t size, uint64_t seed) {
    zt__hasher hasher;
    kernel->begin(&hasher);
    for (int i = 0; i < 7; i++) {
        size_t piece = test_below(&seed, (uint32_t)size + 1);
        kernel->more(&hasher, data, piece);
        data += piece;
        size -= piece;
    }
    kernel->more(&hasher, data, size);
    return kernel->end(&hasher);
}

static void compare(const zt__hash_kernel *kernel, size_t size, uint64_t *seed) {
    const unsigned char *data = bytes + test_below(seed, 64);
    uint64_t expected = zt__hash_kernel_library()->hash(data, size);
    CHECK(kernel->hash(data, size) == expected);
    CHECK(in_pieces(kernel, data, size, test_random(seed)) == expected);
    CHECK(zt__hash(data, size) == expected);
    CHECK(zt__hash_rows(data, size, 1, size + 1) == expected);
}

/* Rows with something between them, against the same rows without. */
static void compare_rows(size_t row_size, size_t count, size_t pitch) {
    unsigned char tight[BYTES];
    for (size_t y = 0; y < count; y++)
        memcpy(tight + y * row_size, bytes + y * pitch, row_size);
    CHECK(zt__hash_rows(bytes, row_size, count, pitch) == zt__hash_kernel_library()->hash(tight, row_size * count));
}

int main(void) {
    uint64_t seed = 88172645463325252u;
    const zt__hash_kernel *kernels[] = {zt__hash_kernel_library(), zt__hash_kernel_avx2(), zt__hash_kernel_avx512()};
    for (size_t i = 0; i < sizeof bytes; i++)
        bytes[i] = (unsigned char)test_random(&seed);
    for (int k = 0; k < 3 && kernels[k]; k++)
        for (size_t size = 0; size <= BYTES; size++)
            compare(kernels[k], size, &seed);
    for (size_t row = 1; row < 300; row++)
        compare_rows(row, 17, row + row % 3);
    return test_end();
}
