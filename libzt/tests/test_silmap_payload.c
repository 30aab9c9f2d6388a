/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: a silmap comes back from encoding and decoding as it was, each of rules 8201 to 8207 is found when it alone
 * is broken, memory limits hold before anything is allocated, and cells that say nothing cost nothing in the file.
 * Payloads come from files of strangers.
 */
#include <stdlib.h>
#include <string.h>

#include "silmap_payload.h"
#include "test.h"

enum { WIDTH = 9, HEIGHT = 6, LAYERS = 2, IMAGES = 13, OWN_TEXTURE = 2 };

/* As the samples of a repeating texture: 9 x 6; of one that clamps: 10 x 7. Minified images: 9 x 6 with levels. */
#define IMAGE(format_, w, h, d, layers_, levels_, transfer_, alpha, kind)                                         \
    {                                                                                                             \
        .format = (format_), .width = (w), .height = (h), .depth = (d), .layers = (layers_), .levels = (levels_), \
        .transfer = (transfer_), .alpha_mode = (alpha), .layer_kind = (kind)                                      \
    }
static const zt__image_record images[IMAGES] = {
    IMAGE(37, 10, 7, 1, 3, 1, 8, 0, 0), /* 0: the samples of layer 0 */
    IMAGE(9, 10, 7, 1, 3, 1, 8, 0, 0),  /* 1: of layer 1 */
    IMAGE(37, 9, 6, 1, 3, 4, 8, 0, 0),  /* 2: minified of layer 0 */
    IMAGE(37, 10, 7, 1, 3, 2, 8, 0, 0), /* 3 on: samples that are not right: levels */
    IMAGE(37, 10, 7, 2, 3, 1, 8, 0, 0), /* 4: a volume */
    IMAGE(37, 10, 7, 1, 3, 1, 8, 0, 1), /* 5: cube faces */
    IMAGE(37, 9, 7, 1, 3, 1, 8, 0, 0),  /* 6 */
    IMAGE(37, 10, 6, 1, 3, 1, 8, 0, 0), /* 7 */
    IMAGE(37, 10, 7, 1, 2, 1, 8, 0, 0), /* 8: array layers */
    IMAGE(43, 9, 6, 1, 3, 1, 8, 0, 0),  /* 9 on: minified images that are not right: format */
    IMAGE(37, 9, 6, 1, 3, 1, 8, 1, 0),  /* 10: alpha */
    IMAGE(37, 9, 6, 1, 3, 1, 13, 0, 0), /* 11: transfer */
    IMAGE(37, 9, 6, 1, 1, 1, 8, 0, 0),  /* 12: array layers */
};

static const zt__image_record *image_of(const void *user, uint32_t image) {
    (void)user;
    return image < IMAGES ? &images[image] : NULL;
}

static uint32_t texture_layers(const void *user, uint32_t texture) {
    (void)user;
    (void)texture;
    return LAYERS;
}

static zt__payload_scope scope_of(zt_wrap u, zt_wrap v) {
    zt__payload_scope s = {.texture = OWN_TEXTURE,
                           .layer_count = LAYERS,
                           .wrap_u = (uint8_t)u,
                           .wrap_v = (uint8_t)v,
                           .image_count = IMAGES,
                           .image_of = image_of,
                           .texture_layers = texture_layers};
    return s;
}

static zt__silmap *make(zt__memory *memory, uint32_t cell_layers) {
    zt__silmap_header header = {WIDTH, HEIGHT, cell_layers, LAYERS, ZT_SILMAP_CONTINUOUS};
    zt__payload_scope scope = scope_of(ZT_WRAP_CLAMP, ZT_WRAP_MIRROR);
    zt__silmap *s;
    uint64_t seed = 5;
    CHECK(zt__silmap_new(memory, &header, &scope, NULL, &s) == ZT_OK);
    for (uint64_t i = 0; i < s->cell_count; i++) {
        s->cells[i] = (uint8_t)test_below(&seed, 256);
        if (i % WIDTH == 0)
            s->cells[i] &= (uint8_t)~ZT_SILMAP_WEST;
        if (i % (WIDTH * HEIGHT) < WIDTH)
            s->cells[i] &= (uint8_t)~ZT_SILMAP_NORTH;
    }
    s->samples[0] = 0;
    s->samples[1] = 1;
    s->minified[0] = 2;
    s->minified[1] = ZT_NONE;
    zt__tidy_silmap(s);
    return s;
}

static void release(zt__memory *memory, zt__silmap *s) {
    zt__free(memory, s, 1, (size_t)s->block_size);
}

/* ---- rules ---------------------------------------------------------------------------------- */

typedef struct breakage {
    uint32_t rule;
    uint32_t samples[LAYERS], minified[LAYERS];
} breakage;

static const breakage broken_images[] = {
    {8203, {IMAGES, 1}, {2, ZT_NONE}}, {8203, {0, ZT_NONE}, {2, ZT_NONE}}, {8203, {3, 1}, {2, ZT_NONE}},
    {8203, {4, 1}, {2, ZT_NONE}},      {8203, {5, 1}, {ZT_NONE, ZT_NONE}}, {8203, {6, 1}, {2, ZT_NONE}},
    {8203, {0, 7}, {2, ZT_NONE}},      {8204, {0, 8}, {2, ZT_NONE}},       {8205, {0, 1}, {IMAGES, ZT_NONE}},
    {8205, {0, 1}, {0, ZT_NONE}},      {8205, {0, 1}, {9, ZT_NONE}},       {8205, {0, 1}, {10, ZT_NONE}},
    {8205, {0, 1}, {11, ZT_NONE}},     {8205, {0, 1}, {12, ZT_NONE}},      {8205, {0, 1}, {2, 2}},
};

static zt_result check(const zt__silmap *s, zt_diag *diag, zt_check_summary *summary) {
    static const zt_check_options options = {0};
    zt__payload_scope scope = scope_of(ZT_WRAP_CLAMP, ZT_WRAP_MIRROR);
    zt__sink sink = {.diag = diag, .check = summary ? &options : NULL, .summary = summary};
    if (diag)
        memset(diag, 0, sizeof *diag);
    return zt__check_silmap(&sink, s, &scope, 100);
}

static void expect_broken(const zt__silmap *s, uint32_t rule) {
    zt_diag diag;
    zt_check_summary summary = {0};
    CHECK(check(s, &diag, NULL) == ZT_CORRUPT);
    CHECK(diag.rule == rule && diag.offset == 100);
    if (diag.rule != rule)
        fprintf(stderr, "rule %u: %u %s\n", rule, diag.rule, diag.text);
    (void)check(s, NULL, &summary);
    CHECK(summary.errors >= 1);
}

static void check_image_rules(zt__memory *memory) {
    for (size_t i = 0; i < sizeof broken_images / sizeof *broken_images; i++) {
        zt__silmap *s = make(memory, 3);
        memcpy(s->samples, broken_images[i].samples, sizeof broken_images[i].samples);
        memcpy(s->minified, broken_images[i].minified, sizeof broken_images[i].minified);
        expect_broken(s, broken_images[i].rule);
        release(memory, s);
    }
    zt__silmap *s = make(memory, 2);
    expect_broken(s, 8204);
    release(memory, s);
}

static void check_cell_rules(zt__memory *memory) {
    zt_check_summary summary = {0};
    zt__silmap *s = make(memory, 3);
    CHECK(check(s, NULL, &summary) == ZT_OK && summary.errors == 0 && summary.warnings == 0);
    s->cells[WIDTH * HEIGHT + 2 * WIDTH] |= ZT_SILMAP_WEST;
    expect_broken(s, 8206);
    s->cells[WIDTH * HEIGHT + 2 * WIDTH] &= (uint8_t)~ZT_SILMAP_WEST;
    s->cells[2 * WIDTH * HEIGHT + 4] |= ZT_SILMAP_NORTH;
    expect_broken(s, 8206);
    s->repeat_y = true;                        /* as if it went round */
    CHECK(check(s, NULL, NULL) == ZT_CORRUPT); /* the samples are those of a texture that does not */
    release(memory, s);

    /* One warning however many the cells; a loader goes on, and tidying mends them. */
    s = make(memory, 3);
    memset(s->cells, 0x12, (size_t)s->cell_count);
    memset(&summary, 0, sizeof summary);
    CHECK(check(s, NULL, &summary) == ZT_OK && summary.errors == 0 && summary.warnings == 1);
    CHECK(check(s, NULL, NULL) == ZT_OK);
    zt__tidy_silmap(s);
    for (uint64_t i = 0; i < s->cell_count; i++)
        CHECK(s->cells[i] == ZT_SILMAP_DEFAULT);
    release(memory, s);
}

/* A cell is idle when all four arms are uncut; two of them are its neighbours' bits, across the seam where that is
 * one. */
static void check_idle(zt__memory *memory) {
    for (int repeat = 0; repeat < 2; repeat++) {
        zt__silmap *s = make(memory, 3);
        s->repeat_x = s->repeat_y = repeat != 0;
        memset(s->cells, 0x12, (size_t)s->cell_count);
        uint8_t *second = s->cells + WIDTH * HEIGHT;
        second[3 * WIDTH + 4] = 0x12 | ZT_SILMAP_WEST | ZT_SILMAP_NORTH;
        second[0] = (uint8_t)(0x12 | (repeat ? ZT_SILMAP_WEST | ZT_SILMAP_NORTH : 0));
        zt__tidy_silmap(s);
        for (uint32_t i = 0; i < (uint32_t)s->cell_count; i++) {
            uint32_t at = i - WIDTH * HEIGHT;
            bool kept = at == 3 * WIDTH + 4 || at == 3 * WIDTH + 3 || at == 2 * WIDTH + 4 ||
                        (repeat && (at == 0 || at == WIDTH - 1 || at == (HEIGHT - 1) * WIDTH));
            CHECK((s->cells[i] == ZT_SILMAP_DEFAULT) == !kept);
        }
        release(memory, s);
    }
}

static void check_header_rules(void) {
    static const struct {
        uint32_t rule;
        zt__silmap_header header;
    } rows[] = {
        {0, {WIDTH, HEIGHT, 1, LAYERS, 2}},
        {0, {1 << 20, 1 << 11, 1, LAYERS, 0}},
        {8201, {0, HEIGHT, 1, LAYERS, 0}},
        {8201, {WIDTH, 0, 1, LAYERS, 0}},
        {8201, {WIDTH, HEIGHT, 0, LAYERS, 0}},
        {8201, {WIDTH, HEIGHT, 1, LAYERS + 1, 0}},
        {8201, {(1 << 20) + 1, 1, 1, LAYERS, 0}},
        {8201, {1, (1 << 20) + 1, 1, LAYERS, 0}},
        {8201, {1, 1, (1 << 16) + 1, LAYERS, 0}},
        {8201, {1 << 20, 1 << 12, 1, LAYERS, 0}},
        {8201, {1 << 20, 1 << 20, 1 << 16, LAYERS, 0}},
        {8202, {WIDTH, HEIGHT, 1, LAYERS, 3}},
    };
    zt__payload_scope scope = scope_of(ZT_WRAP_CLAMP, ZT_WRAP_CLAMP);
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        zt_diag diag = {0};
        zt__sink sink = {.diag = &diag};
        zt_result result = zt__check_silmap_header(&sink, &rows[i].header, &scope, 0);
        CHECK(result == (rows[i].rule ? ZT_CORRUPT : ZT_OK) && diag.rule == rows[i].rule);
    }
}

/* ---- coding --------------------------------------------------------------------------------- */

typedef struct coded {
    uint8_t *bytes;
    uint64_t capacity;
    size_t size;
} coded;

static coded encode(zt__memory *memory, const zt__silmap *s) {
    zt__encoder encoder;
    coded c;
    CHECK(zt__encoder_init(&encoder, memory, 9, false, NULL) == ZT_OK);
    CHECK(zt__encode_silmap(&encoder, s, NULL, &c.bytes, &c.capacity, &c.size) == ZT_OK);
    zt__encoder_free(&encoder);
    return c;
}

static zt_result decode(zt__memory *memory, const uint8_t *data, size_t size, zt_diag *diag, zt__silmap **out) {
    zt__decoder decoder;
    zt__sink sink = {.diag = diag};
    zt__silmap *s;
    zt__payload_scope scope = scope_of(ZT_WRAP_CLAMP, ZT_WRAP_MIRROR);
    zt__decoder_init(&decoder, memory);
    zt_result result = zt__decode_silmap(&sink, memory, &decoder, data, size, &scope, 100, &s);
    CHECK((result == ZT_OK) == (s != NULL));
    if (out)
        *out = s;
    else if (s)
        release(memory, s);
    zt__decoder_free(&decoder);
    return result;
}

static void check_identity(zt__memory *memory) {
    for (uint32_t layers = 1; layers <= 3; layers += 2) {
        zt__silmap *s = make(memory, layers), *back = NULL;
        coded c = encode(memory, s);
        CHECK(decode(memory, c.bytes, c.size, NULL, &back) == ZT_OK);
        CHECK(back && back->header.cells_x == WIDTH && back->header.cells_y == HEIGHT);
        CHECK(back && back->header.cell_layers == layers && back->header.layer_count == LAYERS);
        CHECK(back && back->header.filter == s->header.filter && back->cell_count == s->cell_count);
        CHECK(back && memcmp(back->cells, s->cells, (size_t)s->cell_count) == 0);
        CHECK(back && memcmp(back->samples, s->samples, LAYERS * 4) == 0);
        CHECK(back && memcmp(back->minified, s->minified, LAYERS * 4) == 0);
        if (back)
            release(memory, back);
        zt__free(memory, c.bytes, c.capacity, 1);
        release(memory, s);
    }
}

/* Every shorter chunk, a longer one, and damaged ones: refused, never anything worse. */
static void check_damage(zt__memory *memory) {
    zt__silmap *s = make(memory, 3);
    coded c = encode(memory, s);
    uint64_t seed = 21;
    uint8_t *copy = malloc(c.size + 1);
    for (size_t n = 0; n < c.size; n++) {
        zt_diag d = {0};
        uint8_t *cut = malloc(n + 1); /* exact, so that a sanitizer sees a read behind the end */
        memcpy(cut, c.bytes, n);
        CHECK(decode(memory, cut, n, &d, NULL) == ZT_CORRUPT);
        CHECK(n >= 24 || d.rule == 8201);
        free(cut);
    }
    memcpy(copy, c.bytes, c.size);
    copy[c.size] = 0;
    zt_diag diag = {0};
    CHECK(decode(memory, copy, c.size + 1, &diag, NULL) == ZT_CORRUPT && diag.rule == 5106);
    for (int n = 0; n < 3000; n++) {
        memcpy(copy, c.bytes, c.size);
        uint32_t at = test_below(&seed, (uint32_t)c.size);
        copy[at] ^= (uint8_t)(1 + test_below(&seed, 255));
        zt_result result = decode(memory, copy, c.size, NULL, NULL);
        CHECK(result == ZT_CORRUPT || result == ZT_LIMIT || (result == ZT_OK && at == 16)); /* another filter */
    }
    for (size_t i = 17; i < 24; i++) {
        memcpy(copy, c.bytes, c.size);
        copy[i] = 1;
        memset(&diag, 0, sizeof diag);
        CHECK(decode(memory, copy, c.size, &diag, NULL) == ZT_CORRUPT && diag.rule == 8201);
    }
    free(copy);
    zt__free(memory, c.bytes, c.capacity, 1);
    release(memory, s);
}

/* A chunk of 200 bytes may promise 2^31 cells: a plane of one value stores none of them. */
static void check_promises(void) {
    zt__memory memory;
    uint8_t bytes[24 + 32] = {0};
    zt_diag diag = {0};
    zt__memory_init(&memory, NULL, UINT64_C(1) << 24);
    zt__store32(bytes, 1 << 20);
    zt__store32(bytes + 4, 1 << 11);
    zt__store32(bytes + 8, 1);
    zt__store32(bytes + 12, LAYERS);
    CHECK(decode(&memory, bytes, sizeof bytes, &diag, NULL) == ZT_LIMIT);
    CHECK(memory.used == 0);
}

static void check_default_cells(zt__memory *memory) {
    zt__silmap_header header = {1024, 1024, 1, LAYERS, ZT_SILMAP_CONTINUOUS};
    zt__payload_scope scope = scope_of(ZT_WRAP_CLAMP, ZT_WRAP_CLAMP);
    zt__silmap *s;
    CHECK(zt__silmap_new(memory, &header, &scope, NULL, &s) == ZT_OK);
    memset(s->cells, ZT_SILMAP_DEFAULT, (size_t)s->cell_count);
    s->samples[0] = s->samples[1] = s->minified[0] = s->minified[1] = 0;
    coded c = encode(memory, s);
    CHECK(c.size <= 24 + 3 * 32);
    zt__free(memory, c.bytes, c.capacity, 1);
    release(memory, s);
}

int main(void) {
    zt__memory memory;
    zt__memory_init(&memory, NULL, UINT64_C(1) << 30);
    check_header_rules();
    check_image_rules(&memory);
    check_cell_rules(&memory);
    check_idle(&memory);
    check_identity(&memory);
    check_damage(&memory);
    check_promises();
    check_default_cells(&memory);
    CHECK(memory.used == 0);
    return test_end();
}
