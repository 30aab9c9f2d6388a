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

#endif
