/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Planes: every array comes back bit by bit, the form is the smallest and always the same, and every damage to a header
 * is refused with its rule. Zipmaps are made of planes: a wrong sum here moves patches.
 */
#include <stdlib.h>

#include "base_hash.h"
#include "file_codec.h"
#include "test.h"

static zt__memory memory;
static zt__decoder decoder;
static zt__encoder encoder;

typedef struct coded {
    uint8_t *bytes;
    size_t size;
} coded;

static coded encode(uint32_t size, uint32_t count, const void *src) {
    size_t bound = zt__plane_bound(size, count);
    coded c = {malloc(bound), 0};
    void *scratch = malloc((size_t)2 * size * count + 1);
    CHECK(zt__encode_plane(&encoder, size, count, src, scratch, c.bytes, bound, &c.size, NULL) == ZT_OK);
    CHECK(c.size <= bound && c.size <= ZT__PLANE_HEADER_SIZE + (size_t)size * count);
    free(scratch);
    return c;
}

static uint32_t decode(const uint8_t *bytes, size_t stored, uint32_t size, uint32_t count, void *dst) {
    zt_diag diag = {0};
    zt__sink sink = {.diag = &diag};
    uint8_t *copy = malloc(stored + 1);
    memcpy(copy, bytes, stored);
    zt__cursor in = zt__cursor_of(copy, stored);
    zt_result r = zt__decode_plane(&sink, &decoder, &in, 500, size, count, dst);
    CHECK((r == ZT_OK) == (diag.rule == 0) && (r != ZT_OK || zt__left(&in) == 0));
    free(copy);
    return diag.rule;
}

static void put(uint8_t *p, uint32_t size, uint64_t v) {
    if (size == 8)
        memcpy(p, &v, 8);
    uint32_t v4 = (uint32_t)v;
    uint16_t v2 = (uint16_t)v;
    if (size == 4)
        memcpy(p, &v4, 4);
    if (size == 2)
        memcpy(p, &v2, 2);
    if (size == 1)
        *p = (uint8_t)v;
}

/* Kinds of data, made so that each form wins somewhere. */
static uint64_t element(int kind, uint64_t i, uint64_t *seed) {
    switch (kind) {
    case 0:
        return test_random(seed);
    case 1:
        return UINT64_MAX;
    case 2:
        return i * 3 + 7;
    case 3:
        return i * i * 5 - i;
    case 4:
        return i % 2 ? UINT64_MAX : 0;
    case 5:
        return UINT64_C(0x3FF0000000000000) + (test_random(seed) & 0xFFFF) * 65537;
    case 6:
        return test_random(seed) & 1;
    case 7:
        return 0;
    case 8:
        return UINT64_MAX - (test_random(seed) & 3);
    default:
        return i / 40 + (test_random(seed) & 3);
    }
}

/* The form that was chosen, as a bit: 7 raw, 6 bits, else predictor and packing of zstd. */
static unsigned check_round_trip(uint32_t size, uint32_t count, int kind) {
    uint64_t seed = 1 + (uint64_t)kind;
    uint8_t *src = malloc((size_t)size * count), *out = malloc((size_t)size * count);
    for (uint32_t i = 0; i < count; i++)
        put(src + (size_t)i * size, size, element(kind, i, &seed));
    coded a = encode(size, count, src), b = encode(size, count, src);
    CHECK(a.size == b.size && memcmp(a.bytes, b.bytes, a.size) == 0);
    CHECK(decode(a.bytes, a.size, size, count, out) == 0);
    CHECK(memcmp(src, out, (size_t)size * count) == 0);
    unsigned form = 1U << (a.bytes[2] == 2 ? 6 : a.bytes[3] == 0 ? 7 : a.bytes[1] * 2 + a.bytes[2]);
    free(a.bytes);
    free(b.bytes);
    free(src);
    free(out);
    return form;
}

static void test_round_trips(void) {
    static const uint32_t counts[] = {1, 2, 3, 8, 63, 1000, 4097};
    unsigned forms = 0;
    for (size_t c = 0; c < sizeof counts / sizeof counts[0]; c++)
        for (int kind = 0; kind < 10; kind++)
            for (uint32_t size = 1; size <= 8; size *= 2)
                forms |= check_round_trip(size, counts[c], kind);
    /* Raw, bits, and the zstd forms that this data is made for. */
    CHECK((forms & 0xC0) == 0xC0 && (forms & 0x0C) != 0 && (forms & 0x30) != 0);
}

/* Every packing with every predictor, coded raw by hand: the encoder never writes some of them. */
static void test_raw_forms(void) {
    static const uint8_t values[3][8] = {{1, 2, 3, 4, 5, 6, 7, 8}, {2, 2, 2, 2, 2, 2, 2, 2}, {2, 0, 0, 0, 0, 0, 0, 0}};
    for (uint8_t predictor = 0; predictor < 3; predictor++)
        for (uint8_t packing = 0; packing < 2; packing++) {
            uint8_t bytes[ZT__PLANE_HEADER_SIZE + 16] = {0}, expected[16] = {0};
            uint16_t out[8];
            for (uint32_t i = 0; i < 8; i++) {
                expected[2 * i] = (uint8_t)(i + 1);
                bytes[ZT__PLANE_HEADER_SIZE + (packing ? i : 2 * i)] = values[predictor][i];
            }
            zt__plane_header h = {
                .element_size = 2, .predictor = predictor, .packing = packing, .count = 8, .stored_size = 16};
            h.hash = zt__hash(expected, 16);
            zt__coder coder = zt__writing(bytes);
            zt__code_plane(&coder, &h);
            CHECK(decode(bytes, sizeof bytes, 2, 8, out) == 0);
            for (uint16_t i = 0; i < 8; i++)
                CHECK(out[i] == i + 1);
        }
}

static uint32_t damaged(const coded *c, size_t at, uint8_t value, uint32_t size, uint32_t count) {
    uint8_t *copy = malloc(c->size), *out = malloc((size_t)size * count);
    memcpy(copy, c->bytes, c->size);
    copy[at] = value;
    uint32_t rule = decode(copy, c->size, size, count, out);
    free(copy);
    free(out);
    return rule;
}

static void test_damage(void) {
    uint32_t src[100], out[100];
    uint64_t seed = 8;
    for (uint32_t i = 0; i < 100; i++)
        src[i] = 1000 + (i == 7 ? 0 : i == 9 ? 7 : (uint32_t)(test_random(&seed) >> 40 & 7));
    coded bits = encode(4, 100, src);
    CHECK(bits.bytes[2] == 2 && bits.bytes[4] == 3);
    CHECK(damaged(&bits, 0, 3, 4, 100) == 5102);
    CHECK(damaged(&bits, 0, 8, 4, 100) == 5102);
    CHECK(damaged(&bits, 1, 1, 4, 100) == 5101);
    CHECK(damaged(&bits, 1, 3, 4, 100) == 5101);
    CHECK(damaged(&bits, 2, 3, 4, 100) == 5101);
    CHECK(damaged(&bits, 2, 0, 4, 100) == 5101);
    CHECK(damaged(&bits, 3, 1, 4, 100) == 5101);
    CHECK(damaged(&bits, 3, 2, 4, 100) == 5101);
    CHECK(damaged(&bits, 4, 33, 4, 100) == 5101);
    CHECK(damaged(&bits, 4, 32, 4, 100) == 5101); /* base + 2^32 - 1 is too much */
    CHECK(damaged(&bits, 4, 2, 4, 100) == 5103);
    CHECK(damaged(&bits, 5, 1, 4, 100) == 5101);
    CHECK(damaged(&bits, 7, 1, 4, 100) == 5101);
    CHECK(damaged(&bits, 12, 1, 4, 100) == 5101); /* base above 2^32 */
    CHECK(damaged(&bits, 8, 1, 4, 100) == 5105);
    CHECK(damaged(&bits, 16, 99, 4, 100) == 5102);
    CHECK(damaged(&bits, 20, 39, 4, 100) == 5103);
    CHECK(damaged(&bits, 24, (uint8_t)~bits.bytes[24], 4, 100) == 5105);
    CHECK(damaged(&bits, bits.size - 1, 0xFF, 4, 100) == 5104);
    CHECK(damaged(&bits, 40, (uint8_t)~bits.bytes[40], 4, 100) == 5105);
    for (size_t n = 0; n < bits.size; n++)
        CHECK(decode(bits.bytes, n, 4, 100, out) == 5103);
    free(bits.bytes);
    for (uint32_t i = 0; i < 100; i++)
        src[i] = (uint32_t)test_random(&seed);
    coded raw = encode(4, 100, src);
    CHECK(raw.bytes[2] == 0 && raw.bytes[3] == 0);
    CHECK(damaged(&raw, 20, 0, 4, 100) == 5103);
    CHECK(damaged(&raw, 3, 1, 4, 100) == 5103); /* zstd is smaller than raw */
    CHECK(damaged(&raw, 4, 1, 4, 100) == 5101);
    CHECK(damaged(&raw, 8, 1, 4, 100) == 5101);
    CHECK(damaged(&raw, 1, 1, 4, 100) == 5105);
    free(raw.bytes);
    for (int i = 0; i < 4000; i++) {
        for (uint32_t k = 0; k < 100; k++)
            src[k] = k * (uint32_t)i;
        coded c = encode(4, 100, src);
        (void)damaged(&c, test_below(&seed, (uint32_t)c.size), (uint8_t)test_random(&seed), 4, 100);
        free(c.bytes);
    }
}

int main(void) {
    zt__memory_init(&memory, NULL, 1 << 28);
    zt__decoder_init(&decoder, &memory);
    CHECK(zt__encoder_init(&encoder, &memory, 9, false, NULL) == ZT_OK);
    test_round_trips();
    test_raw_forms();
    test_damage();
    zt__encoder_free(&encoder);
    zt__decoder_free(&decoder);
    CHECK(atomic_load(&memory.used) == 0);
    return test_end();
}
