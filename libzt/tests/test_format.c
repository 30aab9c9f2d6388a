/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: texels survive conversion. Every code of every integer format, and every half, comes back from unpacking
 * and packing, also through linear light; the fast paths give the bits of the slow ones; transfers agree with libm. A
 * code that moved would change an image each time a tool rewrites it.
 *
 * `test_format --table` prints libzt/src/file_format_table.c.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base_bytes.h"
#include "file_format.h"
#include "test.h"

static const uint32_t transfers[] = {1, 2, 4, 5, 6, 8, 13, 14, 15, 16};

enum { TRANSFERS = sizeof transfers / sizeof transfers[0] };

/* ---- the tables ----------------------------------------------------------------------------- */

static uint8_t slow_srgb8(float linear) {
    return zt__unorm8_of(zt_transfer_encode(13, linear));
}

/* Smallest float whose code is above k: positive floats are ordered like their bits. */
static float threshold_of(uint32_t k) {
    uint32_t low = 0;
    uint32_t high = zt__bits_of_float(1.0f);
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (slow_srgb8(zt__float_of_bits(middle)) > k)
            high = middle;
        else
            low = middle + 1;
    }
    return zt__float_of_bits(low);
}

static float bucket_start(uint32_t bucket) {
    uint32_t least = (127u - ZT__SRGB_FIRST_OCTAVE) << 23;
    return zt__float_of_bits(least + (bucket << (23 - ZT__SRGB_BUCKET_BITS)));
}

static void print_floats(const char *name, const float *values, size_t count) {
    printf("\nconst float %s[%zu] = {\n", name, count);
    for (size_t i = 0; i < count; i++) {
        if (isinf(values[i]))
            printf(" INFINITY");
        else /* hexadecimal: exact */
            printf("%s%af", i % 5 == 0 ? "    " : " ", (double)values[i]);
        printf("%s", i % 5 == 4 || i + 1 == count ? ",\n" : ",");
    }
    printf("};\n");
}

static void print_table(void) {
    float values[256];
    printf("/* SPDX-License-Identifier: Apache-2.0 */\n"
           "/* Written by `test_format --table` and checked by test_format. */\n"
           "/* clang-format off */\n"
           "#include <math.h>\n\n"
           "#include \"file_format.h\"\n");
    for (int k = 0; k < 256; k++)
        values[k] = (float)k / 255.0f;
    print_floats("zt__unorm8_values", values, 256);
    for (int k = 0; k < 256; k++)
        values[k] = zt_transfer_decode(13, (float)k / 255.0f);
    print_floats("zt__srgb8_values", values, 256);
    for (uint32_t k = 0; k < 255; k++)
        values[k] = threshold_of(k);
    values[255] = INFINITY;
    print_floats("zt__srgb8_thresholds", values, 256);
    printf("\nconst uint8_t zt__srgb8_starts[ZT__SRGB_BUCKETS] = {\n");
    for (uint32_t i = 0; i < ZT__SRGB_BUCKETS; i++)
        printf("%s%u%s", i % 16 == 0 ? "    " : " ", slow_srgb8(bucket_start(i)), i % 16 == 15 ? ",\n" : ",");
    printf("};\n");
}

static void check_tables(void) {
    for (uint32_t k = 0; k < 256; k++) {
        CHECK(zt__unorm8_values[k] == (float)k / 255.0f);
        CHECK(zt__srgb8_values[k] == zt_transfer_decode(13, (float)k / 255.0f));
        CHECK(k == 255 || zt__srgb8_thresholds[k] == threshold_of(k));
    }
    CHECK(zt__srgb8_thresholds[255] == INFINITY);
    for (uint32_t i = 0; i < ZT__SRGB_BUCKETS; i++)
        CHECK(zt__srgb8_starts[i] == slow_srgb8(bucket_start(i)));
}

/* The fast 8-bit encoding gives the bits of the slow one, around every threshold and anywhere. */
static void check_fast_srgb(void) {
    for (uint32_t k = 0; k < 255; k++) {
        uint32_t bits = zt__bits_of_float(zt__srgb8_thresholds[k]);
        for (uint32_t near = bits - 40; near <= bits + 40; near++) {
            float x = zt__float_of_bits(near);
            CHECK(zt__srgb8_of(x) == slow_srgb8(x));
        }
    }
    uint64_t seed = 1;
    for (int i = 0; i < 200000; i++) {
        float x = zt__float_of_bits((uint32_t)(test_random(&seed) >> 32));
        CHECK(zt__srgb8_of(x) == slow_srgb8(x));
        float y = (float)test_uniform(&seed, -0.1, 1.1);
        CHECK(zt__srgb8_of(y) == slow_srgb8(y));
    }
}

/* ---- transfers ------------------------------------------------------------------------------ */

/* Independent of the implementation: libm, straight from spec/registry.md. */
static double libm_decode(uint32_t transfer, double v) {
    switch (transfer) {
    case 4:
        return pow(v, 2.2);
    case 5:
        return pow(v, 2.8);
    case 13:
        return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
    case 16: {
        double e = pow(v, 1 / 78.84375);
        return pow(fmax(e - 0.8359375, 0) / (18.8515625 - 18.6875 * e), 1 / 0.1593017578125);
    }
    case 2:
    case 8:
        return v;
    default: {
        const double alpha = 1.099296826809442;
        return v < 4.5 * 0.018053968510807 ? v / 4.5 : pow((v + (alpha - 1)) / alpha, 1 / 0.45);
    }
    }
}

static void check_transfers(void) {
    for (uint32_t t = 0; t < TRANSFERS; t++) {
        CHECK(zt_transfer_known(transfers[t]) == 1);
        for (int i = 0; i <= 5000; i++) {
            float v = (float)i / 5000.0f;
            double expected = libm_decode(transfers[t], (double)v);
            double got = (double)zt_transfer_decode(transfers[t], v);
            CHECK(fabs(got - expected) <= 1e-6 * expected + 1e-12);
            CHECK(zt_transfer_decode(transfers[t], -v) == -zt_transfer_decode(transfers[t], v));
            double back = (double)zt_transfer_encode(transfers[t], (float)got);
            CHECK(fabs(back - (double)v) <= 2e-6);
        }
        CHECK(zt_transfer_decode(transfers[t], 0.0f) == 0.0f);
        CHECK(zt_transfer_encode(transfers[t], 0.0f) == 0.0f);
        CHECK(zt_transfer_decode(transfers[t], 1.0f) == 1.0f);
        CHECK(zt_transfer_encode(transfers[t], 1.0f) == 1.0f);
        CHECK(isnan(zt_transfer_decode(transfers[t], NAN)));
        CHECK(zt_transfer_decode(transfers[t], INFINITY) > 0.5f);
        CHECK(zt_transfer_encode(transfers[t], FLT_MAX) > 0.5f);
    }
    CHECK(zt_transfer_known(3) == 0 && zt_transfer_known(18) == 0 && zt_transfer_known(0) == 0);
}

/* libm is accurate to a unit or so in the last place of binary64. */
static void check_power(void) {
    uint64_t seed = 7;
    for (int i = 0; i < 100000; i++) {
        double x = ldexp(test_uniform(&seed, 0.5, 1), (int)test_below(&seed, 250) - 125);
        double p = test_uniform(&seed, 0.01, i % 2 ? 1.0 : 2.8);
        double expected = pow(x, p);
        CHECK(fabs(zt__power(x, p) - expected) <= 1e-11 * expected);
    }
    CHECK(zt__power(0, 2) == 0);
}

/* Every code of a UNORM format with every transfer, in the first channel and in the fourth. */
static void check_unorm_codes(uint32_t bits, uint32_t number) {
    const zt_format_info *format = zt_find_format(number);
    uint32_t count = 1u << bits;
    uint8_t *src = calloc(count, 8);
    uint8_t *back = calloc(count, 8);
    float *rgba = malloc(count * 4 * sizeof(float));
    CHECK(src && back && rgba && format->channels == 4);
    for (uint32_t i = 0; i < 4 * count; i++) {
        if (bits == 8)
            src[i] = (uint8_t)(i / 4);
        else
            zt__store16(src + (size_t)2 * i, (uint16_t)(i / 4));
    }
    size_t size = (size_t)count * format->block_bytes;
    CHECK(zt_unpack_texels(number, src, count, rgba) == ZT_OK);
    CHECK(zt_pack_texels(number, rgba, count, back) == ZT_OK);
    CHECK(memcmp(src, back, size) == 0);
    for (uint32_t t = 0; t < TRANSFERS; t++) {
        zt__unpack_linear(format, transfers[t], src, count, rgba);
        zt__pack_linear(format, transfers[t], rgba, count, back);
        CHECK(memcmp(src, back, size) == 0);
        CHECK(rgba[4 * count - 1] == 1.0f && rgba[4 * count - 4] == 1.0f && rgba[0] == 0.0f);
    }
    free(src);
    free(back);
    free(rgba);
}

/* ---- half, shared exponent ------------------------------------------------------------------- */

static double half_value(uint32_t half) {
    double m = half & 1023;
    int e = (int)(half >> 10 & 31);
    double v = e == 0 ? ldexp(m, -24) : ldexp(m + 1024, e - 25);
    return half & 0x8000 ? -v : v;
}

static void check_half(void) {
    for (uint32_t h = 0; h < 65536; h++) {
        float f = zt__float_of_half((uint16_t)h);
        bool is_nan = (h & 0x7C00) == 0x7C00 && (h & 0x3FF) != 0;
        CHECK(is_nan ? isnan(f) != 0 : zt__half_of_float(f) == h);
        if ((h & 0x7C00) != 0x7C00)
            CHECK((double)f == half_value(h));
    }
    /* Between two neighbours: the middle goes to the even one, its neighbours to the nearer. */
    for (uint32_t h = 0; h < 0x7BFF; h++) {
        float middle = (float)((half_value(h) + half_value(h + 1)) / 2);
        CHECK(zt__half_of_float(middle) == h + (h & 1));
        CHECK(zt__half_of_float(nextafterf(middle, 0)) == h);
        CHECK(zt__half_of_float(nextafterf(middle, 1e9f)) == h + 1);
        CHECK(zt__half_of_float(-middle) == (0x8000 | (h + (h & 1))));
    }
    CHECK(zt__half_of_float(INFINITY) == 0x7C00 && zt__half_of_float(-INFINITY) == 0xFC00);
    CHECK(zt__half_of_float(FLT_MAX) == 0x7BFF && zt__half_of_float(-65520.0f) == 0xFBFF);
    CHECK(isnan(zt__float_of_half(zt__half_of_float(NAN))));
}

/* The definition of EXT_texture_shared_exponent in doubles and libm. */
static uint32_t slow_shared(const float *rgb) {
    double c[3];
    double largest = 0;
    for (int i = 0; i < 3; i++) {
        c[i] = fmin(65408, fmax(0, (double)rgb[i]));
        largest = fmax(largest, c[i]);
    }
    double e = fmax(-16, floor(largest > 0 ? log2(largest) : -1000)) + 16;
    if (floor(largest / exp2(e - 24) + 0.5) >= 512)
        e += 1;
    uint32_t word = (uint32_t)e << 27;
    for (uint32_t i = 0; i < 3; i++)
        word |= (uint32_t)floor(c[i] / exp2(e - 24) + 0.5) << (9 * i);
    return word;
}

static void check_shared(void) {
    uint64_t seed = 3;
    uint8_t bytes[4];
    for (int i = 0; i < 200000; i++) {
        float rgba[4] = {0};
        for (int c = 0; c < 3; c++)
            rgba[c] = (float)ldexp(test_uniform(&seed, -0.1, 1), (int)test_below(&seed, 44) - 26);
        CHECK(zt_pack_texels(123, rgba, 1, bytes) == ZT_OK);
        CHECK(zt__load32(bytes) == slow_shared(rgba));
        uint32_t word = (uint32_t)test_random(&seed);
        zt__store32(bytes, word);
        CHECK(zt_unpack_texels(123, bytes, 1, rgba) == ZT_OK);
        for (uint32_t c = 0; c < 3; c++) {
            double expected = ldexp(word >> (9 * c) & 511, (int)(word >> 27) - 24);
            CHECK((double)rgba[c] == expected);
        }
        /* Words in their normal form come back. */
        if ((word | word >> 9 | word >> 18) & 256) {
            zt_pack_texels(123, rgba, 1, bytes);
            CHECK(zt__load32(bytes) == word);
        }
    }
    float odd[4] = {NAN, INFINITY, -1.0f, 0.0f};
    CHECK(zt_pack_texels(123, odd, 1, bytes) == ZT_OK);
    CHECK(zt__load32(bytes) == (511u << 9 | 31u << 27));
}

/* ---- the table of formats -------------------------------------------------------------------- */

static void check_formats(void) {
    uint32_t count = 0;
    uint32_t last = 0;
    for (const zt_format_info *f; (f = zt_get_format(count)) != NULL; count++) {
        char name[64];
        snprintf(name, sizeof name, "VK_FORMAT_%s", f->name);
        CHECK(f->format > last && zt_find_format(f->format) == f);
        CHECK(zt_find_format_name(f->name) == f && zt_find_format_name(name) == f);
        CHECK(f->is_srgb == (strstr(f->name, "SRGB") != NULL));
        CHECK(f->is_float == (strstr(f->name, "FLOAT") != NULL));
        CHECK(f->is_plain == (strstr(f->name, "BLOCK") == NULL));
        CHECK(f->is_plain == (f->block_width == 1));
        if (f->is_plain && f->channel_bits != 0)
            CHECK(f->block_bytes == f->channels * f->channel_bits / 8);
        last = f->format;
    }
    CHECK(count == 75); /* rows of spec/registry.md */
    CHECK(zt_find_format(0) == NULL && zt_find_format(10) == NULL && zt_find_format(999) == NULL);
    CHECK(zt_find_format_name("R8") == NULL);
    float rgba[4];
    uint8_t block[16] = {0};
    CHECK(zt_unpack_texels(145, block, 1, rgba) == ZT_UNSUPPORTED);
    CHECK(zt_pack_texels(1, rgba, 1, block) == ZT_UNSUPPORTED);
    CHECK(zt_unpack_texels(37, NULL, 1, rgba) == ZT_BAD_ARGUMENT);
}

/* Rows of every plain format: as stored and through linear light, fast and slow. */
static void check_rows(void) {
    enum { COUNT = 150 };
    uint64_t seed = 9;
    for (uint32_t i = 0; zt_get_format(i); i++) {
        const zt_format_info *f = zt_get_format(i);
        if (!f->is_plain)
            continue;
        uint8_t src[COUNT * 16 + 1];
        uint8_t a[COUNT * 16], b[COUNT * 16];
        float fast[COUNT * 4], slow[COUNT * 4];
        for (size_t k = 0; k < sizeof src; k++)
            src[k] = (uint8_t)test_random(&seed);
        for (uint32_t t = 0; t < TRANSFERS; t++) {
            CHECK(zt_unpack_texels(f->format, src + 1, COUNT, slow) == ZT_OK);
            zt__linearise(transfers[t], slow, COUNT);
            zt__unpack_linear(f, transfers[t], src + 1, COUNT, fast);
            CHECK(memcmp(fast, slow, sizeof fast) == 0);
            memset(a, 0, sizeof a);
            memset(b, 0, sizeof b);
            zt__pack_linear(f, transfers[t], slow, COUNT, a);
            CHECK(memcmp(fast, slow, sizeof fast) == 0);
            zt__delinearise(transfers[t], slow, COUNT);
            CHECK(zt_pack_texels(f->format, slow, COUNT, b) == ZT_OK);
            CHECK(memcmp(a, b, sizeof a) == 0);
        }
    }
    float odd[4] = {NAN, 2.0f, -1.0f, 0.5f};
    uint8_t out[8];
    CHECK(zt_pack_texels(37, odd, 1, out) == ZT_OK);
    CHECK(out[0] == 0 && out[1] == 255 && out[2] == 0 && out[3] == 128); /* 127.5: to even */
    CHECK(zt_pack_texels(91, odd, 1, out) == ZT_OK);
    CHECK(zt__load16(out) == 0 && zt__load16(out + 2) == 65535 && zt__load16(out + 6) == 32768);
}

int main(int argc, char **argv) {
    if (argc == 2 && strcmp(argv[1], "--table") == 0) {
        print_table();
        return 0;
    }
    check_formats();
    check_power();
    check_transfers();
    check_tables();
    check_fast_srgb();
    check_unorm_codes(8, 37);
    check_unorm_codes(16, 91);
    check_half();
    check_shared();
    check_rows();
    return test_end();
}
