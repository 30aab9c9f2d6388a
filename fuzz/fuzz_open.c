/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Opening: any bytes are refused with a complete diagnostic or give a file whose getters all answer, within the limit
 * of memory, and zt_check with ZT_CHECK_STRUCTURE finds an error exactly when opening refuses.
 */
#include <stdbool.h>

#include "support.h"

enum { LOOKED_AT = 64, MOST_EXTENTS = 32 };

/* ---- getters ---- */

static void visit_chunks(const zt_file *file, uint32_t count, uint64_t size) {
    zt_chunk_info info;
    zt_diag diag;
    for (uint32_t i = 0; i < count; i++) {
        REQUIRE(zt_get_chunk(file, i, &info) == ZT_OK);
        REQUIRE(strlen(info.type) == 4);
        if (strcmp(info.type, "TEXL") == 0 || info.decoded_size > 1 << 20)
            continue;
        uint8_t *bytes = fuzz_malloc((size_t)info.decoded_size);
        fuzz_require_diag(&diag, zt_read_chunk(file, i, bytes, (size_t)info.decoded_size, &diag), size);
        free(bytes);
    }
    REQUIRE(zt_get_chunk(file, count, &info) == ZT_BAD_ARGUMENT);
}

static void visit_levels(const zt_file *file, uint32_t image, uint64_t size, const zt_image_info *im) {
    zt_level_info level;
    zt_tile_info tile;
    zt_diag diag;
    for (uint32_t k = 0; k < im->levels; k++) {
        REQUIRE(zt_get_level(file, image, k, &level) == ZT_OK);
        REQUIRE(level.width >= 1 && level.height >= 1 && level.depth >= 1 && level.tile_count >= 1);
        REQUIRE(level.unit_offset <= size && level.unit_size <= size - level.unit_offset);
        REQUIRE(zt_level_state(file, image, k) == ZT_OK);
        for (uint64_t t = 0; t < level.tile_count && t < LOOKED_AT; t++) {
            zt_result result = zt_get_tile(file, image, k, t, &tile, &diag);
            fuzz_require_diag(&diag, result, size);
            REQUIRE(result != ZT_OK || (tile.offset >= level.unit_offset && tile.stored_size <= level.unit_size));
        }
    }
    REQUIRE(zt_get_level(file, image, im->levels, &level) == ZT_BAD_ARGUMENT);
}

static void visit_images(const zt_file *file, uint32_t count, uint64_t size) {
    zt_image_info info;
    for (uint32_t i = 0; i < count && i < LOOKED_AT; i++) {
        REQUIRE(zt_get_image(file, i, &info) == ZT_OK);
        REQUIRE(info.levels >= 1 && info.tail_level <= info.levels);
        visit_levels(file, i, size, &info);
    }
    REQUIRE(zt_get_image(file, count, &info) == ZT_BAD_ARGUMENT);
}

/* What a lookup follows without looking: indices, and the order of lists. */
static void visit_umbrellas(const zt_file *file, uint32_t texture, uint32_t image_count) {
    zt_umbrella_info n;
    REQUIRE(zt_get_umbrellas(file, texture, &n) == ZT_OK);
    REQUIRE(n.level_count >= 1 && n.levels[0].width == n.grid_x && n.levels[0].height == n.grid_y);
    for (uint32_t i = 0; i < n.base_count; i++) {
        const zt_umbrella_base *b = &n.bases[i];
        REQUIRE(b->source < (b->shows_texture ? texture : image_count));
        REQUIRE(b->vertex_count >= 3 && b->first_vertex + b->vertex_count <= n.base_vertex_count);
        REQUIRE(b->first_morph == ZT_NONE || b->first_morph + b->vertex_count <= n.morph_vertex_count);
        REQUIRE(b->first_colour + b->variant_count * (1U + b->vertex_count) <= n.variant_colour_count);
    }
    for (uint32_t i = 0; i < n.umbrella_count; i++) {
        const zt_umbrella *m = &n.umbrellas[i];
        REQUIRE(m->form == ZT_UMBRELLA_COLOURED || m->base < n.base_count);
        REQUIRE(m->first_vertex + m->vertex_count <= n.explicit_vertex_count);
        REQUIRE(m->form == ZT_UMBRELLA_PARAMETRIC || m->vertex_count >= 3);
        REQUIRE(m->vertex_count == 0 || m->first_colour + m->vertex_count < n.explicit_colour_count);
    }
    REQUIRE(n.list_starts[0] == 0 && n.list_starts[n.cell_count] == n.entry_count);
    for (uint32_t l = 0; l < n.level_count; l++) {
        const zt_umbrella_level *level = &n.levels[l];
        REQUIRE(level->first_cell + level->width * level->height <= n.cell_count);
        REQUIRE(level->first_umbrella + level->umbrella_count <= n.umbrella_count);
        uint32_t last = level->first_cell + level->width * level->height;
        for (uint32_t i = n.list_starts[level->first_cell]; i < n.list_starts[last]; i++)
            REQUIRE((n.entries[i] & ZT_UMBRELLA_ENTRY) < level->umbrella_count &&
                    n.entries[i] >> ZT_UMBRELLA_SHIFT < 9);
    }
}

static void visit_textures(const zt_file *file, uint32_t count, uint32_t image_count) {
    zt_texture_info info;
    zt_layer_info layer;
    zt_patch_info patch;
    for (uint32_t i = 0; i < count && i < LOOKED_AT; i++) {
        REQUIRE(zt_get_texture(file, i, &info) == ZT_OK);
        REQUIRE(strlen(info.name) <= 255 && (info.name[0] == 0 || zt_find_texture(file, info.name) == i));
        for (uint32_t k = 0; k < info.layer_count; k++) {
            REQUIRE(zt_get_layer(file, i, k, &layer) == ZT_OK);
            REQUIRE(info.kind == ZT_KIND_UMBRELLA ? layer.image == ZT_NONE : layer.image < image_count);
        }
        if (info.kind == ZT_KIND_UMBRELLA)
            visit_umbrellas(file, i, image_count);
        for (uint32_t p = 0; p < info.patch_count && p < LOOKED_AT; p++) {
            REQUIRE(zt_get_patch(file, i, p, &patch) == ZT_OK);
            REQUIRE(p == 0 ? patch.parent == 0 : patch.parent < p);
            REQUIRE(patch.texture == ZT_NONE || patch.texture < i);
            uint32_t image = zt_get_patch_image(file, i, p, 0);
            REQUIRE(patch.texture == ZT_NONE ? image < image_count : image == ZT_NONE);
        }
        REQUIRE(zt_get_patch(file, i, info.patch_count, &patch) == ZT_BAD_ARGUMENT);
    }
    REQUIRE(zt_get_texture(file, count, &info) == ZT_BAD_ARGUMENT);
}

static void visit_metadata(const zt_file *file, uint64_t size) {
    const char *key, *value, *last = "";
    uint32_t count;
    zt_diag diag;
    zt_result result = zt_load_metadata(file, &count, &diag);
    fuzz_require_diag(&diag, result, size);
    REQUIRE(result == ZT_OK || count == 0);
    for (uint32_t i = 0; i < count; i++) {
        REQUIRE(zt_get_metadata(file, i, &key, &value) == ZT_OK);
        REQUIRE(strcmp(last, key) < 0);
        if (i < LOOKED_AT)
            REQUIRE(zt_find_metadata(file, key) == value);
        last = key;
    }
    REQUIRE(zt_get_metadata(file, count, &key, &value) == ZT_BAD_ARGUMENT);
}

/* ---- extents ---- */

static void require_extents(const zt_file *file, const zt_request *request, uint64_t size) {
    zt_extent extents[MOST_EXTENTS];
    size_t count;
    uint64_t end = 0;
    zt_diag diag;
    zt_result result = zt_query_extents(file, request, extents, MOST_EXTENTS, &count, &diag);
    fuzz_require_diag(&diag, result, size);
    REQUIRE(result == ZT_OK || count == 0);
    for (size_t i = 0; i < count && i < MOST_EXTENTS; i++) {
        REQUIRE(extents[i].size > 0 && extents[i].offset <= size && extents[i].size <= size - extents[i].offset);
        REQUIRE(i == 0 || extents[i].offset > end);
        end = extents[i].offset + extents[i].size;
    }
}

static void query(const zt_file *file, const zt_file_info *info, uint64_t size, fuzz_random *random) {
    zt_image_info image;
    zt_level_info level;
    zt_request request = {.texture = fuzz_below(random, info->texture_count + 1), .patch = ZT_NONE};
    request.min_level = fuzz_below(random, 4);
    request.max_level = request.min_level + fuzz_below(random, 30);
    if (fuzz_below(random, 2))
        request.patch = fuzz_below(random, 4);
    require_extents(file, &request, size);

    zt_region region = {.level = 0};
    request.texture = request.patch = ZT_NONE;
    request.image = fuzz_below(random, info->image_count);
    require_extents(file, &request, size);
    REQUIRE(zt_get_image(file, request.image, &image) == ZT_OK);
    region.level = fuzz_below(random, image.levels);
    region.layer = fuzz_below(random, image.layers);
    REQUIRE(zt_get_level(file, request.image, region.level, &level) == ZT_OK);
    region.x = fuzz_below(random, level.width);
    region.y = fuzz_below(random, level.height);
    region.z = fuzz_below(random, level.depth);
    region.width = 1 + fuzz_below(random, level.width - region.x);
    region.height = 1 + fuzz_below(random, level.height - region.y);
    region.depth = 1 + fuzz_below(random, level.depth - region.z);
    request.region = &region;
    require_extents(file, &request, size);
}

/* ---- the target ---- */

static void visit(const zt_file *file, uint64_t size, fuzz_random *random) {
    zt_file_info info;
    zt_get_file(file, &info);
    REQUIRE(info.file_size == size && info.major == 1);
    visit_chunks(file, info.chunk_count, size);
    visit_images(file, info.image_count, size);
    visit_textures(file, info.texture_count, info.image_count);
    visit_metadata(file, size);
    for (int i = 0; i < 4; i++)
        query(file, &info, size, random);
}

/* Does the validator agree with what opening said? */
static void compare_check(const uint8_t *data, size_t size, const zt_limits *limits, zt_result opened) {
    fuzz_memory memory;
    zt_diag diag;
    zt_check_summary summary;
    fuzz_memory_init(&memory, limits->memory);
    zt_check_options options = {.allocator = &memory.allocator, .limits = limits, .flags = ZT_CHECK_STRUCTURE};
    zt_result result = zt_check_memory(data, size, &options, &diag, &summary);
    fuzz_require_diag(&diag, result, size);
    REQUIRE(memory.live == 0);
    bool clean = result == ZT_OK && summary.errors == 0 && summary.limits == 0;
    REQUIRE(clean == (opened == ZT_OK));
    REQUIRE(!clean || summary.complete);
}

/* Opening what is there of a file; an image's levels may be missing, nothing else differs. */
static void open_best_effort(const uint8_t *data, size_t size, zt_open_options *options, zt_result strict) {
    zt_diag diag;
    zt_file *file;
    options->flags = ZT_OPEN_BEST_EFFORT;
    zt_result result = zt_open_memory(data, size, options, &diag, &file);
    fuzz_require_diag(&diag, result, size);
    REQUIRE(strict != ZT_OK || result == ZT_OK);
    zt_close(file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    uint8_t *copy = fuzz_copy(data, size);
    zt_limits limits = fuzz_limits();
    fuzz_random random = fuzz_random_of(data, size);
    fuzz_memory memory;
    zt_diag diag;
    zt_file *file = NULL;
    memset(&diag, 0xA5, sizeof diag);
    fuzz_memory_init(&memory, limits.memory);
    zt_open_options options = {.allocator = &memory.allocator, .limits = &limits};
    zt_result result = zt_open_memory(copy, size, &options, &diag, &file);
    fuzz_require_diag(&diag, result, size);
    REQUIRE((result == ZT_OK) == (file != NULL));
    if (file)
        visit(file, size, &random);
    zt_close(file);
    open_best_effort(copy, size, &options, result);
    REQUIRE(memory.live == 0);
    compare_check(copy, size, &limits, result);
    free(copy);
    return 0;
}
