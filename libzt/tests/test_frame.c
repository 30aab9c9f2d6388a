/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The zstd profile: each of its rules refuses a frame made by hand for it, and what the encoder makes passes. A walker
 * that misses one lets files through that other readers of the format refuse.
 */
#include <stdlib.h>

#include "base_hash.h"
#include "file_codec.h"
#include "test.h"

/* One raw block of five bytes. */
static const uint8_t good[] = {0x28, 0xB5, 0x2F, 0xFD, 0x20, 5, 5 << 3 | 1, 0, 0, 'h', 'e', 'l', 'l', 'o'};

static zt__memory memory;
static zt__decoder decoder;

static uint32_t rule_of(const uint8_t *frame, size_t size, size_t decoded) {
    zt_diag diag = {0};
    zt__sink sink = {.diag = &diag};
    /* Exactly as large as it is, so that sanitizers see a read or write too far. */
    uint8_t *copy = malloc(size ? size : 1), *out = malloc(decoded ? decoded : 1);
    memcpy(copy, frame, size);
    zt_result r = zt__decode_frame(&sink, &decoder, copy, size, out, decoded, 1000);
    CHECK((r == ZT_OK) == (diag.rule == 0));
    CHECK(r == ZT_OK || r == ZT_CORRUPT);
    free(copy);
    free(out);
    return diag.rule;
}

static uint32_t rule_with(size_t at, uint8_t value) {
    uint8_t frame[sizeof good];
    memcpy(frame, good, sizeof good);
    frame[at] = value;
    return rule_of(frame, sizeof frame, 5);
}

static void test_rules(void) {
    CHECK(rule_of(good, sizeof good, 5) == 0);
    CHECK(rule_with(0, 0x29) == 5001);
    CHECK(rule_with(3, 0xFC) == 5001);
    CHECK(rule_with(4, 0x00) == 5001); /* not single-segment */
    CHECK(rule_with(4, 0x21) == 5001); /* dictionary id */
    CHECK(rule_with(4, 0x22) == 5001);
    CHECK(rule_with(4, 0x24) == 5001); /* checksum */
    CHECK(rule_with(4, 0x28) == 5001); /* reserved bit */
    CHECK(rule_with(4, 0x30) == 5001); /* unused bit */
    CHECK(rule_with(5, 4) == 5002);
    CHECK(rule_of(good, sizeof good, 6) == 5002);
    CHECK(rule_with(6, 5 << 3) == 5003);     /* never a last block */
    CHECK(rule_with(6, 5 << 3 | 7) == 5003); /* block type 3 */
    CHECK(rule_with(6, 4 << 3 | 1) == 5003); /* a byte behind the last block */
    CHECK(rule_with(6, 6 << 3 | 1) == 5003); /* beyond the end */
    CHECK(rule_with(8, 0x10) == 5003);       /* block above 131072 */
    CHECK(rule_with(6, 5 << 3 | 5) == 5004); /* raw bytes called compressed */
    for (size_t n = 0; n < sizeof good; n++)
        CHECK(rule_of(good, n, 5) != 0);
    static const uint8_t skippable[] = {0x50, 0x2A, 0x4D, 0x18, 1, 0, 0, 0, 7};
    CHECK(rule_of(skippable, sizeof skippable, 1) == 5001);
    uint8_t twice[2 * sizeof good];
    memcpy(twice, good, sizeof good);
    memcpy(twice + sizeof good, good, sizeof good);
    CHECK(rule_of(twice, sizeof twice, 5) == 5003);
    CHECK(rule_of(twice, sizeof twice, 10) == 5002);
    /* Run-length blocks store one byte; the content is shorter than promised. */
    static const uint8_t run[] = {0x28, 0xB5, 0x2F, 0xFD, 0x20, 9, 9 << 3 | 3, 0, 0, 'a'};
    CHECK(rule_of(run, sizeof run, 9) == 0);
    static const uint8_t run_short[] = {0x28, 0xB5, 0x2F, 0xFD, 0x20, 9, 8 << 3 | 3, 0, 0, 'a'};
    CHECK(rule_of(run_short, sizeof run_short, 9) == 5004);
    static const uint8_t two_bytes[] = {0x28, 0xB5, 0x2F, 0xFD, 0x60, 1, 0, 0x0B, 8, 0, 'a'}; /* 257 */
    CHECK(rule_of(two_bytes, sizeof two_bytes, 257) == 0);
    /* A run that would overrun the memory it is decoded to. */
    static const uint8_t run_long[] = {0x28, 0xB5, 0x2F, 0xFD, 0x20, 9, 0x03, 0x00, 0x10, 'a'};
    CHECK(rule_of(run_long, sizeof run_long, 9) != 0);
}

static void test_hash(void) {
    uint8_t out[5];
    zt_diag diag = {0};
    zt__sink sink = {.diag = &diag};
    CHECK(zt__decode_stored(&sink, &decoder, 1, good, sizeof good, out, 5, zt__hash("hello", 5), 5203, 0) == ZT_OK);
    CHECK(zt__decode_stored(&sink, &decoder, 1, good, sizeof good, out, 5, 1, 5203, 0) == ZT_CORRUPT &&
          diag.rule == 5203);
    CHECK(zt__decode_stored(&sink, &decoder, 2, good, sizeof good, out, 5, 1, 5203, 0) == ZT_UNSUPPORTED);
}

/* Sizes about those where zstd changes its header and its window; every level. */
static void test_encoder(void) {
    static const size_t sizes[] = {1, 2, 255, 256, 257, 65791, 65792, 131072, 131073, 600000, 5000000};
    for (int level = 1; level <= 19; level += level < 9 ? 4 : 5) {
        zt__encoder encoder;
        CHECK(zt__encoder_init(&encoder, &memory, level, false, NULL) == ZT_OK);
        for (size_t i = 0; i < sizeof sizes / sizeof sizes[0] - (level > 9); i++) {
            size_t size = sizes[i], bound = zt__encode_bound(size), stored;
            uint8_t *src = malloc(size), *dst = malloc(bound), codec;
            for (size_t k = 0; k < size; k++)
                src[k] = (uint8_t)(k / 3);
            CHECK(zt__encode_stored(&encoder, src, size, dst, bound, &codec, &stored, NULL) == ZT_OK);
            CHECK(codec <= 1 && stored <= size && (codec == 1 || size < 1000));
            if (codec == 1)
                CHECK(rule_of(dst, stored, size) == 0 && stored < size);
            free(src);
            free(dst);
        }
        zt__encoder_free(&encoder);
    }
}

static void test_random_damage(void) {
    enum { SIZE = 3000 };
    static uint8_t src[SIZE], dst[SIZE * 2], damaged[SIZE * 2];
    zt__encoder encoder;
    uint64_t seed = 4;
    uint8_t codec;
    size_t stored;
    for (size_t i = 0; i < SIZE; i++)
        src[i] = (uint8_t)(test_random(&seed) & 7);
    CHECK(zt__encoder_init(&encoder, &memory, 9, false, NULL) == ZT_OK);
    CHECK(zt__encode_stored(&encoder, src, SIZE, dst, sizeof dst, &codec, &stored, NULL) == ZT_OK && codec == 1);
    for (int i = 0; i < 3000; i++) {
        memcpy(damaged, dst, stored);
        for (uint32_t k = test_below(&seed, 3) + 1; k > 0; k--)
            damaged[test_below(&seed, (uint32_t)stored)] = (uint8_t)test_random(&seed);
        (void)rule_of(damaged, stored - test_below(&seed, 2), SIZE);
    }
    zt__encoder_free(&encoder);
}

int main(void) {
    zt__memory_init(&memory, NULL, 1 << 28);
    zt__decoder_init(&decoder, &memory);
    test_rules();
    test_hash();
    test_encoder();
    test_random_damage();
    zt__decoder_free(&decoder);
    CHECK(atomic_load(&memory.used) == 0);
    return test_end();
}
