/* SPDX-License-Identifier: Apache-2.0 */
/*
 * When memory runs out, at whichever allocation: every call answers ZT_NO_MEMORY (or does without), nothing leaks, and
 * what was opened before stays usable. The N-th request alone fails, and then all from the N-th on, for every N until
 * a run gets through.
 */
#include <zt/zt_check.h>
#include <zt/zt_write.h>

#include "corpus.h"
#include "test.h"

/* One use of the library: ZT_OK, or the first error. */
typedef zt_result use(blob b, const zt_allocator *allocator, zt_diag *diag);

static uint64_t runs;

static void run(const char *name, const char *file, blob b, use *what, bool from_then_on) {
    counting memory;
    zt_diag diag;
    for (uint64_t n = 1; n < 100000; n++) {
        counting_init(&memory);
        memory.fail_at = n;
        memory.fail_on = from_then_on;
        memset(&diag, 0, sizeof diag);
        zt_result result = what(b, &memory.allocator, &diag);
        bool told = result == ZT_OK || (diag.result == result && diag.text[0]);
        bool right = memory.live == 0 && (result == ZT_OK || result == ZT_NO_MEMORY) && told;
        CHECK(right);
        if (!right)
            fprintf(stderr, "%s of %s, allocation %llu%s: %s: %s, %llu bytes left\n", name, file, (unsigned long long)n,
                    from_then_on ? " and on" : "", zt_result_text(result), diag.text, (unsigned long long)memory.live);
        runs++;
        if (memory.calls < n) {
            CHECK(result == ZT_OK);
            return;
        }
    }
    fprintf(stderr, "%s of %s never gets through\n", name, file);
    test_failures++;
}

static zt_result open_blob(blob b, const zt_allocator *allocator, zt_diag *diag, zt_file **file) {
    zt_open_options options = {.allocator = allocator};
    *file = (zt_file *)(uintptr_t)b.data; /* must become NULL */
    zt_result result = zt_open_memory(b.data, b.size, &options, diag, file);
    CHECK((result == ZT_OK) == (*file != NULL));
    return result;
}

static zt_result use_open(blob b, const zt_allocator *allocator, zt_diag *diag) {
    zt_file *file;
    uint32_t count;
    size_t extents;
    zt_request request = {.max_level = 30, .patch = ZT_NONE};
    zt_result result = open_blob(b, allocator, diag, &file);
    if (result == ZT_OK)
        result = zt_load_metadata(file, &count, diag);
    if (result == ZT_OK)
        result = zt_query_extents(file, &request, NULL, 0, &extents, diag);
    zt_close(file);
    return result;
}

static zt_result use_decode(blob b, const zt_allocator *allocator, zt_diag *diag) {
    zt_file *file;
    zt_level_info info;
    zt_tile_info tile;
    zt_result result = open_blob(b, allocator, diag, &file);
    for (uint32_t i = 0; result == ZT_OK && zt_get_level(file, i, 0, &info) == ZT_OK; i++) {
        uint8_t *texels = malloc((size_t)info.layer_size);
        result = zt_decode_level(file, i, 0, 0, texels, (size_t)info.layer_size, 0, NULL, diag);
        /* The file is as good as before. */
        zt_diag again;
        zt_result second = zt_decode_level(file, i, 0, 0, texels, (size_t)info.layer_size, 0, NULL, &again);
        CHECK(second == ZT_OK || second == ZT_NO_MEMORY);
        if (result == ZT_OK)
            result = zt_get_tile(file, i, 0, 0, &tile, diag);
        free(texels);
        texels = malloc(result == ZT_OK ? tile.decoded_size : 1);
        if (result == ZT_OK)
            result = zt_decode_tile(file, i, 0, 0, texels, tile.decoded_size, diag);
        free(texels);
    }
    zt_close(file);
    return result;
}

static zt_result use_chunks(blob b, const zt_allocator *allocator, zt_diag *diag) {
    zt_file *file;
    zt_chunk_info info;
    zt_result result = open_blob(b, allocator, diag, &file);
    for (uint32_t i = 0; result == ZT_OK && zt_get_chunk(file, i, &info) == ZT_OK; i++) {
        if (strcmp(info.type, "TEXL") == 0)
            continue;
        void *bytes = malloc((size_t)info.decoded_size);
        result = zt_read_chunk(file, i, bytes, (size_t)info.decoded_size, diag);
        free(bytes);
    }
    zt_close(file);
    return result;
}

static zt_result use_sample(blob b, const zt_allocator *allocator, zt_diag *diag) {
    zt_file *file;
    zt_file_info info = {0};
    zt_point points[3] = {{.u = 0.5, .v = 0.5}, {.u = 0.2, .v = 0.7, .du_dx = 0.1, .dv_dy = 0.4}, {.u = 0.9}};
    float out[12];
    zt_result result = open_blob(b, allocator, diag, &file);
    if (result == ZT_OK)
        zt_get_file(file, &info);
    for (uint32_t i = 0; result == ZT_OK && i < info.texture_count; i++) {
        zt_sampler *sampler;
        zt_sampler_options options = {.max_anisotropy = 4};
        result = zt_sampler_open(file, i, &options, diag, &sampler);
        CHECK((result == ZT_OK) == (sampler != NULL));
        if (result == ZT_OK)
            result = zt_sample(sampler, points, 3, out, diag);
        zt_sampler_close(sampler);
    }
    zt_close(file);
    return result;
}

static zt_result use_check(blob b, const zt_allocator *allocator, zt_diag *diag) {
    zt_check_options options = {.allocator = allocator};
    zt_check_summary summary;
    zt_result result = zt_check_memory(b.data, b.size, &options, diag, &summary);
    CHECK(result != ZT_OK || (summary.errors == 0 && summary.complete));
    return result;
}

/* ---- writing ---- */

static zt_result discard(void *user, const void *data, size_t size) {
    uint64_t *total = user;
    CHECK(data != NULL && size > 0);
    *total += size;
    return ZT_OK;
}

static zt_result add_things(zt_writer *writer, const zt_file *file, zt_diag *diag) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    uint8_t texels[40 * 4];
    uint32_t image, masked, texture;
    zt_image_desc desc = {.format = 37, .width = 40, .height = 33, .tile_edge = 16, .alpha_mode = ZT_ALPHA_STRAIGHT};
    for (size_t i = 0; i < sizeof texels; i++)
        texels[i] = (uint8_t)(i * 7);
    zt_result result = zt_writer_add_image(writer, &desc, diag, &image);
    for (int row = 0; row < 33 && result == ZT_OK; row++)
        result = zt_writer_put_rows(writer, image, texels, 1, 0, diag);
    desc.zero_border = 1;
    if (result == ZT_OK)
        result = zt_writer_add_image(writer, &desc, diag, &masked);
    for (int row = 0; row < 33 && result == ZT_OK; row++)
        result = zt_writer_put_rows(writer, masked, texels, 1, 0, diag);
    zt_texture_desc plain = {.name = "plain", .image = 0};
    if (result == ZT_OK)
        result = zt_writer_add_texture(writer, &plain, diag, &texture);
    uint32_t sources[2] = {0, 1};
    zt_patch_desc patches[2] = {{.sources = &sources[0], .mask = ZT_NONE}, {.sources = &sources[1], .mask = ZT_NONE}};
    zt_layer_desc layer = {.semantic = ZT_SEMANTIC_BASE_COLOUR};
    zt_texture_desc zoom = {.name = "zoom", .layers = &layer, .layer_count = 1};
    memcpy(patches[0].matrix, identity, sizeof identity);
    memcpy(patches[1].matrix, identity, sizeof identity);
    if (result == ZT_OK)
        result = zt_writer_add_zipmap(writer, &zoom, patches, 2, diag, &texture);
    if (result == ZT_OK)
        result = zt_writer_set_metadata(writer, "zt.title", "memory", diag);
    if (result == ZT_OK)
        result = zt_writer_set_metadata(writer, "zt.title", "memory again", diag);
    if (result == ZT_OK)
        result = zt_writer_add_chunk(writer, "XTST", 1, 2, texels, sizeof texels, diag);
    if (result == ZT_OK && file)
        result = zt_writer_copy_rest(writer, file, diag, NULL);
    return result;
}

static zt_result use_write(blob b, const zt_allocator *allocator, zt_diag *diag) {
    uint64_t total = 0;
    zt_sink sink = {&total, discard};
    zt_writer *writer = NULL;
    zt_file *file = NULL;
    zt_writer_options options = {.allocator = allocator, .effort = 1};
    zt_result result = zt_open_memory(b.data, b.size, NULL, diag, &file);
    CHECK(result == ZT_OK);
    result = zt_writer_open_sink(&sink, &options, diag, &writer);
    CHECK((result == ZT_OK) == (writer != NULL));
    if (result == ZT_OK)
        result = add_things(writer, file, diag);
    if (result == ZT_OK)
        result = zt_writer_finish(writer, diag);
    CHECK(result != ZT_OK || total > 0);
    zt_writer_close(writer);
    zt_close(file);
    return result;
}

/* Tiles that are copied as they are stored. */
static zt_result copy_tiles(zt_writer *writer, const zt_file *file, zt_diag *diag) {
    zt_image_info im;
    zt_level_info info;
    zt_tile_info tile;
    uint32_t index;
    CHECK(zt_get_image(file, 0, &im) == ZT_OK);
    zt_image_desc desc = {.format = im.format,
                          .width = im.width,
                          .height = im.height,
                          .levels = im.levels,
                          .tile_edge = im.tile_edge,
                          .alpha_mode = (zt_alpha)im.alpha_mode,
                          .given_levels = 1};
    zt_result result = zt_writer_add_image(writer, &desc, diag, &index);
    for (uint32_t k = 0; k < im.levels && k <= im.tail_level && result == ZT_OK; k++) {
        CHECK(zt_get_level(file, 0, k, &info) == ZT_OK);
        for (uint64_t t = 0; t < info.tile_count && result == ZT_OK; t++) {
            CHECK(zt_get_tile(file, 0, k, t, &tile, NULL) == ZT_OK);
            uint8_t *stored = malloc(tile.stored_size);
            CHECK(zt_read_tile(file, 0, k, t, stored, tile.stored_size, NULL) == ZT_OK);
            result = zt_writer_put_stored_tile(writer, index, k, t, tile.codec, tile.hash, stored, tile.stored_size,
                                               diag);
            free(stored);
        }
    }
    zt_texture_desc texture = {.name = "copy", .image = 0};
    return result == ZT_OK ? zt_writer_add_texture(writer, &texture, diag, NULL) : result;
}

static zt_result use_copy(blob b, const zt_allocator *allocator, zt_diag *diag) {
    uint64_t total = 0;
    zt_sink sink = {&total, discard};
    zt_writer *writer = NULL;
    zt_file *file = NULL;
    zt_writer_options options = {.allocator = allocator};
    zt_result result = zt_open_memory(b.data, b.size, NULL, diag, &file);
    CHECK(result == ZT_OK);
    result = zt_writer_open_sink(&sink, &options, diag, &writer);
    if (result == ZT_OK)
        result = copy_tiles(writer, file, diag);
    if (result == ZT_OK)
        result = zt_writer_finish(writer, diag);
    zt_writer_close(writer);
    zt_close(file);
    return result;
}

/* ---- recovering ---- */

static zt_result read_blob(void *user, uint64_t offset, void *dst, size_t size) {
    const blob *b = user;
    if (offset > b->size || size > b->size - offset)
        return ZT_IO;
    memcpy(dst, b->data + offset, size);
    return ZT_OK;
}

/* A file whose directory is lost and which has faults all over; or, with_directory, only these. */
static zt_result recover(blob b, bool with_directory, const zt_allocator *allocator, zt_diag *diag) {
    uint64_t total = 0;
    zt_sink sink = {&total, discard};
    zt_writer *writer = NULL;
    zt_writer_options options = {.allocator = allocator, .effort = 1};
    zt_recover_options recover_options = {.allocator = allocator};
    zt_recover_report report;
    blob damaged = blob_prefix(b, b.size);
    if (!with_directory)
        memset(damaged.data + 64, 0xEE, 48);
    for (size_t at = damaged.size - damaged.size / 3; at < damaged.size; at += 501)
        damaged.data[at] ^= 0x55;
    zt_io io = {&damaged, read_blob, damaged.size};
    zt_result result = zt_writer_open_sink(&sink, &options, diag, &writer);
    if (result == ZT_OK)
        result = zt_recover(&io, writer, &recover_options, diag, &report);
    if (result == ZT_OK)
        result = zt_writer_finish(writer, diag);
    CHECK(result != ZT_OK || (total > 0 && !report.complete));
    zt_writer_close(writer);
    blob_free(damaged);
    return result;
}

static zt_result use_recover(blob b, const zt_allocator *allocator, zt_diag *diag) {
    return recover(b, true, allocator, diag);
}

static zt_result use_recover_blind(blob b, const zt_allocator *allocator, zt_diag *diag) {
    return recover(b, false, allocator, diag);
}

int main(void) {
    static const struct {
        const char *name;
        use *what;
        const char *files[8];
    } uses[] = {
        {"open",
         use_open,
         {"first.ztex", "zip_in_zip.ztex", "meta_zstd_encoder.ztex", "imag_zstd_encoder.ztex", "images_40.ztex",
          "planes_mixed.ztex", "texture_layers_32.ztex"}},
        {"decode",
         use_decode,
         {"first.ztex", "tile_zstd_encoder.ztex", "tiles_edge_16_clipped.ztex", "zip_several.ztex"}},
        {"chunks", use_chunks, {"chunk_unknown_zstd.ztex", "texs_zstd_encoder.ztex", "zip_meta_unknown_chunk.ztex"}},
        {"sample",
         use_sample,
         {"first.ztex", "zip_in_zip.ztex", "zip_mask.ztex", "zip_layers.ztex", "tile_zstd_encoder.ztex",
          "volume_tiled.ztex"}},
        {"check",
         use_check,
         {"first.ztex", "zip_several.ztex", "chunk_unknown_zstd.ztex", "meta_zstd.ztex", "tiles_edge_16_clipped.ztex"}},
        {"write", use_write, {"chunk_unknown_zstd.ztex", "meta_zstd.ztex"}},
        {"copy", use_copy, {"tiles_many.ztex", "tiles_raw_and_zstd_mixed.ztex"}},
        {"recover", use_recover, {"tiles_many.ztex", "zip_several.ztex", "zip_meta_unknown_chunk.ztex"}},
        {"recover without a directory", use_recover_blind, {"tiles_many.ztex", "zip_several.ztex"}},
    };
    for (size_t i = 0; i < sizeof uses / sizeof *uses; i++) {
        for (size_t k = 0; k < 8 && uses[i].files[k]; k++) {
            blob b = blob_read(VALID_FOLDER, uses[i].files[k]);
            run(uses[i].name, uses[i].files[k], b, uses[i].what, false);
            run(uses[i].name, uses[i].files[k], b, uses[i].what, true);
            blob_free(b);
        }
    }
    CHECK(runs > 1000); /* allocations that were made to fail */
    return test_end();
}
