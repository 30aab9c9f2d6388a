/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: a zipmap comes back from encoding and decoding as it was, each of rules 8101 to 8111 is found when it alone
 * is broken, limits hold, and a validator that goes on behind a finding stays safe. Payloads come from files of
 * strangers.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "test.h"
#include "zipmap_payload.h"

enum { PATCHES = 40, LAYERS = 2, IMAGES = 6, OWN_TEXTURE = 3 };

/* 0: root, 12 layers. 1: alpha, 12 layers. 2: alpha, 1 layer. 3: no alpha. 4: mask. 5: a cube map. */
static const zt__image_record images[IMAGES] = {
    {.format = 37, .depth = 1, .layers = 12},
    {.format = 43, .depth = 1, .layers = 12, .alpha_mode = 1, .layer_kind = 2},
    {.format = 43, .depth = 1, .layers = 1, .alpha_mode = 2},
    {.format = 23, .depth = 1, .layers = 1},
    {.format = 9, .depth = 1, .layers = 1},
    {.format = 43, .depth = 1, .layers = 12, .alpha_mode = 1, .layer_kind = 1},
};

static const zt__image_record *image_of(const void *user, uint32_t image) {
    (void)user;
    return image < IMAGES ? &images[image] : NULL;
}

static uint32_t texture_layers(const void *user, uint32_t texture) {
    (void)user;
    return texture == 1 ? 5 : LAYERS;
}

static const zt__payload_scope scope = {.texture = OWN_TEXTURE,
                                        .layer_count = LAYERS,
                                        .image_count = IMAGES,
                                        .image_of = image_of,
                                        .texture_layers = texture_layers};

static void set_sources(zt__zipmap *z, uint32_t patch, uint32_t first, uint32_t second, uint32_t mask) {
    z->sources[patch] = first;
    z->sources[z->patch_count + patch] = second;
    z->masks[patch] = mask;
}

static zt__zipmap *make(zt__memory *memory, uint32_t count) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    zt__zipmap *z;
    uint64_t seed = 5;
    CHECK(zt__zipmap_new(memory, count, LAYERS, NULL, &z) == ZT_OK);
    memcpy(z->matrices[0], identity, sizeof identity);
    set_sources(z, 0, 0, 3, ZT_NONE);
    for (uint32_t i = 1; i < count; i++) {
        double s = test_uniform(&seed, 2, 6);
        double m[9] = {s, test_uniform(&seed, -0.1, 0.1), -test_uniform(&seed, 0, 1),   0,
                       s, -test_uniform(&seed, 0, 1),     test_uniform(&seed, 0, 0.05), 0.01,
                       1};
        memcpy(z->matrices[i], m, sizeof m);
        z->parents[i] = i % 3 == 0 ? i / 2 : 0;
        set_sources(z, i, 1 + i % 2, 3, ZT_NONE);
        if (i % 5 == 0)
            set_sources(z, i, 3, 1, 4);
        if (i % 7 == 0) {
            z->source_kinds[i] = 1;
            set_sources(z, i, i % 2 * 2, i % 2 * 2, i % 4 == 0 ? 4 : ZT_NONE);
        }
    }
    return z;
}

static void release(zt__memory *memory, zt__zipmap *z) {
    zt__free(memory, z, 1, (size_t)z->block_size);
}

/* ---- rules ---------------------------------------------------------------------------------- */

/* Patch 2 is alpha with parent 0; 5 is masked; 7 shows a texture. */
static void break_patch(zt__zipmap *z, int which) {
    static const double matrices[3][9] = {
        {1, 2, 3, 2, 4, 6, 0, 0, 1},         /* singular */
        {1e200, 0, 0, 0, 1e200, 0, 0, 0, 1}, /* its determinant is infinite */
        {1, 0, 0, 0, 1, 0, 3, 0, 1},         /* its far corner lies behind */
    };
    static const struct {
        uint32_t patch, first, second, mask;
    } sources[] = {
        {2, IMAGES, 3, ZT_NONE},
        {7, OWN_TEXTURE, OWN_TEXTURE, ZT_NONE},
        {7, 1, 1, ZT_NONE}, /* has five layers */
        {7, 0, 2, ZT_NONE},
        {5, 3, 1, IMAGES},
        {5, 3, 1, 3},
        {5, 3, 1, ZT_NONE},
        {2, 1, 3, 4},
        {2, 5, 3, ZT_NONE},
    };
    if (which < 9)
        set_sources(z, sources[which].patch, sources[which].first, sources[which].second, sources[which].mask);
    else if (which < 12)
        z->matrices[2][which - 9 + 1] = which == 9 ? NAN : which == 10 ? INFINITY : -0.0;
    else
        memcpy(z->matrices[2], matrices[which - 12], sizeof matrices[0]);
}

static void break_rule(zt__zipmap *z, int which) {
    if (which == 0)
        z->layer_count = 1;
    else if (which == 1)
        z->parents[0] = 1;
    else if (which == 2)
        z->source_kinds[0] = 1;
    else if (which == 3)
        z->masks[0] = 4;
    else if (which < 6)
        z->matrices[0][1] = which == 4 ? 1e-300 : -0.0;
    else if (which < 8)
        z->parents[2] = which == 6 ? 2 : UINT32_MAX;
    else if (which == 8)
        z->source_kinds[2] = 2;
    else
        break_patch(z, which - 9);
}

static const uint32_t broken_rules[] = {8101, 8102, 8102, 8102, 8102, 8109, 8103, 8103, 8104, 8105, 8105, 8105,
                                        8105, 8106, 8106, 8107, 8107, 8108, 8109, 8109, 8109, 8110, 8110, 8111};

static void check_rules(zt__memory *memory) {
    zt__zipmap *good = make(memory, PATCHES);
    zt_diag diag = {0};
    zt__sink sink = {.diag = &diag};
    zt_result result = zt__check_zipmap(&sink, good, &scope, 100);
    CHECK(result == ZT_OK);
    if (result != ZT_OK)
        fprintf(stderr, "%s: %s\n", diag.path, diag.text);
    release(memory, good);
    for (int k = 0; k < (int)(sizeof broken_rules / sizeof broken_rules[0]); k++) {
        zt__zipmap *z = make(memory, PATCHES);
        zt_diag d = {0};
        zt__sink loader = {.diag = &d};
        break_rule(z, k);
        CHECK(zt__check_zipmap(&loader, z, &scope, 100) == ZT_CORRUPT);
        CHECK(d.rule == broken_rules[k] && d.offset == 100);
        if (d.rule != broken_rules[k])
            fprintf(stderr, "case %d: rule %u\n", k, d.rule);
        release(memory, z);

        /* The validator counts, and goes on where the rule is not fatal. */
        zt_check_options options = {0};
        zt_check_summary summary = {0};
        zt__sink validator = {.check = &options, .summary = &summary};
        z = make(memory, PATCHES);
        break_rule(z, k);
        (void)zt__check_zipmap(&validator, z, &scope, 100);
        CHECK(summary.errors >= 1);
        release(memory, z);
    }
}

/* The determinant and the product do what their names say. */
static void check_matrices(void) {
    uint64_t seed = 11;
    for (int n = 0; n < 1000; n++) {
        double m[9], a[9], p[9];
        for (int k = 0; k < 9; k++)
            m[k] = test_uniform(&seed, -2, 2);
        double d = zt__adjugate(m, a);
        zt__multiply(m, a, p);
        for (int k = 0; k < 9; k++)
            CHECK(fabs(p[k] - (k % 4 == 0 ? d : 0)) < 1e-12);
    }
}

/* ---- coding --------------------------------------------------------------------------------- */

static bool same(const zt__zipmap *a, const zt__zipmap *b) {
    size_t n = a->patch_count;
    return a->patch_count == b->patch_count && a->layer_count == b->layer_count &&
           memcmp(a->parents, b->parents, n * 4) == 0 && memcmp(a->source_kinds, b->source_kinds, n) == 0 &&
           memcmp(a->sources, b->sources, n * 4 * a->layer_count) == 0 && memcmp(a->masks, b->masks, n * 4) == 0 &&
           memcmp(a->matrices, b->matrices, n * sizeof a->matrices[0]) == 0 &&
           memcmp(a->composed, b->composed, n * sizeof a->composed[0]) == 0;
}

static zt_result decode(zt__memory *memory, const zt_limits *limits, const uint8_t *data, size_t size, zt_diag *diag) {
    zt__decoder decoder;
    zt__sink sink = {.diag = diag};
    zt__zipmap *z;
    zt__decoder_init(&decoder, memory);
    zt_result result = zt__decode_zipmap(&sink, memory, &decoder, limits, data, size, &scope, 100, &z);
    CHECK((result == ZT_OK) == (z != NULL));
    if (z)
        release(memory, z);
    zt__decoder_free(&decoder);
    return result;
}

static void check_identity(zt__memory *memory, uint32_t count) {
    zt__encoder encoder;
    zt__decoder decoder;
    zt_limits limits = {.patches = 1u << 20};
    zt__sink sink = {0};
    zt__zipmap *z = make(memory, count);
    zt__zipmap *back = NULL;
    uint8_t *bytes;
    uint64_t capacity;
    size_t size;
    CHECK(zt__check_zipmap(&sink, z, &scope, 0) == ZT_OK);
    CHECK(zt__encoder_init(&encoder, memory, 3, false, NULL) == ZT_OK);
    CHECK(zt__encode_zipmap(&encoder, z, NULL, &bytes, &capacity, &size) == ZT_OK);
    zt__decoder_init(&decoder, memory);
    CHECK(zt__decode_zipmap(&sink, memory, &decoder, &limits, bytes, size, &scope, 0, &back) == ZT_OK);
    CHECK(back && same(z, back));
    if (back)
        release(memory, back);
    zt__free(memory, bytes, capacity, 1);
    zt__decoder_free(&decoder);
    zt__encoder_free(&encoder);
    release(memory, z);
}

/* Every shorter chunk, a longer one, and damaged ones: refused, never anything worse. */
static void check_damage(zt__memory *memory) {
    zt__encoder encoder;
    zt_limits limits = {.patches = 1u << 20};
    zt__zipmap *z = make(memory, PATCHES);
    uint8_t *bytes;
    uint64_t capacity;
    size_t size;
    uint64_t seed = 21;
    CHECK(zt__encoder_init(&encoder, memory, 3, false, NULL) == ZT_OK);
    CHECK(zt__encode_zipmap(&encoder, z, NULL, &bytes, &capacity, &size) == ZT_OK);
    uint8_t *copy = malloc(size + 1);
    for (size_t n = 0; n < size; n++) {
        zt_diag d = {0};
        uint8_t *cut = malloc(n + 1); /* exact, so that a sanitizer sees a read behind the end */
        memcpy(cut, bytes, n);
        CHECK(decode(memory, &limits, cut, n, &d) == ZT_CORRUPT);
        CHECK(n >= 16 || d.rule == 8101);
        free(cut);
    }
    memcpy(copy, bytes, size);
    copy[size] = 0;
    zt_diag trailing = {0};
    CHECK(decode(memory, &limits, copy, size + 1, &trailing) == ZT_CORRUPT && trailing.rule == 5106);
    for (int n = 0; n < 3000; n++) {
        memcpy(copy, bytes, size);
        copy[test_below(&seed, (uint32_t)size)] ^= (uint8_t)(1 + test_below(&seed, 255));
        zt_result result = decode(memory, &limits, copy, size, NULL);
        CHECK(result == ZT_CORRUPT || result == ZT_LIMIT || result == ZT_UNSUPPORTED);
    }
    memcpy(copy, bytes, size);
    copy[8] = 1;
    zt_diag reserved = {0};
    CHECK(decode(memory, &limits, copy, size, &reserved) == ZT_CORRUPT && reserved.rule == 8101);

    limits.patches = PATCHES - 1;
    zt_diag patches = {0};
    CHECK(decode(memory, &limits, bytes, size, &patches) == ZT_LIMIT && patches.rule == 1007);
    limits.patches = PATCHES;
    CHECK(decode(memory, &limits, bytes, size, NULL) == ZT_OK);
    /* A header may promise what memory does not hold. */
    limits.patches = 1u << 24;
    zt__store32(copy, 1u << 24);
    copy[8] = 0;
    CHECK(decode(memory, &limits, copy, size, NULL) == ZT_LIMIT);
    free(copy);
    zt__free(memory, bytes, capacity, 1);
    zt__encoder_free(&encoder);
    release(memory, z);
}

int main(void) {
    zt__memory memory;
    zt__memory_init(&memory, NULL, UINT64_C(1) << 30);
    check_matrices();
    check_rules(&memory);
    check_identity(&memory, 1);
    check_identity(&memory, PATCHES);
    check_identity(&memory, 5000);
    check_damage(&memory);
    CHECK(memory.used == 0);
    return test_end();
}
