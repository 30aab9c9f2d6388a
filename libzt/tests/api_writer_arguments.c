/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The writer with bad arguments and in the wrong state: every call is refused with a reason, the rule of the format
 * where one would be broken, and what is written afterwards, if anything, is valid.
 */
#include <math.h>

#include <zt/zt_check.h>
#include <zt/zt_write.h>

#include "corpus.h"
#include "test.h"

#define BAD(call)                                                               \
    do {                                                                        \
        memset(&diag, 0xA5, sizeof diag);                                       \
        CHECK((call) == ZT_BAD_ARGUMENT);                                       \
        CHECK(diag.result == ZT_BAD_ARGUMENT && diag.text[0]);                  \
        if (diag.result != ZT_BAD_ARGUMENT)                                     \
            fprintf(stderr, "%d: %s\n", __LINE__, zt_result_text(diag.result)); \
    } while (0)

/* The same with a rule of the specification. */
#define BAD_RULE(expected, call)                                                        \
    do {                                                                                \
        BAD(call);                                                                      \
        CHECK(diag.rule == (expected));                                                 \
        if (diag.rule != (expected))                                                    \
            fprintf(stderr, "%d: R%u instead of R%u\n", __LINE__, diag.rule, expected); \
    } while (0)

typedef struct output {
    uint8_t data[1 << 16];
    size_t size;
    zt_result answer;
} output;

static zt_diag diag;
static output out;

static zt_result collect(void *user, const void *data, size_t size) {
    output *o = user;
    if (o->answer != ZT_OK)
        return o->answer;
    assert(size <= sizeof o->data - o->size);
    memcpy(o->data + o->size, data, size);
    o->size += size;
    return ZT_OK;
}

static zt_writer *open_writer(void) {
    zt_writer *writer = NULL;
    zt_sink sink = {&out, collect};
    memset(&out, 0, sizeof out);
    CHECK(zt_writer_open_sink(&sink, NULL, &diag, &writer) == ZT_OK && writer);
    assert(writer);
    return writer;
}

static void test_open(void) {
    zt_writer *writer;
    zt_sink sink = {&out, collect}, no_write = {&out, NULL};
    zt_allocator half = {0};
    const zt_writer_options bad[] = {{.size = 1}, {.effort = 10}, {.effort = -1}, {.allocator = &half}};
    BAD(zt_writer_open_sink(&sink, NULL, &diag, NULL));
    BAD(zt_writer_open_path("x.ztex", NULL, &diag, NULL));
    writer = (zt_writer *)(uintptr_t)&out;
    BAD(zt_writer_open_sink(NULL, NULL, &diag, &writer));
    CHECK(writer == NULL);
    writer = (zt_writer *)(uintptr_t)&out;
    BAD(zt_writer_open_sink(&no_write, NULL, &diag, &writer));
    CHECK(writer == NULL);
    writer = (zt_writer *)(uintptr_t)&out;
    BAD(zt_writer_open_path(NULL, NULL, &diag, &writer));
    CHECK(writer == NULL);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        writer = (zt_writer *)(uintptr_t)&out;
        BAD(zt_writer_open_sink(&sink, &bad[i], &diag, &writer));
        CHECK(writer == NULL);
    }
    writer = (zt_writer *)(uintptr_t)&out;
    CHECK(zt_writer_open_path("conformance/no folder/x.ztex", NULL, &diag, &writer) == ZT_IO && writer == NULL);
    CHECK(diag.result == ZT_IO && diag.text[0]);
    zt_writer_close(NULL);
}

static void test_images(void) {
    static const zt_image_desc good = {.format = 37, .width = 4, .height = 3, .levels = 1};
    zt_writer *writer = open_writer();
    zt_image_desc d = good;
    uint32_t image = 77;
    BAD(zt_writer_add_image(NULL, &d, &diag, &image));
    BAD(zt_writer_add_image(writer, NULL, &diag, &image));
    BAD(zt_writer_add_image(writer, &d, &diag, NULL));
#define TRY_FIELD(rule, field, value)                                   \
    do {                                                                \
        d = good;                                                       \
        d.field = (value);                                              \
        BAD_RULE(rule, zt_writer_add_image(writer, &d, &diag, &image)); \
    } while (0)
    TRY_FIELD(6002, width, 0);
    TRY_FIELD(6002, width, (1 << 20) + 1);
    TRY_FIELD(6002, height, 0);
    TRY_FIELD(6002, height, UINT32_MAX);
    TRY_FIELD(6002, depth, (1 << 14) + 1);
    TRY_FIELD(6002, layers, (1 << 16) + 1);
    TRY_FIELD(6003, levels, 4);
    TRY_FIELD(6006, alpha_mode, (zt_alpha)3);
    TRY_FIELD(6007, layer_kind, (zt_layer_kind)3);
    TRY_FIELD(6007, layer_kind, ZT_LAYERS_CUBE);
    TRY_FIELD(6008, primaries, 3);
    TRY_FIELD(6008, transfer, 19);
#undef TRY_FIELD
    d = good, d.levels = 300;
    BAD(zt_writer_add_image(writer, &d, &diag, &image));
    d = good, d.tile_edge = 17;
    BAD(zt_writer_add_image(writer, &d, &diag, &image));
    d = good, d.tile_edge = 8;
    BAD(zt_writer_add_image(writer, &d, &diag, &image));
    d = good, d.tile_edge = 1 << 17;
    BAD(zt_writer_add_image(writer, &d, &diag, &image));
    d = good, d.format = 145; /* BC7 without given levels */
    d.levels = 2;
    BAD(zt_writer_add_image(writer, &d, &diag, &image));
    d = good, d.format = 0x7FFFFFF0, d.given_levels = 1;
    BAD_RULE(6005, zt_writer_add_image(writer, &d, &diag, &image));
    d = good, d.mip_filter = 4, d.levels = 0;
    BAD(zt_writer_add_image(writer, &d, &diag, &image));
    d = good, d.wrap_u = 4, d.levels = 0;
    BAD(zt_writer_add_image(writer, &d, &diag, &image));
    BAD(zt_writer_finish(writer, &diag)); /* nothing in it */
    zt_writer_close(writer);
}

static void test_rows(void) {
    static const zt_image_desc good = {.format = 37, .width = 4, .height = 3, .levels = 1};
    zt_image_desc given = good;
    zt_writer *writer = open_writer();
    uint8_t rows[64] = {0};
    uint32_t image, second;
    given.given_levels = 1;
    CHECK(zt_writer_add_image(writer, &good, &diag, &image) == ZT_OK && image == 0);
    CHECK(zt_writer_add_image(writer, &given, &diag, &second) == ZT_OK && second == 1);
    BAD(zt_writer_put_rows(NULL, image, rows, 1, 0, &diag));
    BAD(zt_writer_put_rows(writer, 2, rows, 1, 0, &diag));
    BAD(zt_writer_put_rows(writer, UINT32_MAX, rows, 1, 0, &diag));
    BAD(zt_writer_put_rows(writer, image, NULL, 1, 0, &diag));
    BAD(zt_writer_put_rows(writer, image, rows, 4, 0, &diag));
    BAD(zt_writer_put_rows(writer, image, rows, UINT32_MAX, 0, &diag));
    BAD(zt_writer_put_rows(writer, image, rows, 1, 15, &diag));
    BAD(zt_writer_put_level_rows(NULL, second, 0, rows, 1, 0, &diag));
    BAD(zt_writer_put_level_rows(writer, 2, 0, rows, 1, 0, &diag));
    BAD(zt_writer_put_level_rows(writer, second, 1, rows, 1, 0, &diag));
    BAD(zt_writer_put_level_rows(writer, second, 0, NULL, 1, 0, &diag));
    BAD(zt_writer_put_level_rows(writer, second, 0, rows, 4, 0, &diag));
    BAD(zt_writer_put_stored_tile(NULL, second, 0, 0, 0, 0, rows, 48, &diag));
    BAD(zt_writer_put_stored_tile(writer, 2, 0, 0, 0, 0, rows, 48, &diag));
    BAD(zt_writer_put_stored_tile(writer, second, 1, 0, 0, 0, rows, 48, &diag));
    BAD(zt_writer_put_stored_tile(writer, second, 0, 1, 0, 0, rows, 48, &diag));
    BAD(zt_writer_put_stored_tile(writer, second, 0, 0, 0, 0, NULL, 48, &diag));
    BAD(zt_writer_put_stored_tile(writer, second, 0, 0, 0, 0, rows, 47, &diag));
    BAD(zt_writer_put_stored_tile(writer, second, 0, 0, 1, 0, rows, 48, &diag)); /* zstd, not smaller */
    BAD(zt_writer_put_stored_tile(writer, second, 0, 0, 0, 0, rows, 0, &diag));
    CHECK(zt_writer_put_level_rows(writer, second, 0, rows, 1, 0, &diag) == ZT_OK);
    BAD(zt_writer_put_stored_tile(writer, second, 0, 0, 0, 0, rows, 48, &diag)); /* rows have come */
    CHECK(zt_writer_put_rows(writer, image, rows, 3, 0, &diag) == ZT_OK);
    BAD(zt_writer_put_rows(writer, image, rows, 1, 0, &diag)); /* full */
    BAD(zt_writer_finish(writer, &diag));                      /* the second is not */
    zt_writer_close(writer);
}

static void add_full_image(zt_writer *writer, uint32_t format, zt_alpha alpha, uint32_t layers) {
    uint8_t rows[256] = {0};
    uint32_t image;
    zt_image_desc d = {.format = format, .width = 4, .height = 3, .layers = layers, .levels = 1, .alpha_mode = alpha};
    CHECK(zt_writer_add_image(writer, &d, &diag, &image) == ZT_OK);
    CHECK(zt_writer_put_rows(writer, image, rows, 3 * layers, 0, &diag) == ZT_OK);
}

static void test_textures(zt_writer *writer) {
    zt_layer_desc layers[33] = {{0, 0}};
    uint32_t texture;
    char long_name[300];
    memset(long_name, 'a', sizeof long_name);
    long_name[256] = 0;
    zt_texture_desc d = {.name = "a"};
    BAD(zt_writer_add_texture(NULL, &d, &diag, &texture));
    BAD(zt_writer_add_texture(writer, NULL, &diag, &texture));
    CHECK(zt_writer_add_texture(writer, &d, &diag, NULL) == ZT_OK);
    BAD_RULE(6108, zt_writer_add_texture(writer, &d, &diag, &texture));
    d = (zt_texture_desc){.name = "\xff"};
    BAD_RULE(6107, zt_writer_add_texture(writer, &d, &diag, &texture));
    d = (zt_texture_desc){.name = long_name};
    BAD_RULE(6107, zt_writer_add_texture(writer, &d, &diag, &texture));
    d = (zt_texture_desc){.wrap_v = (zt_wrap)4};
    BAD_RULE(6104, zt_writer_add_texture(writer, &d, &diag, &texture));
    d = (zt_texture_desc){.image = 3};
    BAD_RULE(6106, zt_writer_add_texture(writer, &d, &diag, &texture));
    d = (zt_texture_desc){.layers = layers, .layer_count = 33};
    BAD_RULE(6105, zt_writer_add_texture(writer, &d, &diag, &texture));
    d = (zt_texture_desc){.layer_count = 2};
    BAD(zt_writer_add_texture(writer, &d, &diag, &texture));
    layers[1].image = 2; /* more array layers */
    d = (zt_texture_desc){.layers = layers, .layer_count = 2};
    BAD_RULE(6109, zt_writer_add_texture(writer, &d, &diag, &texture));
}

static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

static void test_zipmaps(zt_writer *writer) {
    zt_layer_desc layer = {ZT_SEMANTIC_BASE_COLOUR, 0};
    zt_texture_desc d = {.name = "zoom", .layers = &layer, .layer_count = 1};
    uint32_t root = 0, child = 1, beyond = 3, texture;
    zt_patch_desc good[2] = {{.sources = &root, .mask = ZT_NONE}, {.sources = &child, .mask = ZT_NONE}}, p[2];
    memcpy(good[0].matrix, identity, sizeof identity);
    memcpy(good[1].matrix, identity, sizeof identity);
    BAD(zt_writer_add_zipmap(NULL, &d, good, 2, &diag, &texture));
    BAD(zt_writer_add_zipmap(writer, NULL, good, 2, &diag, &texture));
    BAD(zt_writer_add_zipmap(writer, &d, NULL, 2, &diag, &texture));
    BAD(zt_writer_add_zipmap(writer, &d, good, 0, &diag, &texture));
#define TRY_PATCH(rule, change)                                                  \
    do {                                                                         \
        memcpy(p, good, sizeof p);                                               \
        change;                                                                  \
        BAD_RULE(rule, zt_writer_add_zipmap(writer, &d, p, 2, &diag, &texture)); \
    } while (0)
    TRY_PATCH(8102, p[0].matrix[2] = 0.5);
    TRY_PATCH(8102, p[0].mask = 0);
    TRY_PATCH(8103, p[1].parent = 1);
    TRY_PATCH(8105, p[1].sources = &beyond);
    TRY_PATCH(8105, (p[1].sources = &beyond, p[1].shows_texture = 1));
    TRY_PATCH(8106, p[1].mask = 3);
    TRY_PATCH(8107, p[1].sources = &root);
    TRY_PATCH(8109, p[1].matrix[1] = INFINITY);
    TRY_PATCH(8110, p[1].matrix[0] = 0);
#undef TRY_PATCH
    memcpy(p, good, sizeof p);
    p[1].sources = NULL;
    BAD(zt_writer_add_zipmap(writer, &d, p, 2, &diag, &texture));
    CHECK(zt_writer_add_zipmap(writer, &d, good, 2, &diag, &texture) == ZT_OK && texture == 1);
}

static void test_rest(zt_writer *writer) {
    uint8_t byte = 0;
    uint32_t dropped = 77;
    BAD(zt_writer_set_metadata(NULL, "a", "b", &diag));
    BAD(zt_writer_set_metadata(writer, NULL, "b", &diag));
    BAD_RULE(7002, zt_writer_set_metadata(writer, "", "b", &diag));
    BAD_RULE(7002, zt_writer_set_metadata(writer, "a\n", "b", &diag));
    BAD_RULE(7004, zt_writer_set_metadata(writer, "a", "\xc0\x80", &diag));
    CHECK(zt_writer_set_metadata(writer, "never set", NULL, &diag) == ZT_OK);
    BAD(zt_writer_add_chunk(NULL, "XABC", 1, 0, &byte, 1, &diag));
    BAD(zt_writer_add_chunk(writer, NULL, 1, 0, &byte, 1, &diag));
    BAD(zt_writer_add_chunk(writer, "XAB", 1, 0, &byte, 1, &diag));
    BAD(zt_writer_add_chunk(writer, "XABCD", 1, 0, &byte, 1, &diag));
    BAD(zt_writer_add_chunk(writer, "xabc", 1, 0, &byte, 1, &diag));
    BAD(zt_writer_add_chunk(writer, "XABC", 1, 1, &byte, 1, &diag)); /* critical */
    BAD(zt_writer_add_chunk(writer, "XABC", 1, 4, &byte, 1, &diag));
    BAD(zt_writer_add_chunk(writer, "XABC", 1, 0, NULL, 1, &diag));
    BAD(zt_writer_add_chunk(writer, "XABC", 1, 0, &byte, 0, &diag));
    BAD(zt_writer_add_chunk(writer, "META", 1, 2, &byte, 1, &diag));
    BAD(zt_writer_add_chunk(writer, "TEXL", 1, 0, &byte, 1, &diag));
    CHECK(zt_writer_add_chunk(writer, "XABC", 1, 0, &byte, 1, &diag) == ZT_OK);
    BAD(zt_writer_add_chunk(writer, "XABC", 1, 0, &byte, 1, &diag)); /* twice */
    BAD(zt_writer_copy_rest(writer, NULL, &diag, &dropped));
    CHECK(dropped == 0);
    BAD(zt_writer_copy_rest(NULL, NULL, &diag, &dropped));
}

/* Everything that was refused has left no trace: the file is valid. Afterwards only closing is allowed. */
static void test_finish(zt_writer *writer) {
    zt_check_summary summary;
    uint8_t row[16] = {0};
    uint32_t index;
    zt_image_desc image = {.format = 37, .width = 4, .height = 3};
    zt_texture_desc texture = {.name = "late"};
    BAD(zt_writer_finish(NULL, &diag));
    CHECK(zt_writer_finish(writer, &diag) == ZT_OK);
    CHECK(zt_check_memory(out.data, out.size, NULL, &diag, &summary) == ZT_OK && summary.errors == 0);
    size_t size = out.size;
    BAD(zt_writer_finish(writer, &diag));
    BAD(zt_writer_add_image(writer, &image, &diag, &index));
    BAD(zt_writer_put_rows(writer, 0, row, 1, 0, &diag));
    BAD(zt_writer_put_level_rows(writer, 0, 0, row, 1, 0, &diag));
    BAD(zt_writer_put_stored_tile(writer, 0, 0, 0, 0, 0, row, 16, &diag));
    BAD(zt_writer_add_texture(writer, &texture, &diag, &index));
    BAD(zt_writer_set_metadata(writer, "a", "b", &diag));
    BAD(zt_writer_add_chunk(writer, "XABD", 1, 0, row, 1, &diag));
    CHECK(out.size == size);
}

static void test_sink_fails(zt_result answer) {
    zt_writer *writer = open_writer();
    zt_texture_desc texture = {.name = "a"};
    add_full_image(writer, 37, ZT_ALPHA_NONE, 1);
    CHECK(zt_writer_add_texture(writer, &texture, &diag, NULL) == ZT_OK);
    out.answer = answer;
    CHECK(zt_writer_finish(writer, &diag) == answer && diag.result == answer && diag.text[0]);
    zt_writer_close(writer);
}

int main(void) {
    test_open();
    test_images();
    test_rows();
    zt_writer *writer = open_writer();
    add_full_image(writer, 37, ZT_ALPHA_NONE, 1);
    add_full_image(writer, 37, ZT_ALPHA_STRAIGHT, 1);
    add_full_image(writer, 37, ZT_ALPHA_NONE, 2);
    test_textures(writer);
    test_zipmaps(writer);
    test_rest(writer);
    test_finish(writer);
    zt_writer_close(writer);
    test_sink_fails(ZT_IO);
    test_sink_fails(ZT_CANCELLED);
    return test_end();
}
