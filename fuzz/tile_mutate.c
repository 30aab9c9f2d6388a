/* SPDX-License-Identifier: Apache-2.0 */
/* Changes to the fields of a tile in the predicted codec. What the changed tile means does not matter. */
#include "tile.h"

/* Where the parts of an input begin; each at most its size. */
typedef struct parts {
    size_t maps, bits, states, words;
} parts;

static uint32_t get_bit(const tile *t, uint64_t at) {
    return at >> 3 < t->size ? (uint32_t)t->stored[at >> 3] >> (at & 7) & 1u : 1;
}

/* The end of a table that begins at bit at, or behind the stored bytes. */
static uint64_t skip_table(const tile *t, uint64_t at) {
    int32_t length = 8;
    uint32_t sum = 0;
    for (uint32_t i = 0; i < 256 && sum < TILE_SLOTS && at < 8 * (uint64_t)t->size; i++) {
        int32_t z = 0;
        while (!get_bit(t, at + (uint64_t)z))
            z++;
        at += (uint64_t)z + 1;
        length += z % 2 ? -(z + 1) / 2 : z / 2;
        if (length < 0 || length > 11)
            return 8 * (uint64_t)t->size;
        uint32_t v = 1u << length;
        for (int32_t b = 0; b < length; b++)
            v |= get_bit(t, at++) << b;
        sum += v - 1;
    }
    return at;
}

static size_t at_most(uint64_t at, size_t size) {
    return at < size ? (size_t)at : size;
}

static parts find_parts(const tile *t, size_t size) {
    uint32_t flags = t->size > 0 ? t->stored[0] : 0, tables = t->size > 1 ? t->stored[1] : 0;
    uint32_t coded = t->size > 2 ? t->stored[2] : 0, planes = (uint32_t)__builtin_popcount(coded);
    uint32_t lanes = 16u << (flags >> 2 & 3);
    uint64_t maps = 3 + t->channels * t->channel_bytes, bits = maps + 8 * (uint64_t)planes, end = 8 * bits;
    if (flags & 2)
        end += (uint64_t)planes * ((t->width + 63) / 64) * ((t->height + 7) / 8);
    for (uint32_t i = 0; i < tables && i < TILE_TABLES; i++)
        end = skip_table(t, end);
    uint64_t states = (end + 7) / 8;
    return (parts){at_most(TILE_HEAD + maps, size), at_most(TILE_HEAD + bits, size), at_most(TILE_HEAD + states, size),
                   at_most(TILE_HEAD + states + 4 * (uint64_t)lanes, size)};
}

/* One of the bytes from from to to - 1, when there are any. */
static void change_byte(fuzz_random *random, uint8_t *input, size_t from, size_t to) {
    if (from >= to)
        return;
    uint8_t *p = input + from + fuzz_below(random, (uint32_t)(to - from));
    switch (fuzz_below(random, 4)) {
    case 0:
        *p ^= (uint8_t)(1u << fuzz_below(random, 8));
        break;
    case 1:
        *p = (uint8_t)fuzz_next(random);
        break;
    case 2:
        *p = fuzz_below(random, 2) ? 255 : 0;
        break;
    default:
        *p = (uint8_t)(*p + (fuzz_below(random, 2) ? 1 : -1));
    }
}

static void change_state(fuzz_random *random, uint8_t *input, const parts *p) {
    static const uint32_t special[] = {0, 0x7FFF, 0x8000, 0x8001, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF};
    if (p->words - p->states < 4)
        return;
    uint8_t *state = input + p->states + 4 * fuzz_below(random, (uint32_t)(p->words - p->states) / 4);
    uint32_t i = fuzz_below(random, 12);
    fuzz_store(state, i < 9 ? special[i] : fuzz_next(random) & 0x7FFFFFFF, 4);
}

/* Words changed, taken out, put in or moved. */
static size_t change_words(fuzz_random *random, uint8_t *input, size_t size, size_t max_size, size_t words) {
    size_t count = (size - words) / 2, at = words + 2 * (size_t)fuzz_below(random, (uint32_t)count + 1);
    switch (fuzz_below(random, 4)) {
    case 0:
        if (count > 0)
            fuzz_store(input + words + 2 * (size_t)fuzz_below(random, (uint32_t)count),
                       fuzz_below(random, 3) ? fuzz_next(random) & 0xFFFF : fuzz_below(random, 2) * 0xFFFF, 2);
        return size;
    case 1: /* the rest of them, from a word on */
        return fuzz_below(random, 2) ? at : size > words ? size - 1 : size;
    case 2:
        if (max_size - size < 2)
            return size;
        memmove(input + at + 2, input + at, size - at);
        fuzz_store(input + at, fuzz_next(random) & 0xFFFF, 2);
        return size + 2;
    default:
        if (at + 2 > size)
            return size;
        memmove(input + at, input + at + 2, size - at - 2);
        return size - 2;
    }
}

/* The same bytes for a tile of another shape. */
static void change_shape(fuzz_random *random, uint8_t *input) {
    tile t;
    tile_parse(&t, input, TILE_HEAD);
    switch (fuzz_below(random, 5)) {
    case 0:
        t.width = t.width > 1 && fuzz_below(random, 2) ? t.width - 1 : t.width + 1;
        break;
    case 1:
        t.height = t.height > 1 && fuzz_below(random, 2) ? t.height - 1 : t.height + 1;
        break;
    case 2:
        t.channels = 1 + fuzz_below(random, 4);
        break;
    case 3:
        t.channel_bytes = 3 - t.channel_bytes;
        break;
    default:
        t.fields = t.fields ? 1 + fuzz_below(random, TILE_FIELD_FORMATS) : 0;
        t.width = 1 + fuzz_below(random, fuzz_below(random, 4) ? 16 : TILE_WIDTH);
        t.height = 1 + fuzz_below(random, 12);
    }
    t.gap = fuzz_below(random, 8);
    tile_store_head(&t, input);
}

/* A tile with a frame: mostly what stands before the first block's content. */
static size_t change_frame(fuzz_random *random, uint8_t *input, size_t size, size_t max_size) {
    size_t head = at_most(TILE_HEAD + 16, size);
    switch (fuzz_below(random, 8)) {
    case 0:
    case 1:
        change_byte(random, input, TILE_HEAD, head);
        return size;
    case 2:
    case 3:
    case 4:
        change_byte(random, input, TILE_HEAD, size);
        return size;
    case 5:
        change_shape(random, input);
        return size;
    case 6:
        return TILE_HEAD + fuzz_below(random, (uint32_t)(size - TILE_HEAD) + 1);
    default:
        return TILE_HEAD + LLVMFuzzerMutate(input + TILE_HEAD, size - TILE_HEAD, max_size - TILE_HEAD);
    }
}

size_t tile_mutate(fuzz_random *random, uint8_t *input, size_t size, size_t max_size) {
    tile t;
    tile_parse(&t, input, size);
    if (tile_has_frame(&t))
        return change_frame(random, input, size, max_size);
    parts p = find_parts(&t, size);
    switch (fuzz_below(random, 12)) {
    case 0: /* flags, tables, planes, first texel */
        change_byte(random, input, TILE_HEAD, p.maps);
        return size;
    case 1:
        change_byte(random, input, p.maps, p.bits);
        return size;
    case 2:
    case 3:
        change_byte(random, input, p.bits, p.states);
        return size;
    case 4:
    case 5:
        change_state(random, input, &p);
        return size;
    case 6:
    case 7:
    case 8:
        return change_words(random, input, size, max_size, p.words);
    case 9:
        change_shape(random, input);
        return size;
    case 10: /* the end cut off */
        return TILE_HEAD + fuzz_below(random, (uint32_t)(size - TILE_HEAD) + 1);
    default:
        return TILE_HEAD + LLVMFuzzerMutate(input + TILE_HEAD, size - TILE_HEAD, max_size - TILE_HEAD);
    }
}
