/* SPDX-License-Identifier: Apache-2.0 */
/* XXH3-64, the checksum of the format (spec/ztex.md section 2). */
#ifndef ZT_BASE_HASH_H
#define ZT_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>

uint64_t zt__hash(const void *data, size_t size);

/* The same in pieces. The state is xxHash's, on the caller's stack. */
typedef struct zt__hasher {
    _Alignas(64) unsigned char state[640];
} zt__hasher;

void zt__hash_begin(zt__hasher *hasher);
void zt__hash_more(zt__hasher *hasher, const void *data, size_t size);
uint64_t zt__hash_end(const zt__hasher *hasher);

/* Rows as if there were nothing between them. */
void zt__hash_rows_more(zt__hasher *hasher, const void *rows, size_t row_size, size_t count, size_t pitch);
uint64_t zt__hash_rows(const void *rows, size_t row_size, size_t count, size_t pitch);

/* What the functions above choose from; one hash is begun and ended by the same. */
typedef struct zt__hash_kernel {
    uint64_t (*hash)(const void *data, size_t size);
    void (*begin)(zt__hasher *hasher);
    void (*more)(zt__hasher *hasher, const void *data, size_t size);
    uint64_t (*end)(const zt__hasher *hasher);
} zt__hash_kernel;

const zt__hash_kernel *zt__hash_kernel_library(void);
/* NULL where the machine or the compiler has none. */
const zt__hash_kernel *zt__hash_kernel_avx2(void);
const zt__hash_kernel *zt__hash_kernel_avx512(void);

#endif
