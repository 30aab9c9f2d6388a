/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Each field of zt_limits: one below what a file needs gives ZT_LIMIT, exactly that and one more open it. A ceiling
 * holds before memory is asked for, so a small file cannot make a reader allocate what it merely promises.
 */
#include <zt/zt_check.h>
#include <zt/zt_write.h>

#include "corpus.h"
#include "test.h"

typedef enum field {
    FILE_SIZE,
    METADATA,
    CHUNKS,
    TEXTURES,
    IMAGES,
    DIMENSION,
    LAYERS,
    PATCHES,
    TILE_SIZE,
    DEPTH,
    SHOWN,
    LISTED
} field;

static void set(zt_limits *limits, field which, uint64_t value) {
    uint32_t small = (uint32_t)value;
    switch (which) {
    case FILE_SIZE:
        limits->file_size = value;
        break;
    case METADATA:
        limits->metadata = value;
        break;
    case CHUNKS:
        limits->chunks = small;
        break;
    case TEXTURES:
        limits->textures = small;
        break;
    case IMAGES:
        limits->images = small;
        break;
    case DIMENSION:
        limits->dimension = small;
        break;
    case LAYERS:
        limits->layers = small;
        break;
    case PATCHES:
        limits->patches = small;
        break;
    case TILE_SIZE:
        limits->tile_size = small;
        break;
    case DEPTH:
        limits->texture_depth = small;
        break;
    case SHOWN:
        limits->shown_textures = small;
        break;
    case LISTED:
        limits->listed_umbrellas = small;
        break;
    }
}

/* Opens, and loads the metadata when they are what is limited. */
static zt_result open_limited(blob b, const zt_limits *limits, field which, counting *memory, zt_diag *diag) {
    uint32_t count;
    zt_file *file;
    counting_init(memory);
    zt_open_options options = {.allocator = &memory->allocator, .limits = limits};
    zt_result result = zt_open_memory(b.data, b.size, &options, diag, &file);
    if (result == ZT_OK && which == METADATA)
        result = zt_load_metadata(file, &count, diag);
    zt_close(file);
    CHECK(memory->live == 0);
    return result;
}

static void check_agrees(blob b, const zt_limits *limits, uint32_t rule, bool over) {
    zt_check_summary summary;
    zt_check_options options = {.limits = limits};
    CHECK(zt_check_memory(b.data, b.size, &options, NULL, &summary) == ZT_OK);
    CHECK(summary.errors == 0 && (summary.limits > 0) == over);
    CHECK(rule > 1000 && rule < 2000);
}

static void test_field(const char *name, field which, uint64_t need, uint32_t rule) {
    blob b = blob_read(VALID_FOLDER, name);
    uint64_t peak = 0;
    zt_diag diag;
    counting memory;
    for (uint64_t value = need + 1; value >= need - 1 && value > 0; value--) {
        zt_limits limits = {0};
        set(&limits, which, value);
        zt_result result = open_limited(b, &limits, which, &memory, &diag);
        bool over = value < need;
        CHECK(result == (over ? ZT_LIMIT : ZT_OK));
        CHECK(!over || (diag.rule == rule && diag.text[0]));
        if (result != (over ? ZT_LIMIT : ZT_OK))
            fprintf(stderr, "%s: limit %llu of field %d: %s: R%u %s\n", name, (unsigned long long)value, (int)which,
                    zt_result_text(result), diag.rule, diag.text);
        CHECK(!over || memory.peak <= peak);
        peak = memory.peak;
        check_agrees(b, &limits, rule, over);
    }
    blob_free(b);
}

/* The exact need is found by trying; below it ZT_LIMIT, from it on success, and never more than allowed is live. */
static void test_memory(const char *name) {
    blob b = blob_read(VALID_FOLDER, name);
    zt_diag diag;
    counting memory;
    uint64_t low = 0, high = UINT64_C(1) << 24;
    while (high - low > 1) {
        uint64_t middle = (low + high) / 2;
        zt_limits limits = {.memory = middle};
        zt_result result = open_limited(b, &limits, FILE_SIZE, &memory, &diag);
        CHECK(result == ZT_OK || (result == ZT_LIMIT && diag.rule == 1010));
        CHECK(memory.peak <= middle);
        if (result == ZT_OK)
            high = middle;
        else
            low = middle;
    }
    for (uint64_t value = high - 2; value <= high + 2; value++) {
        zt_limits limits = {.memory = value};
        CHECK(open_limited(b, &limits, FILE_SIZE, &memory, &diag) == (value < high ? ZT_LIMIT : ZT_OK));
    }
    blob_free(b);
}

/* Decoding and sampling stay below the ceiling too. */
static void test_memory_of_calls(const char *name) {
    blob b = blob_read(VALID_FOLDER, name);
    bool decoded = false, refused = false;
    for (uint64_t ceiling = 1024; ceiling < (UINT64_C(1) << 24); ceiling += ceiling / 8) {
        counting memory;
        zt_diag diag;
        zt_file *file;
        zt_level_info info;
        zt_limits limits = {.memory = ceiling};
        counting_init(&memory);
        zt_open_options options = {.allocator = &memory.allocator, .limits = &limits};
        if (zt_open_memory(b.data, b.size, &options, &diag, &file) == ZT_OK) {
            CHECK(zt_get_level(file, 0, 0, &info) == ZT_OK);
            uint8_t *texels = malloc((size_t)info.layer_size);
            zt_result result = zt_decode_level(file, 0, 0, 0, texels, (size_t)info.layer_size, 0, NULL, &diag);
            CHECK(result == ZT_OK || (result == ZT_LIMIT && diag.rule == 1010));
            decoded |= result == ZT_OK;
            refused |= result == ZT_LIMIT;
            free(texels);
        }
        zt_close(file);
        CHECK(memory.live == 0 && memory.peak <= ceiling);
    }
    CHECK(decoded && refused);
    blob_free(b);
}

/* Zero is the default, not zero and not unlimited; the largest numbers do not overflow. */
static void test_ends(void) {
    blob b = blob_read(VALID_FOLDER, "zip_in_zip.ztex");
    counting memory;
    zt_diag diag;
    zt_limits zero = {0}, most;
    memset(&most, 0xFF, sizeof most);
    CHECK(open_limited(b, &zero, METADATA, &memory, &diag) == ZT_OK);
    CHECK(open_limited(b, &most, METADATA, &memory, &diag) == ZT_OK);
    for (int i = FILE_SIZE; i <= LISTED; i++) {
        zt_limits one = {0};
        set(&one, (field)i, 1);
        zt_result result = open_limited(b, &one, (field)i, &memory, &diag);
        CHECK(result == ZT_LIMIT || result == ZT_OK);
    }
    blob_free(b);
}

/* ---- textures that show textures: no file of the corpus goes deep ---- */

static uint8_t chain[1 << 14];
static size_t chain_size;

static zt_result append(void *user, const void *data, size_t size) {
    (void)user;
    assert(size <= sizeof chain - chain_size);
    memcpy(chain + chain_size, data, size);
    chain_size += size;
    return ZT_OK;
}

/* Texture 0 is an image without coverage; each of the zipmaps 1 to depth shows the one before in so many patches. */
static void write_chain(uint32_t depth, uint32_t copies) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const uint8_t texels[16] = {0};
    zt_sink sink = {NULL, append};
    zt_image_desc image = {.format = 37, .width = 2, .height = 2, .levels = 1};
    zt_texture_desc plain = {.image = 0}, zoom = {.layers = &(zt_layer_desc){1, 0}, .layer_count = 1};
    zt_writer *writer;
    uint32_t index, root = 0;
    CHECK(zt_writer_open_sink(&sink, NULL, NULL, &writer) == ZT_OK);
    CHECK(zt_writer_add_image(writer, &image, NULL, &index) == ZT_OK);
    CHECK(zt_writer_put_rows(writer, index, texels, 2, 0, NULL) == ZT_OK);
    CHECK(zt_writer_add_texture(writer, &plain, NULL, &index) == ZT_OK);
    for (uint32_t i = 0; i < depth; i++) {
        uint32_t shown = index;
        zt_patch_desc patches[4] = {{.sources = &root, .mask = ZT_NONE}};
        assert(copies < 4);
        for (uint32_t k = 1; k <= copies; k++)
            patches[k] = (zt_patch_desc){.sources = &shown, .shows_texture = 1, .mask = ZT_NONE};
        for (uint32_t k = 0; k <= copies; k++)
            memcpy(patches[k].matrix, identity, sizeof identity);
        CHECK(zt_writer_add_zipmap(writer, &zoom, patches, copies + 1, NULL, &index) == ZT_OK);
    }
    CHECK(zt_writer_finish(writer, NULL) == ZT_OK);
    zt_writer_close(writer);
}

static void test_depth(uint32_t depth) {
    chain_size = 0;
    write_chain(depth, 1);
    for (uint32_t limit = depth - 1; limit <= depth + 1; limit++) {
        zt_limits limits = {.texture_depth = limit};
        zt_open_options options = {.limits = &limits};
        zt_diag diag;
        zt_file *file;
        zt_sampler *sampler;
        CHECK(zt_open_memory(chain, chain_size, &options, &diag, &file) == ZT_OK);
        zt_result result = zt_sampler_open(file, depth, NULL, &diag, &sampler);
        CHECK(result == (limit < depth ? ZT_LIMIT : ZT_OK));
        CHECK(result == ZT_OK || diag.rule == 1011);
        if (result != (limit < depth ? ZT_LIMIT : ZT_OK))
            fprintf(stderr, "depth %u, limit %u: %s\n", depth, limit, zt_result_text(result));
        zt_sampler_close(sampler);
        zt_close(file);
    }
}

/* Three patches that each show a zipmap of three patches: 3 + 9 textures for one point. Without a limit the work would
 * grow with the depth as a power. */
static void test_shown(void) {
    chain_size = 0;
    write_chain(2, 3);
    for (uint32_t limit = 11; limit <= 13; limit++) {
        zt_limits limits = {.shown_textures = limit};
        zt_open_options options = {.limits = &limits};
        zt_point points[2] = {{.u = 0.5, .v = 0.5}, {.u = 0.25, .v = 0.75}};
        float out[8];
        zt_diag diag;
        zt_file *file;
        zt_sampler *sampler;
        CHECK(zt_open_memory(chain, chain_size, &options, &diag, &file) == ZT_OK);
        CHECK(zt_sampler_open(file, 2, NULL, &diag, &sampler) == ZT_OK);
        zt_result result = zt_sample(sampler, points, 2, out, &diag);
        CHECK(result == (limit < 12 ? ZT_LIMIT : ZT_OK));
        CHECK(result == ZT_OK || diag.rule == 1012);
        zt_sampler_close(sampler);
        zt_close(file);
    }
}

static uint64_t size_of(const char *name) {
    blob b = blob_read(VALID_FOLDER, name);
    blob_free(b);
    return b.size;
}

static uint64_t metadata_size(const char *name) {
    blob b = blob_read(VALID_FOLDER, name);
    zt_file *file;
    zt_chunk_info info;
    uint64_t size = 0;
    CHECK(zt_open_memory(b.data, b.size, NULL, NULL, &file) == ZT_OK);
    for (uint32_t i = 0; zt_get_chunk(file, i, &info) == ZT_OK; i++)
        size = strcmp(info.type, "META") == 0 ? info.decoded_size : size;
    zt_close(file);
    blob_free(b);
    return size;
}

/* The largest number of something in a file. */
static uint32_t largest(const char *name, field which) {
    blob b = blob_read(VALID_FOLDER, name);
    zt_file *file;
    zt_file_info info;
    uint32_t found = 0;
    CHECK(zt_open_memory(b.data, b.size, NULL, NULL, &file) == ZT_OK);
    zt_get_file(file, &info);
    for (uint32_t i = 0; which == PATCHES && i < info.texture_count; i++) {
        zt_texture_info texture;
        CHECK(zt_get_texture(file, i, &texture) == ZT_OK);
        found = texture.patch_count > found ? texture.patch_count : found;
    }
    for (uint32_t i = 0; which == LAYERS && i < info.image_count; i++) {
        zt_image_info image;
        CHECK(zt_get_image(file, i, &image) == ZT_OK);
        found = image.layers > found ? image.layers : found;
    }
    zt_umbrella_info umbrellas;
    if (which == LISTED && zt_get_umbrellas(file, 0, &umbrellas) == ZT_OK)
        found = umbrellas.longest_list;
    if (which == CHUNKS)
        found = info.chunk_count;
    if (which == TEXTURES)
        found = info.texture_count;
    if (which == IMAGES)
        found = info.image_count;
    zt_close(file);
    blob_free(b);
    return found;
}

/* Decoded bytes of the largest tile or mip tail. */
static uint32_t largest_unit(const char *name) {
    blob b = blob_read(VALID_FOLDER, name);
    zt_file *file;
    zt_level_info level;
    zt_tile_info tile;
    uint32_t found = 0;
    CHECK(zt_open_memory(b.data, b.size, NULL, NULL, &file) == ZT_OK);
    for (uint32_t k = 0; zt_get_level(file, 0, k, &level) == ZT_OK; k++) {
        for (uint64_t t = 0; t < level.tile_count; t++) {
            CHECK(zt_get_tile(file, 0, k, t, &tile, NULL) == ZT_OK);
            found = tile.decoded_size > found ? tile.decoded_size : found;
        }
    }
    zt_close(file);
    blob_free(b);
    return found;
}

int main(void) {
    test_field("first.ztex", FILE_SIZE, size_of("first.ztex"), 1001);
    test_field("chunk_unknown_30.ztex", CHUNKS, largest("chunk_unknown_30.ztex", CHUNKS), 1002);
    test_field("texture_wrap_modes.ztex", TEXTURES, largest("texture_wrap_modes.ztex", TEXTURES), 1003);
    test_field("images_40.ztex", IMAGES, 40, 1004);
    test_field("width_1048576.ztex", DIMENSION, 1 << 20, 1005);
    test_field("height_1048576.ztex", DIMENSION, 1 << 20, 1005);
    test_field("tail_volume_deep_128.ztex", DIMENSION, 128, 1005);
    test_field("layers_65536.ztex", LAYERS, 1 << 16, 1006);
    test_field("array_3_layers.ztex", LAYERS, largest("array_3_layers.ztex", LAYERS), 1006);
    test_field("planes_300_patches.ztex", PATCHES, largest("planes_300_patches.ztex", PATCHES), 1007);
    test_field("umbrella_example.ztex", LISTED, largest("umbrella_example.ztex", LISTED), 1013);
    test_field("meta_raw.ztex", METADATA, metadata_size("meta_raw.ztex"), 1009);
    test_field("meta_zstd.ztex", METADATA, metadata_size("meta_zstd.ztex"), 1009);
    test_field("tiles_edge_16_clipped.ztex", TILE_SIZE, largest_unit("tiles_edge_16_clipped.ztex"), 1008);
    test_field("levels_full_100x37.ztex", TILE_SIZE, largest_unit("levels_full_100x37.ztex"), 1008);
    test_field("tail_exactly_262144.ztex", TILE_SIZE, 262144, 1008);
    test_field("tail_volume_deep_128.ztex", TILE_SIZE, largest_unit("tail_volume_deep_128.ztex"), 1008);
    test_memory("first.ztex");
    test_memory("zip_in_zip.ztex");
    test_memory("planes_300_patches.ztex");
    test_memory("images_40.ztex");
    test_memory_of_calls("tile_zstd_encoder.ztex");
    test_memory_of_calls("tail_exactly_262144.ztex");
    test_ends();
    test_depth(4);
    test_shown();
    return test_end();
}
