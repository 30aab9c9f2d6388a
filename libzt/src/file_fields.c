/* SPDX-License-Identifier: Apache-2.0 */
#include "file_fields.h"

#include <string.h>

const zt__fields *zt__find_fields(uint32_t format) {
    static const zt__fields bc1 = {{4, 4}, 8}, bc3 = {{2, 6, 4, 4}, 16}, bc4 = {{2, 6}, 8}, bc5 = {{2, 6, 2, 6}, 16},
                            bc7 = {{8, 8}, 16};
    switch (format) {
    case 131: /* RGB and RGBA, UNORM and SRGB */
    case 132:
    case 133:
    case 134:
        return &bc1;
    case 137:
    case 138:
        return &bc3;
    case 139:
    case 140:
        return &bc4;
    case 141:
    case 142:
        return &bc5;
    case 145:
    case 146:
        return &bc7;
    default:
        return NULL;
    }
}

/* size is a constant where these are inlined, so that a field is one or two instructions. */
static inline void copy_apart(const uint8_t *restrict blocks, size_t step, size_t size, size_t n,
                              uint8_t *restrict field) {
    for (size_t i = 0; i < n; i++)
        memcpy(field + i * size, blocks + i * step, size);
}

static inline void copy_together(const uint8_t *restrict field, size_t step, size_t size, size_t n,
                                 uint8_t *restrict blocks) {
    for (size_t i = 0; i < n; i++)
        memcpy(blocks + i * step, field + i * size, size);
}

static void move_apart(const uint8_t *blocks, size_t step, size_t size, size_t n, uint8_t *field) {
    switch (size) {
    case 2:
        copy_apart(blocks, step, 2, n, field);
        break;
    case 4:
        copy_apart(blocks, step, 4, n, field);
        break;
    case 6:
        copy_apart(blocks, step, 6, n, field);
        break;
    default:
        copy_apart(blocks, step, 8, n, field);
    }
}

static void move_together(const uint8_t *field, size_t step, size_t size, size_t n, uint8_t *blocks) {
    switch (size) {
    case 2:
        copy_together(field, step, 2, n, blocks);
        break;
    case 4:
        copy_together(field, step, 4, n, blocks);
        break;
    case 6:
        copy_together(field, step, 6, n, blocks);
        break;
    default:
        copy_together(field, step, 8, n, blocks);
    }
}

void zt__fields_apart(const zt__fields *fields, const uint8_t *blocks, size_t count, uint8_t *apart) {
    size_t step = fields->block_bytes;
    for (size_t i = 0, at = 0; at < step; at += fields->sizes[i++])
        move_apart(blocks + at, step, fields->sizes[i], count, apart + count * at);
}

void zt__fields_together(const zt__fields *fields, const uint8_t *apart, size_t count, size_t from, size_t n,
                         uint8_t *blocks) {
    size_t step = fields->block_bytes;
    for (size_t i = 0, at = 0; at < step; at += fields->sizes[i++])
        move_together(apart + count * at + from * fields->sizes[i], step, fields->sizes[i], n, blocks + at);
}
