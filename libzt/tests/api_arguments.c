/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Every public function with every bad argument: NULL for each pointer, indices at and far above the count, structs of
 * another size, calls in the wrong state of a writer. The answer is the documented one, out-parameters are zeroed, and
 * nothing crashes: a binding in another language makes all these mistakes.
 */
#include <math.h>

#include <zt/zt_check.h>
#include <zt/zt_write.h>

#include "corpus.h"
#include "test.h"

/* Anything that is not zero, to see that a call zeroes it. */
#define DIRTY(variable) memset(&(variable), 0xA5, sizeof(variable))

static bool is_zero(const void *data, size_t size) {
    const uint8_t *p = data;
    for (size_t i = 0; i < size; i++) {
        if (p[i])
            return false;
    }
    return true;
}

#define IS_ZERO(variable) is_zero(&(variable), sizeof(variable))
#define BAD(call) CHECK((call) == ZT_BAD_ARGUMENT)

/* The same, and the diagnostic says what was wrong. */
#define BAD_DIAG(call)                                                 \
    do {                                                               \
        DIRTY(diag);                                                   \
        CHECK((call) == ZT_BAD_ARGUMENT);                              \
        CHECK(diag.result == ZT_BAD_ARGUMENT);                         \
        CHECK(diag.text[0] && memchr(diag.text, 0, sizeof diag.text)); \
        CHECK(diag.offset == UINT64_MAX && diag.size == 0);            \
    } while (0)

static zt_diag diag;

static zt_file *open_valid(const char *name, blob *b) {
    zt_file *file = NULL;
    *b = blob_read(VALID_FOLDER, name);
    CHECK(zt_open_memory(b->data, b->size, NULL, NULL, &file) == ZT_OK);
    assert(file);
    return file;
}

static zt_result never_read(void *user, uint64_t offset, void *dst, size_t size) {
    (void)user, (void)offset, (void)dst, (void)size;
    return ZT_IO;
}

static void *no_alloc(void *user, size_t size) {
    (void)user, (void)size;
    return NULL;
}

/* ---- opening and checking ---- */

static void test_open(void) {
    blob b = blob_read(VALID_FOLDER, "first.ztex");
    zt_file *file, *const dirty = (zt_file *)(uintptr_t)b.data;
    zt_io io = {NULL, never_read, 100}, no_read = {NULL, NULL, 100};
    zt_allocator half = {NULL, no_alloc, NULL};
    zt_open_options wrong_size = {.size = sizeof wrong_size - 1}, half_allocator = {.allocator = &half};
    const zt_open_options *wrong[] = {&wrong_size, &half_allocator};
    BAD_DIAG(zt_open_memory(b.data, b.size, NULL, &diag, NULL));
    BAD_DIAG(zt_open_path("x", NULL, &diag, NULL));
    BAD_DIAG(zt_open_io(&io, NULL, &diag, NULL));
    file = dirty;
    BAD_DIAG(zt_open_memory(NULL, 100, NULL, &diag, &file));
    CHECK(file == NULL);
    file = dirty;
    BAD_DIAG(zt_open_path(NULL, NULL, &diag, &file));
    CHECK(file == NULL);
    file = dirty;
    BAD_DIAG(zt_open_io(NULL, NULL, &diag, &file));
    CHECK(file == NULL);
    file = dirty;
    BAD_DIAG(zt_open_io(&no_read, NULL, &diag, &file));
    CHECK(file == NULL);
    for (int i = 0; i < 2; i++) {
        file = dirty;
        BAD_DIAG(zt_open_memory(b.data, b.size, wrong[i], &diag, &file));
        CHECK(file == NULL);
        file = dirty;
        BAD_DIAG(zt_open_path(VALID_FOLDER "first.ztex", wrong[i], &diag, &file));
        CHECK(file == NULL);
        file = dirty;
        BAD_DIAG(zt_open_io(&io, wrong[i], &diag, &file));
        CHECK(file == NULL);
    }
    file = dirty;
    CHECK(zt_open_memory(NULL, 0, NULL, &diag, &file) == ZT_NOT_ZTEX || diag.result == ZT_TRUNCATED);
    CHECK(file == NULL);
    file = dirty;
    CHECK(zt_open_path("conformance/valid/no such file", NULL, &diag, &file) == ZT_IO && file == NULL);
    CHECK(diag.result == ZT_IO && diag.text[0]);
    CHECK(zt_open_path("conformance", NULL, &diag, &file) == ZT_IO && file == NULL); /* a folder */
    CHECK(zt_open_path("/dev/null", NULL, &diag, &file) == ZT_IO && file == NULL);
    zt_open_options right = {.size = sizeof right};
    CHECK(zt_open_path(VALID_FOLDER "first.ztex", &right, NULL, &file) == ZT_OK && file != NULL);
    zt_close(file);
    zt_close(NULL);
    blob_free(b);
}

static int stop(void *user, const zt_finding *finding) {
    (void)user;
    CHECK(finding != NULL && finding->text && finding->path);
    return 1;
}

static void test_check(void) {
    blob b = blob_read(VALID_FOLDER, "first.ztex"), bad = blob_read(INVALID_FOLDER, "R2003_reserved_low.ztex");
    zt_check_summary summary;
    zt_io io = {NULL, never_read, 100}, no_read = {NULL, NULL, 100};
    zt_check_options wrong = {.size = 1}, right = {.size = sizeof right}, stopping = {.finding = stop};
    BAD_DIAG(zt_check_memory(b.data, b.size, NULL, &diag, NULL));
    BAD_DIAG(zt_check_path("x", NULL, &diag, NULL));
    BAD_DIAG(zt_check_io(&io, NULL, &diag, NULL));
    DIRTY(summary);
    BAD_DIAG(zt_check_memory(NULL, 5, NULL, &diag, &summary));
    CHECK(IS_ZERO(summary));
    DIRTY(summary);
    BAD_DIAG(zt_check_path(NULL, NULL, &diag, &summary));
    CHECK(IS_ZERO(summary));
    BAD_DIAG(zt_check_io(NULL, NULL, &diag, &summary));
    BAD_DIAG(zt_check_io(&no_read, NULL, &diag, &summary));
    DIRTY(summary);
    BAD_DIAG(zt_check_memory(b.data, b.size, &wrong, &diag, &summary));
    CHECK(IS_ZERO(summary));
    CHECK(zt_check_io(&io, NULL, &diag, &summary) == ZT_IO && diag.result == ZT_IO);
    CHECK(zt_check_path("conformance/no such file", NULL, &diag, &summary) == ZT_IO && diag.result == ZT_IO);
    CHECK(zt_check_memory(b.data, b.size, &right, NULL, &summary) == ZT_OK && summary.errors == 0);
    CHECK(zt_check_memory(bad.data, bad.size, &stopping, &diag, &summary) == ZT_CANCELLED);
    CHECK(diag.result == ZT_CANCELLED && summary.errors == 1);
    CHECK(zt_get_rule(UINT32_MAX) == NULL && zt_find_rule(0) == NULL && zt_find_rule(UINT32_MAX) == NULL);
    uint32_t last = 0;
    for (uint32_t i = 0; zt_get_rule(i); i++) {
        CHECK(zt_get_rule(i)->id > last && zt_find_rule(zt_get_rule(i)->id) == zt_get_rule(i));
        last = zt_get_rule(i)->id;
    }
    blob_free(b);
    blob_free(bad);
}

/* ---- getters ---- */

static void test_file_getters(const zt_file *file) {
    zt_file_info info;
    zt_chunk_info chunk;
    uint8_t byte[8];
    DIRTY(info);
    zt_get_file(NULL, &info);
    CHECK(IS_ZERO(info));
    zt_get_file(file, NULL);
    zt_get_file(file, &info);
    BAD(zt_get_chunk(file, 0, NULL));
    const uint32_t beyond[] = {info.chunk_count, UINT32_MAX};
    for (int i = 0; i < 2; i++) {
        DIRTY(chunk);
        BAD(zt_get_chunk(file, beyond[i], &chunk));
        CHECK(IS_ZERO(chunk));
        BAD_DIAG(zt_read_chunk(file, beyond[i], byte, sizeof byte, &diag));
    }
    DIRTY(chunk);
    BAD(zt_get_chunk(NULL, 0, &chunk));
    CHECK(IS_ZERO(chunk));
    CHECK(zt_get_chunk(file, 0, &chunk) == ZT_OK);
    BAD_DIAG(zt_read_chunk(NULL, 0, byte, sizeof byte, &diag));
    BAD_DIAG(zt_read_chunk(file, 0, NULL, (size_t)chunk.decoded_size, &diag));
    BAD_DIAG(zt_read_chunk(file, 0, byte, sizeof byte, &diag));                    /* another size */
    BAD_DIAG(zt_read_chunk(file, info.chunk_count - 1, byte, sizeof byte, &diag)); /* TEXL */
}

static void test_texture_getters(const zt_file *file) {
    zt_file_info info;
    zt_texture_info texture;
    zt_layer_info layer;
    zt_patch_info patch;
    zt_get_file(file, &info);
    const uint32_t beyond[] = {info.texture_count, UINT32_MAX};
    BAD(zt_get_texture(file, 0, NULL));
    BAD(zt_get_layer(file, 0, 0, NULL));
    BAD(zt_get_patch(file, 0, 0, NULL));
    for (int i = 0; i < 2; i++) {
        DIRTY(texture), DIRTY(layer), DIRTY(patch);
        BAD(zt_get_texture(file, beyond[i], &texture));
        BAD(zt_get_layer(file, beyond[i], 0, &layer));
        BAD(zt_get_patch(file, beyond[i], 0, &patch));
        CHECK(IS_ZERO(texture) && IS_ZERO(layer) && IS_ZERO(patch));
        CHECK(zt_get_patch_image(file, beyond[i], 0, 0) == ZT_NONE);
    }
    BAD(zt_get_texture(NULL, 0, &texture));
    BAD(zt_get_layer(NULL, 0, 0, &layer));
    BAD(zt_get_patch(NULL, 0, 0, &patch));
    CHECK(zt_get_patch_image(NULL, 0, 0, 0) == ZT_NONE);
    for (uint32_t i = 0; i < info.texture_count; i++) {
        CHECK(zt_get_texture(file, i, &texture) == ZT_OK);
        DIRTY(layer), DIRTY(patch);
        BAD(zt_get_layer(file, i, texture.layer_count, &layer));
        BAD(zt_get_layer(file, i, UINT32_MAX, &layer));
        BAD(zt_get_patch(file, i, texture.patch_count, &patch));
        BAD(zt_get_patch(file, i, UINT32_MAX, &patch));
        CHECK(IS_ZERO(layer) && IS_ZERO(patch));
        CHECK(zt_get_patch_image(file, i, texture.patch_count, 0) == ZT_NONE);
        CHECK(zt_get_patch_image(file, i, 0, texture.layer_count) == ZT_NONE);
    }
    CHECK(zt_find_texture(NULL, "a") == ZT_NONE && zt_find_texture(file, NULL) == ZT_NONE);
    CHECK(zt_find_texture(file, "no such texture") == ZT_NONE);
}

static void test_image_getters(const zt_file *file) {
    zt_file_info info;
    zt_image_info image;
    zt_level_info level;
    zt_tile_info tile;
    zt_get_file(file, &info);
    const uint32_t beyond[] = {info.image_count, UINT32_MAX};
    BAD(zt_get_image(file, 0, NULL));
    BAD(zt_get_level(file, 0, 0, NULL));
    BAD_DIAG(zt_get_tile(file, 0, 0, 0, NULL, &diag));
    for (int i = 0; i < 2; i++) {
        DIRTY(image), DIRTY(level), DIRTY(tile);
        BAD(zt_get_image(file, beyond[i], &image));
        BAD(zt_get_level(file, beyond[i], 0, &level));
        BAD_DIAG(zt_get_tile(file, beyond[i], 0, 0, &tile, &diag));
        CHECK(IS_ZERO(image) && IS_ZERO(level) && IS_ZERO(tile));
        BAD(zt_level_state(file, beyond[i], 0));
    }
    BAD(zt_get_image(NULL, 0, &image));
    BAD(zt_get_level(NULL, 0, 0, &level));
    BAD_DIAG(zt_get_tile(NULL, 0, 0, 0, &tile, &diag));
    BAD(zt_level_state(NULL, 0, 0));
    CHECK(zt_get_image(file, 0, &image) == ZT_OK && zt_get_level(file, 0, 0, &level) == ZT_OK);
    DIRTY(level), DIRTY(tile);
    BAD(zt_get_level(file, 0, image.levels, &level));
    BAD(zt_level_state(file, 0, image.levels));
    BAD_DIAG(zt_get_tile(file, 0, image.levels, 0, &tile, &diag));
    CHECK(IS_ZERO(level) && IS_ZERO(tile));
    CHECK(zt_get_level(file, 0, 0, &level) == ZT_OK);
    BAD_DIAG(zt_get_tile(file, 0, 0, level.tile_count, &tile, &diag));
    BAD_DIAG(zt_get_tile(file, 0, 0, UINT64_MAX, &tile, &diag));
    BAD(zt_get_tile(file, 0, 0, UINT64_MAX, &tile, NULL));
}

static void test_metadata_getters(const zt_file *file) {
    uint32_t count = 77;
    const char *key = "x", *value = "x";
    CHECK(zt_find_metadata(file, "zt.title") == NULL); /* not loaded yet */
    BAD(zt_get_metadata(file, 0, &key, &value));
    CHECK(!key && !value);
    BAD_DIAG(zt_load_metadata(NULL, &count, &diag));
    CHECK(count == 0);
    BAD_DIAG(zt_load_metadata(file, NULL, &diag));
    CHECK(zt_load_metadata(file, &count, NULL) == ZT_OK && count > 0);
    key = value = "x";
    BAD(zt_get_metadata(file, count, &key, &value));
    CHECK(!key && !value);
    BAD(zt_get_metadata(file, UINT32_MAX, &key, &value));
    BAD(zt_get_metadata(NULL, 0, &key, &value));
    BAD(zt_get_metadata(file, 0, NULL, &value));
    BAD(zt_get_metadata(file, 0, &key, NULL));
    CHECK(!zt_find_metadata(NULL, "a") && !zt_find_metadata(file, NULL) && !zt_find_metadata(file, "no such key"));
}

static void test_formats(void) {
    float rgba[4] = {0};
    uint8_t texel[16] = {0};
    CHECK(!zt_find_format(UINT32_MAX) && !zt_find_format(0) && !zt_get_format(UINT32_MAX));
    CHECK(!zt_find_format_name(NULL) && !zt_find_format_name("") && !zt_find_format_name("VK_FORMAT_"));
    BAD(zt_unpack_texels(37, NULL, 1, rgba));
    BAD(zt_unpack_texels(37, texel, 1, NULL));
    BAD(zt_pack_texels(37, NULL, 1, texel));
    BAD(zt_pack_texels(37, rgba, 1, NULL));
    CHECK(zt_unpack_texels(UINT32_MAX, texel, 1, rgba) == ZT_UNSUPPORTED);
    CHECK(zt_pack_texels(145, rgba, 1, texel) == ZT_UNSUPPORTED);
    CHECK(zt_unpack_texels(37, texel, 0, rgba) == ZT_OK);
    CHECK(!zt_transfer_known(0) && !zt_transfer_known(UINT32_MAX));
    (void)zt_transfer_decode(UINT32_MAX, 0.5f);
    (void)zt_transfer_encode(UINT32_MAX, NAN);
    for (int i = -3; i < 20; i++)
        CHECK(zt_result_text((zt_result)i) && zt_result_text((zt_result)i)[0]);
}

/* ---- decoding, extents, sampling ---- */

static void test_regions(const zt_file *file) {
    static uint8_t bytes[1 << 17];
    zt_level_info level;
    CHECK(zt_get_level(file, 0, 0, &level) == ZT_OK && level.layer_size <= sizeof bytes);
    const zt_region whole = {0, 0, 0, 0, 0, level.width, level.height, level.depth};
    size_t size = (size_t)level.layer_size;
    zt_decode_options wrong = {.size = 3}, right = {.size = sizeof right};
    BAD_DIAG(zt_decode_region(NULL, 0, &whole, bytes, size, 0, 0, NULL, &diag));
    BAD_DIAG(zt_decode_region(file, 0, NULL, bytes, size, 0, 0, NULL, &diag));
    BAD_DIAG(zt_decode_region(file, 0, &whole, NULL, size, 0, 0, NULL, &diag));
    BAD_DIAG(zt_decode_region(file, UINT32_MAX, &whole, bytes, size, 0, 0, NULL, &diag));
    BAD_DIAG(zt_decode_region(file, 0, &whole, bytes, size, 0, 0, &wrong, &diag));
    BAD_DIAG(zt_decode_region(file, 0, &whole, bytes, size - 1, 0, 0, NULL, &diag));
    BAD_DIAG(zt_decode_region(file, 0, &whole, bytes, 0, 0, 0, NULL, &diag));
    if (level.row_size > 1)
        BAD_DIAG(zt_decode_region(file, 0, &whole, bytes, size, (size_t)level.row_size - 1, 0, NULL, &diag));
    if (level.blocks_y > 1) {
        BAD_DIAG(zt_decode_region(file, 0, &whole, bytes, size, SIZE_MAX, 0, NULL, &diag));
        BAD_DIAG(zt_decode_region(file, 0, &whole, bytes, size, SIZE_MAX / 2, SIZE_MAX / 2, NULL, &diag));
    }
    CHECK(zt_decode_region(file, 0, &whole, bytes, size, 0, 0, &right, NULL) == ZT_OK);
    const zt_region bad[] = {{UINT32_MAX, 0, 0, 0, 0, 1, 1, 1},
                             {0, UINT32_MAX, 0, 0, 0, 1, 1, 1},
                             {0, 0, level.width, 0, 0, 1, 1, 1},
                             {0, 0, 0, level.height, 0, 1, 1, 1},
                             {0, 0, 0, 0, level.depth, 1, 1, 1},
                             {0, 0, 0, 0, 0, 0, 1, 1},
                             {0, 0, 0, 0, 0, 1, 0, 1},
                             {0, 0, 0, 0, 0, 1, 1, 0},
                             {0, 0, 0, 0, 0, level.width + 1, 1, 1},
                             {0, 0, 1, 0, 0, UINT32_MAX, 1, 1},
                             {0, 0, 0, UINT32_MAX, 0, 1, UINT32_MAX, 1},
                             {0, 0, 0, 0, UINT32_MAX, 1, 1, UINT32_MAX}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        zt_extent extent;
        size_t count = 77;
        zt_request request = {.texture = ZT_NONE, .patch = ZT_NONE, .region = &bad[i]};
        BAD_DIAG(zt_decode_region(file, 0, &bad[i], bytes, sizeof bytes, 0, 0, NULL, &diag));
        BAD_DIAG(zt_query_extents(file, &request, &extent, 1, &count, &diag));
        CHECK(count == 0);
    }
}

static void test_tiles(const zt_file *file) {
    static uint8_t bytes[1 << 17];
    zt_level_info level;
    zt_tile_info tile;
    CHECK(zt_get_level(file, 0, 0, &level) == ZT_OK && zt_get_tile(file, 0, 0, 0, &tile, NULL) == ZT_OK);
    BAD_DIAG(zt_decode_level(NULL, 0, 0, 0, bytes, sizeof bytes, 0, NULL, &diag));
    BAD_DIAG(zt_decode_level(file, UINT32_MAX, 0, 0, bytes, sizeof bytes, 0, NULL, &diag));
    BAD_DIAG(zt_decode_level(file, 0, UINT32_MAX, 0, bytes, sizeof bytes, 0, NULL, &diag));
    BAD_DIAG(zt_decode_level(file, 0, 0, UINT32_MAX, bytes, sizeof bytes, 0, NULL, &diag));
    BAD_DIAG(zt_decode_level(file, 0, 0, 0, NULL, sizeof bytes, 0, NULL, &diag));
    BAD_DIAG(zt_decode_level(file, 0, 0, 0, bytes, (size_t)level.layer_size - 1, 0, NULL, &diag));
    if (level.row_size > 1)
        BAD_DIAG(zt_decode_level(file, 0, 0, 0, bytes, sizeof bytes, (size_t)level.row_size - 1, NULL, &diag));
    BAD_DIAG(zt_decode_tile(NULL, 0, 0, 0, bytes, sizeof bytes, &diag));
    BAD_DIAG(zt_decode_tile(file, UINT32_MAX, 0, 0, bytes, sizeof bytes, &diag));
    BAD_DIAG(zt_decode_tile(file, 0, UINT32_MAX, 0, bytes, sizeof bytes, &diag));
    BAD_DIAG(zt_decode_tile(file, 0, 0, level.tile_count, bytes, sizeof bytes, &diag));
    BAD_DIAG(zt_decode_tile(file, 0, 0, 0, NULL, sizeof bytes, &diag));
    BAD_DIAG(zt_decode_tile(file, 0, 0, 0, bytes, tile.decoded_size - 1, &diag));
    BAD_DIAG(zt_read_tile(NULL, 0, 0, 0, bytes, sizeof bytes, &diag));
    BAD_DIAG(zt_read_tile(file, UINT32_MAX, 0, 0, bytes, sizeof bytes, &diag));
    BAD_DIAG(zt_read_tile(file, 0, UINT32_MAX, 0, bytes, sizeof bytes, &diag));
    BAD_DIAG(zt_read_tile(file, 0, 0, UINT64_MAX, bytes, sizeof bytes, &diag));
    BAD_DIAG(zt_read_tile(file, 0, 0, 0, NULL, sizeof bytes, &diag));
    BAD_DIAG(zt_read_tile(file, 0, 0, 0, bytes, tile.stored_size - 1, &diag));
}

static void test_extents(const zt_file *file) {
    zt_extent extent;
    size_t count = 77;
    zt_region region = {0, 0, 0, 0, 0, 1, 1, 1};
    zt_request good = {.texture = 0, .patch = ZT_NONE};
    const zt_request bad[] = {{.texture = UINT32_MAX - 1, .patch = ZT_NONE},
                              {.texture = 1000, .patch = ZT_NONE},
                              {.texture = 0, .patch = 1000},
                              {.texture = ZT_NONE, .patch = ZT_NONE, .image = 1000},
                              {.texture = ZT_NONE, .patch = ZT_NONE, .image = UINT32_MAX},
                              {.texture = 0, .patch = ZT_NONE, .min_level = 3, .max_level = 2},
                              {.texture = 0, .patch = ZT_NONE, .region = &region}};
    BAD_DIAG(zt_query_extents(NULL, &good, &extent, 1, &count, &diag));
    CHECK(count == 0);
    BAD_DIAG(zt_query_extents(file, NULL, &extent, 1, &count, &diag));
    BAD_DIAG(zt_query_extents(file, &good, &extent, 1, NULL, &diag));
    BAD_DIAG(zt_query_extents(file, &good, NULL, 1, &count, &diag));
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        count = 77;
        BAD_DIAG(zt_query_extents(file, &bad[i], &extent, 1, &count, &diag));
        CHECK(count == 0);
    }
    CHECK(zt_query_extents(file, &good, NULL, 0, &count, NULL) == ZT_OK && count > 0);
}

static void test_sampler(const zt_file *file) {
    zt_sampler *sampler, *const dirty = (zt_sampler *)(uintptr_t)&diag;
    zt_sampler_info info;
    zt_point point = {.u = 0.5, .v = 0.5};
    float out[4];
    const zt_sampler_options bad[] = {{.size = 1},
                                      {.filter = (zt_filter)3},
                                      {.max_anisotropy = 17},
                                      {.filter = ZT_FILTER_NEAREST, .max_anisotropy = 4},
                                      {.layer = 32},
                                      {.layer = UINT32_MAX}};
    BAD_DIAG(zt_sampler_open(file, 0, NULL, &diag, NULL));
    sampler = dirty;
    BAD_DIAG(zt_sampler_open(NULL, 0, NULL, &diag, &sampler));
    CHECK(sampler == NULL);
    sampler = dirty;
    BAD_DIAG(zt_sampler_open(file, UINT32_MAX, NULL, &diag, &sampler));
    CHECK(sampler == NULL);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        sampler = dirty;
        BAD_DIAG(zt_sampler_open(file, 0, &bad[i], &diag, &sampler));
        CHECK(sampler == NULL);
        if (sampler)
            fprintf(stderr, "sampler options %zu are accepted\n", i);
    }
    CHECK(zt_sampler_open(file, 0, NULL, NULL, &sampler) == ZT_OK && sampler != NULL);
    BAD_DIAG(zt_sample(NULL, &point, 1, out, &diag));
    BAD_DIAG(zt_sample(sampler, NULL, 1, out, &diag));
    BAD_DIAG(zt_sample(sampler, &point, 1, NULL, &diag));
    CHECK(zt_sample(sampler, &point, 0, out, NULL) == ZT_OK && zt_sample(sampler, &point, 1, out, NULL) == ZT_OK);
    DIRTY(info);
    zt_get_sampler(NULL, &info);
    CHECK(IS_ZERO(info));
    zt_get_sampler(sampler, NULL);
    zt_sampler_close(sampler);
    zt_sampler_close(NULL);
}

static void test_threads(void) {
    zt_threads *threads = (zt_threads *)(uintptr_t)&diag;
    BAD(zt_threads_open(257, &threads));
    CHECK(threads == NULL);
    threads = (zt_threads *)(uintptr_t)&diag;
    BAD(zt_threads_open(UINT32_MAX, &threads));
    CHECK(threads == NULL);
    BAD(zt_threads_open(1, NULL));
    CHECK(zt_threads_open(1, &threads) == ZT_OK && threads != NULL);
    zt_threads_close(threads);
    zt_threads_close(NULL);
}

int main(void) {
    static const char *const names[] = {"zip_meta_unknown_chunk.ztex", "meta_zstd.ztex"};
    blob b;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        zt_file *file = open_valid(names[i], &b);
        test_file_getters(file);
        test_texture_getters(file);
        test_image_getters(file);
        test_metadata_getters(file);
        test_regions(file);
        test_tiles(file);
        test_extents(file);
        test_sampler(file);
        zt_close(file);
        blob_free(b);
    }
    test_open();
    test_check();
    test_formats();
    test_threads();
    return test_end();
}
