/* SPDX-License-Identifier: Apache-2.0 */
/* The fields of block formats, for tiles of codec 4 (spec/ztex.md section 6.5). */
#ifndef ZT_FILE_FIELDS_H
#define ZT_FILE_FIELDS_H

#include <stddef.h>
#include <stdint.h>

enum { ZT__MOST_FIELDS = 4 };

/* Bytes of each field of a block; they sum to block_bytes. */
typedef struct zt__fields {
    uint8_t sizes[ZT__MOST_FIELDS]; /* 0 behind the last one */
    uint8_t block_bytes;
} zt__fields;

/* NULL: codec 4 is not for the format. */
const zt__fields *zt__find_fields(uint32_t format);

/* Puts the fields of count blocks apart; blocks and apart do not overlap. */
void zt__fields_apart(const zt__fields *fields, const uint8_t *blocks, size_t count, uint8_t *apart);

/* And back, of the count blocks at apart those from `from` to from + n - 1. */
void zt__fields_together(const zt__fields *fields, const uint8_t *apart, size_t count, size_t from, size_t n,
                         uint8_t *blocks);

#endif
