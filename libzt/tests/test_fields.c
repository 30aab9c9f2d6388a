/* SPDX-License-Identifier: Apache-2.0 */
/* Tiles of codec 4: the fields of blocks lie where the specification says and come together again, in whole tiles and
 * in parts, without touching a byte outside; tiles that any effort codes decode to their blocks and none is larger than
 * with codec 1; damaged tiles break a rule and nothing else. */
#define _DEFAULT_SOURCE
#include <stdlib.h>
#include <string.h>

#include "base_hash.h"
#include "fence.h"
#include "file_codec.h"
#include "test.h"

static uint64_t seed = 88172645463325252u;

static uint32_t below(uint32_t n) {
    return test_below(&seed, n);
}

/* From the table of section 6.5. */
static const struct {
    uint32_t first, last, fields[5]; /* formats; bytes, 0 behind the last */
} table[] = {
    {131, 134, {4, 4}}, {137, 138, {2, 6, 4, 4}}, {139, 140, {2, 6}}, {141, 142, {2, 6, 2, 6}}, {145, 146, {8, 8}}};
enum { ROWS = sizeof table / sizeof table[0] };

static void formats_are_right(void) {
    for (uint32_t format = 0; format < 1100; format++) {
        const zt__fields *fields = zt__find_fields(format);
        const uint32_t *expected = NULL;
        for (uint32_t i = 0; i < ROWS; i++)
            expected = format >= table[i].first && format <= table[i].last ? table[i].fields : expected;
        CHECK((fields != NULL) == (expected != NULL));
        uint32_t sum = 0;
        for (uint32_t i = 0; fields && expected && i < ZT__MOST_FIELDS; i++) {
            CHECK(fields->sizes[i] == expected[i]);
            sum += expected[i];
        }
        CHECK(!fields || (fields->block_bytes == sum && zt_find_format(format)->block_bytes == sum));
    }
}

/* Byte o + k of block j is byte count x o + s x j + k, o and s being place and size of its field. */
static void places_are_right(const zt__fields *fields, size_t count) {
    size_t size = count * fields->block_bytes, from = below((uint32_t)count), n = below((uint32_t)(count - from) + 1);
    fence source = fence_open(size), result = fence_open(size);
    uint8_t *blocks = fence_block(&source, size, below(2) != 0), *apart = fence_block(&result, size, below(2) != 0);
    for (size_t i = 0; i < size; i++)
        blocks[i] = (uint8_t)below(256);
    zt__fields_apart(fields, blocks, count, apart);
    for (size_t j = 0; j < count; j++)
        for (size_t i = 0, o = 0; o < fields->block_bytes; o += fields->sizes[i++])
            CHECK(memcmp(blocks + j * fields->block_bytes + o, apart + count * o + j * fields->sizes[i],
                         fields->sizes[i]) == 0);
    uint8_t *part = malloc(size), *expected = malloc(size);
    CHECK(part && expected);
    memcpy(expected, blocks, size);
    memcpy(part, apart, size);
    zt__fields_together(fields, part, count, 0, count, blocks);
    CHECK(memcmp(blocks, expected, size) == 0);
    blocks = fence_block(&source, n * fields->block_bytes, below(2) != 0);
    zt__fields_together(fields, part, count, from, n, blocks);
    CHECK(memcmp(blocks, expected + from * fields->block_bytes, n * fields->block_bytes) == 0);
    fence_close(&source);
    fence_close(&result);
    free(part);
    free(expected);
}

/* Kinds of blocks: noise; fields that repeat themselves apart from each other; whole blocks that do. */
static void paint(const zt__fields *fields, uint32_t content, size_t count, uint8_t *blocks) {
    uint8_t some[40][16];
    for (size_t i = 0; i < sizeof some; i++)
        some[i / 16][i % 16] = (uint8_t)below(256);
    for (size_t j = 0; j < count; j++) {
        uint32_t pick = below(40);
        for (uint32_t i = 0; i < fields->block_bytes; i++) {
            uint8_t *byte = blocks + j * fields->block_bytes + i;
            uint32_t at_field = fields->block_bytes == 16 && fields->sizes[0] == 8 ? i / 2 : i % 8;
            if (content == 0)
                *byte = (uint8_t)below(256);
            else if (content == 1)
                *byte = (uint8_t)(at_field < 4 ? j / 16 * 3 + i : below(256));
            else
                *byte = some[pick][i];
        }
    }
}

typedef struct coding {
    zt__encoder encoder;
    zt__decoder decoder;
    zt__tile_form form;
    size_t row_size, rows, size;
    uint8_t *blocks, *coded, *out;
} coding;

/* Decodes into rows with a gap. Returns what the sink says. */
static zt_result decode(coding *c, const uint8_t *stored, size_t size, uint64_t hash) {
    zt__sink sink = {0};
    return zt__decode_fields(&sink, &c->decoder, c->form.fields, c->row_size, c->rows, stored, size, c->out,
                             c->row_size + 3, hash, 0);
}

static void mutations(coding *c, size_t stored, uint64_t hash) {
    uint8_t *damaged = malloc(stored);
    CHECK(damaged != NULL);
    for (int i = 0; i < 40; i++) {
        memcpy(damaged, c->coded, stored);
        damaged[below((uint32_t)stored)] ^= (uint8_t)(1u << below(8));
        zt_result result = decode(c, damaged, below(4) ? stored : below((uint32_t)stored) + 1, hash);
        CHECK(result == ZT_CORRUPT || result == ZT_OK);
    }
    free(damaged);
}

/* Returns the codec that was chosen. */
static uint8_t round_trip(coding *c, uint32_t content, uint32_t effort) {
    uint8_t codec = 0;
    size_t plain, stored;
    const zt__fields *fields = c->form.fields;
    paint(fields, content, c->size / fields->block_bytes, c->blocks);
    c->encoder.level = zt__level_of_effort(effort);
    CHECK(zt__encode_tile(&c->encoder, effort, NULL, c->blocks, c->size, c->coded, zt__encode_bound(c->size), &codec,
                          &plain, NULL) == ZT_OK);
    CHECK(zt__encode_tile(&c->encoder, effort, &c->form, c->blocks, c->size, c->coded, zt__encode_bound(c->size),
                          &codec, &stored, NULL) == ZT_OK);
    CHECK(stored <= plain || effort <= 4);
    CHECK(stored < c->size || codec == ZT__CODEC_RAW);
    if (codec != ZT__CODEC_FIELDS)
        return codec;
    uint64_t hash = zt__hash(c->blocks, c->size);
    memset(c->out, 0xA5, c->size + 3 * c->rows);
    CHECK(decode(c, c->coded, stored, hash) == ZT_OK);
    for (size_t y = 0; y < c->rows; y++) {
        const uint8_t *row = c->out + y * (c->row_size + 3);
        CHECK(memcmp(row, c->blocks + y * c->row_size, c->row_size) == 0);
        CHECK(row[c->row_size] == 0xA5 && row[c->row_size + 2] == 0xA5);
    }
    CHECK(decode(c, c->coded, stored, hash + 1) == ZT_CORRUPT);
    mutations(c, stored, hash);
    return codec;
}

static void tiles(void) {
    zt__memory memory;
    uint32_t chosen[5] = {0};
    coding c = {0};
    zt__memory_init(&memory, NULL, UINT64_C(1) << 30);
    CHECK(zt__encoder_init(&c.encoder, &memory, 3, false, NULL) == ZT_OK);
    zt__decoder_init(&c.decoder, &memory);
    for (uint32_t i = 0; i < ROWS * 3 * 9; i++) {
        c.form.fields = zt__find_fields(table[i % ROWS].first);
        c.row_size = (size_t)(1 + below(70)) * c.form.fields->block_bytes;
        c.rows = 1 + below(30);
        c.size = c.row_size * c.rows;
        c.blocks = malloc(c.size);
        c.coded = malloc(zt__encode_bound(c.size));
        c.out = malloc(c.size + 3 * c.rows);
        CHECK(c.blocks && c.coded && c.out);
        chosen[round_trip(&c, i / ROWS % 3, 1 + i / (3 * ROWS))]++;
        free(c.blocks);
        free(c.coded);
        free(c.out);
    }
    CHECK(chosen[ZT__CODEC_RAW] > 0 && chosen[ZT__CODEC_ZSTD] > 0 && chosen[ZT__CODEC_FIELDS] > 10);
    zt__encoder_free(&c.encoder);
    zt__decoder_free(&c.decoder);
}

int main(void) {
    formats_are_right();
    for (uint32_t i = 0; i < 400; i++)
        places_are_right(zt__find_fields(table[i % ROWS].first), 1 + below(i < 40 ? 8 : 700));
    tiles();
    return test_end();
}
