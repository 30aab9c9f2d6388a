/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The decoders of one tile of codec 2 or 4 (libzt/src/file_codec.h), below the container and its hashes: whatever the
 * bytes, every kernel gives plain C's verdict and texels, and touches nothing beside its blocks of memory and nothing
 * between the rows. What tile_make... make is accepted, with the texels that the specification gives.
 *
 * The blocks have their exact sizes: under AddressSanitizer they come from malloc, else they lie against pages without
 * access.
 */
#include "base_hash.h"
#include "fence.h"
#include "file_codec.h"
#include "file_fields.h"
#include "tile.h"

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(memory_sanitizer)
#define FROM_HEAP 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__)
#define FROM_HEAP 1
#endif

enum { FIRST_RULE = 5000, MOST_VERDICTS = 500 };
enum { LARGEST_DST = TILE_WIDTH * 8 * TILE_HEIGHT + 7 * 256 * TILE_HEIGHT, FILLER = 0xA5, POOL = 64 };

/* What happened so far; printed at exit. */
static struct {
    unsigned long long inputs, decodings, texels, verdicts[MOST_VERDICTS], made, encoded, framed, fields;
    unsigned long long bytes; /* of texels of accepted tiles */
} counts;

static const zt__pred_kernel *kernels[ZT__PRED_KERNELS];
static uint32_t kernel_count;

/* ---- memory ---- */

typedef struct block {
#ifndef FROM_HEAP
    fence room;
#endif
    uint8_t *data;
} block;

static void take(block *b, size_t size, size_t largest, bool low) {
#ifdef FROM_HEAP
    (void)largest, (void)low;
    b->data = fuzz_malloc(size);
#else
    if (!b->room.pages)
        b->room = fence_open(largest);
    b->data = fence_block(&b->room, size, low);
#endif
}

static void give_back(block *b) {
#ifdef FROM_HEAP
    free(b->data);
#endif
    b->data = NULL;
}

/* ---- decoding ---- */

static zt__pred_shape shape_of(const tile *t) {
    return (zt__pred_shape){t->width, t->height, t->channels, t->channel_bytes};
}

/* Tiles of codec 2 without a frame, in scratch memory of the exact size. */
static uint32_t decode_words(const zt__pred_kernel *kernel, const tile *t, const uint8_t *stored, uint8_t *dst,
                             size_t pitch) {
    static block scratch;
    zt__pred_shape shape = shape_of(t), largest = {TILE_WIDTH, TILE_HEIGHT, 4, 2};
    take(&scratch, (zt__pred_scratch_size(&shape) + 15) & ~(size_t)15, zt__pred_scratch_size(&largest) + 16,
         t->dst_low);
    uint32_t verdict = zt__pred_decode(kernel, &shape, stored, t->size, scratch.data, dst, pitch);
    give_back(&scratch);
    return verdict;
}

/* The others, with the decoder that files get. Their hash is not known: a tile whose texels are there breaks the rule
 * of the hash, and with the hash of those texels none. */
static uint32_t decode_frame(const zt__pred_kernel *kernel, const tile *t, const uint8_t *stored, uint8_t *dst,
                             size_t pitch) {
    static const uint32_t formats[TILE_FIELD_FORMATS] = {131, 137, 139, 141, 145};
    enum { WRONG_HASH = 5203 };
    zt__memory memory;
    zt__decoder decoder;
    zt_diag diag = {0};
    zt__pred_shape shape = shape_of(t);
    size_t row = (size_t)t->width * tile_texel_bytes(t);
    uint64_t hash = 0;
    zt_result result = ZT_CORRUPT;
    zt__memory_init(&memory, NULL, UINT64_C(1) << 26);
    zt__decoder_init(&decoder, &memory);
    decoder.kernel = kernel;
    for (int i = 0; i < 2 && result != ZT_OK && (i == 0 || diag.rule == WRONG_HASH); i++) {
        zt__sink sink = {.diag = &diag};
        result = t->fields ? zt__decode_fields(&sink, &decoder, zt__find_fields(formats[t->fields - 1]), row, t->height,
                                               stored, t->size, dst, pitch, hash, 0)
                           : zt__decode_pred(&sink, &decoder, &shape, stored, t->size, dst, pitch, hash, 0);
        REQUIRE(result == ZT_OK || (result == ZT_CORRUPT && diag.rule != 0));
        hash = zt__hash_rows(dst, row, t->height, pitch);
    }
    zt__decoder_free(&decoder);
    REQUIRE(atomic_load(&memory.used) == 0);
    return result == ZT_OK ? 0 : diag.rule;
}

/* Decodes with one kernel; the rows go to texels, one behind the other. */
static uint32_t decode(const zt__pred_kernel *kernel, const tile *t, uint8_t *texels) {
    static block stored, dst;
    size_t row = (size_t)t->width * tile_texel_bytes(t), pitch = row + t->gap;
    size_t dst_size = (t->height - 1) * pitch + row;
    take(&stored, t->size, TILE_INPUT, t->stored_low);
    take(&dst, dst_size, LARGEST_DST, t->dst_low);
    memcpy(stored.data, t->stored, t->size);
    memset(dst.data, FILLER, dst_size);
    uint32_t verdict = (tile_has_frame(t) ? decode_frame : decode_words)(kernel, t, stored.data, dst.data, pitch);
    for (uint32_t y = 0; y < t->height; y++) {
        memcpy(texels + y * row, dst.data + y * pitch, row);
        for (uint32_t i = 0; i < t->gap && y + 1 < t->height; i++)
            REQUIRE(dst.data[y * pitch + row + i] == FILLER);
    }
    REQUIRE(memcmp(stored.data, t->stored, t->size) == 0);
    give_back(&stored);
    give_back(&dst);
    counts.decodings++;
    return verdict;
}

static size_t texels_size(const tile *t) {
    return (size_t)t->width * t->height * tile_texel_bytes(t);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    static uint8_t expected[LARGEST_DST], texels[LARGEST_DST];
    tile t;
    if (size > TILE_INPUT || !tile_parse(&t, data, size))
        return 0;
    uint32_t verdict = decode(kernels[0], &t, expected);
    REQUIRE(verdict == 0 || (verdict / 100 == 53 && !t.fields) || (verdict / 100 == 50 && tile_has_frame(&t)));
    for (uint32_t k = 1; k < kernel_count && !t.fields; k++) {
        REQUIRE(decode(kernels[k], &t, texels) == verdict);
        REQUIRE(verdict != 0 || memcmp(texels, expected, texels_size(&t)) == 0);
    }
    counts.inputs++;
    counts.texels += (unsigned long long)t.width * t.height;
    counts.framed += tile_has_frame(&t) && !t.fields;
    counts.fields += t.fields != 0;
    counts.verdicts[verdict ? verdict - FIRST_RULE : 0]++;
    counts.bytes += verdict ? 0 : texels_size(&t);
    return 0;
}

/* ---- new inputs ---- */

/* A tile that keeps to the specification: plain C decodes it to these texels. */
static size_t make(fuzz_random *random, uint8_t *input) {
    static uint8_t texels[TILE_TEXELS * 8], decoded[LARGEST_DST];
    tile t;
    uint32_t kind = fuzz_below(random, 4);
    size_t size = (kind == 0 ? tile_make_frame : kind == 1 ? tile_make_fields : tile_make)(random, input, texels);
    REQUIRE(size <= TILE_INPUT && tile_parse(&t, input, size));
    REQUIRE(decode(kernels[0], &t, decoded) == 0);
    REQUIRE(memcmp(decoded, texels, texels_size(&t)) == 0);
    counts.made++;
    return size;
}

/* A tile from libzt's encoder. Returns 0 when it would be too large. */
static size_t encode(fuzz_random *random, uint8_t *input) {
    static uint8_t texels[LARGEST_DST];
    tile t = {.width = 1 + fuzz_below(random, 40), .height = 1 + fuzz_below(random, 20)};
    t.channels = 1 + fuzz_below(random, 4);
    t.channel_bytes = 1 + fuzz_below(random, 2);
    uint32_t noise = fuzz_below(random, 9), slope = fuzz_below(random, 5), pixel = t.channels * t.channel_bytes;
    for (size_t i = 0; i < texels_size(&t); i++)
        texels[i] = (uint8_t)(i / pixel * slope + fuzz_below(random, 1u << noise));
    zt__pred_shape shape = shape_of(&t);
    void *work = fuzz_malloc(zt__pred_work_size(&shape));
    size_t size = zt__pred_encode(&shape, texels, (size_t)t.width * pixel, 1 + fuzz_below(random, 9), work,
                                  input + TILE_HEAD, TILE_INPUT - TILE_HEAD);
    free(work);
    tile_store_head(&t, input);
    counts.encoded++;
    return size ? TILE_HEAD + size : 0;
}

/* Tiles to change, one of which is made anew now and then: making one costs more than decoding it. */
static size_t fresh(fuzz_random *random, uint8_t *out, size_t max_size) {
    static uint8_t pool[POOL][TILE_INPUT];
    static size_t sizes[POOL];
    uint32_t i = fuzz_below(random, POOL);
    if (sizes[i] == 0 || fuzz_below(random, 16) == 0)
        sizes[i] = fuzz_below(random, 16) ? make(random, pool[i]) : encode(random, pool[i]);
    if (sizes[i] == 0 || sizes[i] > max_size)
        return 0;
    memcpy(out, pool[i], sizes[i]);
    return sizes[i];
}

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed) {
    fuzz_random random = {seed * UINT64_C(0x9E3779B97F4A7C15) + 1};
    if (size < TILE_HEAD || fuzz_below(&random, 32) == 0) {
        size_t n = fresh(&random, data, max_size);
        if (n > 0)
            return n;
    }
    if (size < TILE_HEAD) {
        size = TILE_HEAD < max_size ? TILE_HEAD : max_size;
        memset(data, 0, size);
        return size;
    }
    return tile_mutate(&random, data, size, max_size);
}

static void report(void) {
    fprintf(stderr,
            "%llu inputs, %llu decodings with %u kernels; on average %llu texels; %llu tiles made, %llu encoded; "
            "%llu with a frame, %llu of codec 4\n",
            counts.inputs, counts.decodings, (unsigned)kernel_count, counts.inputs ? counts.texels / counts.inputs : 0,
            counts.made, counts.encoded, counts.framed, counts.fields);
    fprintf(stderr, "accepted: %llu (%llu bytes of texels)", counts.verdicts[0], counts.bytes);
    for (uint32_t i = 1; i < MOST_VERDICTS; i++)
        if (counts.verdicts[i])
            fprintf(stderr, ", rule %u: %llu", FIRST_RULE + i, counts.verdicts[i]);
    fputc('\n', stderr);
}

int LLVMFuzzerInitialize(int *argc, char ***argv) {
    (void)argc, (void)argv;
    kernel_count = zt__pred_kernels(kernels);
    atexit(report);
    return 0;
}
