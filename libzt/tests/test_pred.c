/* SPDX-License-Identifier: Apache-2.0 */
/* The predicted codec: what is encoded decodes to the same texels, and every vector path gives the same texels and the
 * same verdict as plain C, on damaged tiles too, without touching a byte outside of its buffers (which lie between
 * pages that cannot be accessed). Matters because tiles come from strangers.
 * Arguments: [mutations a kernel, default 100000] [seed]. */
#define _DEFAULT_SOURCE
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fence.h"
#include "file_pred.h"
#include "test.h"

static uint64_t seed_state = 88172645463325252u;

static uint32_t below(uint32_t n) {
    return test_below(&seed_state, n);
}

static uint32_t next_random(void) {
    return (uint32_t)(test_random(&seed_state) >> 32);
}

enum { CONTENTS = 10 };

/* Texels of different kinds: flat, noise, gradients, steps, sparse, extremes ... */
static uint32_t value_of(const zt__pred_shape *shape, uint32_t content, uint32_t seed, uint32_t x, uint32_t y,
                         uint32_t c) {
    switch (content) {
    case 0: /* one value */
        return seed >> c;
    case 1:
        return next_random();
    case 2:
        return x * (c + 1) + y * 2 + below(3);
    case 3:
        return (x / 9 + y / 7) * 37 + c;
    case 4: /* mostly zero */
        return below(50) == 0 ? next_random() : 0;
    case 5: /* extremes */
        return below(2) ? 255 : 0;
    case 6: /* a channel that does not move */
        return c >= (shape->channels - 1) * shape->channel_bytes ? 255 : (x * y) / 8 + below(8);
    case 7: /* empty blocks */
        return (x / 64 + y / 8) % 3 == 0 ? next_random() : 7;
    case 8: /* channels that go together */
        return ((x * x + y * y) / 16 + seed % 5) + below(2) * c;
    default:
        return 128 + (next_random() & next_random() & 31);
    }
}

static void paint(const zt__pred_shape *shape, uint32_t content, uint8_t *texels) {
    uint32_t n = shape->channels * shape->channel_bytes, seed = next_random();
    for (uint32_t y = 0; y < shape->height; y++)
        for (uint32_t x = 0; x < shape->width; x++)
            for (uint32_t c = 0; c < n; c++)
                *texels++ = (uint8_t)value_of(shape, content, seed, x, y, c);
}

typedef struct bench {
    zt__pred_shape shape;
    size_t raw_size, scratch_size;
    fence stored, dst, scratch;
    uint8_t *texels, *work, *encoded, *expected;
    size_t encoded_size;
} bench;

static void bench_open(bench *b, const zt__pred_shape *shape) {
    b->shape = *shape;
    CHECK(zt__pred_shape_ok(shape));
    b->raw_size = (size_t)shape->width * shape->height * shape->channels * shape->channel_bytes;
    b->scratch_size = zt__pred_scratch_size(shape);
    b->stored = fence_open(2 * b->raw_size + 8192);
    b->dst = fence_open(b->raw_size);
    b->scratch = fence_open(b->scratch_size + 64);
    b->texels = malloc(b->raw_size);
    b->expected = malloc(b->raw_size);
    b->encoded = malloc(2 * b->raw_size + 8192);
    b->work = malloc(zt__pred_work_size(shape));
    CHECK(b->texels && b->expected && b->encoded && b->work);
}

static void bench_close(bench *b) {
    fence_close(&b->stored);
    fence_close(&b->dst);
    fence_close(&b->scratch);
    free(b->texels);
    free(b->expected);
    free(b->encoded);
    free(b->work);
}

/* Decodes bytes with one kernel between fences. */
static uint32_t decode(bench *b, const zt__pred_kernel *kernel, const uint8_t *bytes, size_t size, uint8_t **texels) {
    bool low = below(2) != 0;
    uint8_t *stored = fence_block(&b->stored, size, low), *dst = fence_block(&b->dst, b->raw_size, below(2) != 0);
    uint8_t *scratch = fence_block(&b->scratch, (b->scratch_size + 15) & ~(size_t)15, low);
    memcpy(stored, bytes, size);
    memset(dst, 0xA5, b->raw_size);
    memset(scratch, (int)below(256), b->scratch_size);
    size_t pitch = (size_t)b->shape.width * b->shape.channels * b->shape.channel_bytes;
    *texels = dst;
    return zt__pred_decode(kernel, &b->shape, stored, size, scratch, dst, pitch);
}

static const zt__pred_kernel *kernels[ZT__PRED_KERNELS];
static uint32_t kernel_count;

/* All kernels agree with plain C about bytes. Returns the verdict. */
static uint32_t compare(bench *b, const uint8_t *bytes, size_t size) {
    uint8_t *texels;
    uint32_t verdict = decode(b, kernels[0], bytes, size, &texels);
    memcpy(b->expected, texels, b->raw_size);
    for (uint32_t k = 1; k < kernel_count; k++) {
        uint32_t other = decode(b, kernels[k], bytes, size, &texels);
        CHECK(other == verdict);
        CHECK(verdict != 0 || memcmp(texels, b->expected, b->raw_size) == 0);
    }
    return verdict;
}

static void encode(bench *b, uint32_t content, uint32_t effort) {
    size_t pitch = (size_t)b->shape.width * b->shape.channels * b->shape.channel_bytes;
    paint(&b->shape, content, b->texels);
    memset(b->work, (int)below(256), zt__pred_work_size(&b->shape));
    b->encoded_size = zt__pred_encode(&b->shape, b->texels, pitch, effort, b->work, b->encoded, 2 * b->raw_size + 8192);
    CHECK(b->encoded_size != 0);
}

static void round_trip(const zt__pred_shape *shape, uint32_t content, uint32_t effort) {
    bench b;
    bench_open(&b, shape);
    encode(&b, content, effort);
    CHECK(compare(&b, b.encoded, b.encoded_size) == 0);
    CHECK(memcmp(b.expected, b.texels, b.raw_size) == 0);
    /* A block that is just large enough, and one that is not. */
    size_t pitch = (size_t)shape->width * shape->channels * shape->channel_bytes;
    uint8_t *exact = fence_block(&b.stored, b.encoded_size, false);
    CHECK(zt__pred_encode(shape, b.texels, pitch, effort, b.work, exact, b.encoded_size) == b.encoded_size);
    CHECK(memcmp(exact, b.encoded, b.encoded_size) == 0);
    exact = fence_block(&b.stored, b.encoded_size - 1, false);
    CHECK(zt__pred_encode(shape, b.texels, pitch, effort, b.work, exact, b.encoded_size - 1) < b.encoded_size);
    bench_close(&b);
}

static void round_trips(void) {
    static const uint32_t sizes[][2] = {{1, 1},   {2, 1},   {1, 9},  {7, 3},   {8, 8},   {9, 17},    {16, 16},
                                        {31, 33}, {64, 64}, {65, 9}, {127, 5}, {200, 3}, {300, 200}, {513, 40}};
    const uint32_t count = sizeof sizes / sizeof *sizes;
    for (uint32_t i = 0; i < count * 4 * 2 * CONTENTS; i++) {
        const uint32_t *size = sizes[i / (8 * CONTENTS)];
        zt__pred_shape shape = {size[0], size[1], 1 + i / (2 * CONTENTS) % 4, 1 + i / CONTENTS % 2};
        round_trip(&shape, i % CONTENTS, 1 + below(9));
    }
}

/* Damages a copy of the encoded tile. Returns the new size. */
static size_t mutate(const bench *b, uint8_t *bytes) {
    size_t size = b->encoded_size;
    memcpy(bytes, b->encoded, size);
    for (uint32_t i = below(3) + 1; i > 0; i--) {
        uint32_t head = below(3) ? below(400) : next_random();
        size_t at = head % size;
        switch (below(6)) {
        case 0:
            bytes[at] ^= (uint8_t)(1u << below(8));
            break;
        case 1:
            bytes[at] = (uint8_t)next_random();
            break;
        case 2:
            size = below((uint32_t)size) + 1;
            break;
        case 3:
            bytes[at] = below(2) ? 255 : 0;
            break;
        case 4: /* bytes taken out */
            memmove(bytes + at, bytes + at + (size - at) / 4, size - at - (size - at) / 4);
            size -= (size - at) / 4;
            break;
        default: /* more of them */
            bytes[size] = (uint8_t)next_random();
            bytes[size + 1] = (uint8_t)next_random();
            size += 1 + below(2);
        }
    }
    return size;
}

static void mutations(uint32_t count) {
    uint64_t accepted = 0, verdicts[16] = {0};
    for (uint32_t done = 0; done < count;) {
        uint32_t width = 1 + below(below(4) ? 40 : 280), height = 1 + below(below(4) ? 20 : 70);
        zt__pred_shape shape = {width, height, 1 + below(4), 1 + below(2)};
        bench b;
        bench_open(&b, &shape);
        encode(&b, below(CONTENTS), 1 + below(5));
        uint8_t *bytes = malloc(b.encoded_size + 16);
        CHECK(bytes != NULL);
        for (uint32_t i = 0; i < 200 && done < count; i++, done++) {
            uint32_t verdict = compare(&b, bytes, mutate(&b, bytes));
            accepted += verdict == 0;
            CHECK(verdict == 0 || (verdict >= 5302 && verdict <= 5312));
            verdicts[verdict ? verdict - 5300 : 0]++;
        }
        free(bytes);
        bench_close(&b);
    }
    printf("%u damaged tiles: %llu decode (to texels that the hash refuses);", count, (unsigned long long)accepted);
    for (uint32_t i = 2; i <= 12; i++)
        printf(" %u: %llu", 5300 + i, (unsigned long long)verdicts[i]);
    puts("");
}

int main(int argc, char **argv) {
    kernel_count = zt__pred_kernels(kernels);
    if (argc > 2)
        seed_state += strtoull(argv[2], NULL, 10) * 0x9E3779B97F4A7C15u;
    round_trips();
    mutations(argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : 100000);
    return test_end();
}
