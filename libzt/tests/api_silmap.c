/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Silmaps through the public calls: what is written comes back, cells that say nothing in one form only; what breaks a
 * rule is refused by number; a request names the bytes of all its images; recovery keeps what is intact; and every call
 * survives any allocation that fails.
 */
#include <zt/zt_check.h>

#include "corpus.h"
#include "silmap_scene.h"

static const scene_setup setup = {.format = RGBA8_SRGB,
                                  .alpha = ZT_ALPHA_STRAIGHT,
                                  .cells_x = 33,
                                  .cells_y = 20,
                                  .frames = 3,
                                  .cell_layers = 3,
                                  .wrap_u = ZT_WRAP_REPEAT,
                                  .wrap_v = ZT_WRAP_CLAMP,
                                  .filter = ZT_SILMAP_SEN2004,
                                  .layer_count = 2,
                                  .minified = true};

/* ---- what comes back ---- */

static void check_silmap(const scene *s, const zt_file *file) {
    zt_silmap_info info;
    zt_layer_info layer;
    zt_texture_info texture;
    size_t count = (size_t)s->setup.cells_x * s->setup.cells_y * s->setup.cell_layers;
    CHECK(zt_get_texture(file, 0, &texture) == ZT_OK && texture.kind == ZT_KIND_SILMAP && texture.patch_count == 0);
    CHECK(zt_get_silmap(file, 0, &info) == ZT_OK);
    CHECK(info.cells_x == s->setup.cells_x && info.cells_y == s->setup.cells_y);
    CHECK(info.cell_layers == s->setup.cell_layers && info.filter == s->setup.filter);
    CHECK(info.cells && memcmp(info.cells, s->cells, count) == 0);
    for (uint32_t l = 0; l < s->setup.layer_count; l++) {
        CHECK(zt_get_layer(file, 0, l, &layer) == ZT_OK);
        CHECK(layer.image == s->images[l] && layer.semantic == scene_layers[l].semantic);
        CHECK(zt_get_silmap_minified(file, 0, l) == s->minified[l]);
    }
}

static void check_getters(const zt_file *file) {
    zt_silmap_info info;
    CHECK(zt_get_silmap_minified(file, 0, 2) == ZT_NONE);
    CHECK(zt_get_silmap_minified(file, 1, 0) == ZT_NONE);
    CHECK(zt_get_silmap_minified(file, 99, 0) == ZT_NONE);
    CHECK(zt_get_silmap_minified(NULL, 0, 0) == ZT_NONE);
    CHECK(zt_get_silmap(file, 1, &info) == ZT_BAD_ARGUMENT && info.cells == NULL);
    CHECK(zt_get_silmap(file, 99, &info) == ZT_BAD_ARGUMENT);
    CHECK(zt_get_silmap(NULL, 0, &info) == ZT_BAD_ARGUMENT);
    CHECK(zt_get_silmap(file, 0, NULL) == ZT_BAD_ARGUMENT);
    CHECK(zt_get_patch_image(file, 0, 0, 0) == ZT_NONE);
}

static void check_valid(const scene *s) {
    zt_check_summary summary;
    zt_diag diag;
    must(zt_check_memory(s->bytes.data, s->bytes.size, NULL, &diag, &summary), &diag);
    CHECK(summary.errors == 0 && summary.warnings == 0 && summary.complete);
}

static void check_back(void) {
    scene s = scene_make(&setup, 3);
    scene again = scene_make(&setup, 3);
    zt_file *file = scene_open(&s);
    check_silmap(&s, file);
    check_getters(file);
    check_valid(&s);
    CHECK(s.bytes.size == again.bytes.size && memcmp(s.bytes.data, again.bytes.data, s.bytes.size) == 0);
    zt_close(file);
    scene_free(&again);
    scene_free(&s);
}

/* ---- extents ---- */

static void check_extents(void) {
    scene_setup large = setup; /* with levels outside of the mip tail */
    large.cells_x = 150;
    large.frames = large.cell_layers = 1;
    scene s = scene_make(&large, 4);
    zt_file *file = scene_open(&s);
    zt_request request = {.texture = 0, .patch = ZT_NONE, .max_level = 30};
    zt_extent extents[64];
    size_t count;
    zt_diag diag;
    must(zt_query_extents(file, &request, extents, 64, &count, &diag), &diag);
    for (uint32_t l = 0; l < setup.layer_count; l++) {
        const uint32_t images[2] = {s.images[l], s.minified[l]};
        for (int i = 0; i < 2; i++) {
            zt_image_info image;
            zt_level_info level;
            CHECK(zt_get_image(file, images[i], &image) == ZT_OK);
            for (uint32_t k = 0; k < image.levels; k++) {
                CHECK(zt_get_level(file, images[i], k, &level) == ZT_OK);
                CHECK(covers(extents, count, level.unit_offset, level.unit_size));
            }
        }
    }
    request.patch = 0;
    CHECK(zt_query_extents(file, &request, extents, 64, &count, &diag) == ZT_BAD_ARGUMENT);
    zt_close(file);
    scene_free(&s);
}

/* ---- what is refused ---- */

typedef struct refusal {
    uint32_t rule;
    void (*spoil)(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells);
} refusal;

static uint32_t spoiled_images[SCENE_LAYERS];

static void no_cells(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells) {
    (void)texture;
    (void)cells;
    silmap->cells_x = 0;
}

static void too_many_cells(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells) {
    (void)texture;
    (void)cells;
    silmap->cells_x = silmap->cells_y = 1u << 20;
}

static void unknown_filter(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells) {
    (void)texture;
    (void)cells;
    silmap->filter = (zt_silmap_filter)3;
}

static void huge_filter(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells) {
    (void)texture;
    (void)cells;
    silmap->filter = (zt_silmap_filter)0x40000000;
}

static void no_image(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells) {
    (void)texture;
    (void)cells;
    spoiled_images[1] = 77;
    silmap->samples = spoiled_images;
}

static void other_wrap(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells) {
    (void)silmap;
    (void)cells;
    texture->wrap_u = ZT_WRAP_MIRROR;
}

static void two_layers(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells) {
    (void)texture;
    (void)cells;
    silmap->cell_layers = 2;
}

static void samples_as_minified(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells) {
    (void)texture;
    (void)cells;
    silmap->minified = silmap->samples;
}

static void leaving_arm(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells) {
    (void)texture;
    (void)silmap;
    cells[5] |= ZT_SILMAP_NORTH;
}

static void many_layers(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells) {
    (void)silmap;
    (void)cells;
    texture->layer_count = 33;
}

static void one_layer(zt_texture_desc *texture, zt_silmap_desc *silmap, uint8_t *cells) {
    (void)cells;
    (void)texture;
    silmap->cell_layers = 0; /* 1 */
}

static const refusal refusals[] = {
    {8201, no_cells},    {8201, too_many_cells}, {8202, unknown_filter}, {8202, huge_filter},
    {8203, no_image},    {8203, other_wrap},     {8204, two_layers},     {8205, samples_as_minified},
    {8206, leaving_arm}, {6105, many_layers},    {0, one_layer},
};

static void check_refusals(void) {
    static zt_layer_desc layers[33];
    memory_sink bytes;
    zt_sink sink = memory_sink_of(&bytes);
    scene s = {.setup = setup};
    zt_writer *w;
    zt_diag diag;
    uint32_t index;
    uint64_t seed = 6;
    must(zt_writer_open_sink(&sink, NULL, &diag, &w), &diag);
    scene_fill(&s, w, &seed);
    size_t count = (size_t)setup.cells_x * setup.cells_y * setup.cell_layers;
    uint8_t *cells = malloc(count);
    for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++) {
        zt_texture_desc texture = scene_texture(&s, layers);
        zt_silmap_desc silmap = scene_silmap(&s);
        memcpy(cells, s.cells, count);
        memcpy(spoiled_images, s.images, sizeof spoiled_images);
        silmap.cells = cells;
        refusals[i].spoil(&texture, &silmap, cells);
        index = 7;
        zt_result result = zt_writer_add_silmap(w, &texture, &silmap, &diag, &index);
        CHECK(result == (refusals[i].rule ? ZT_BAD_ARGUMENT : ZT_OK) && diag.rule == refusals[i].rule);
        CHECK(!refusals[i].rule || index == 0);
        if (diag.rule != refusals[i].rule)
            fprintf(stderr, "refusal %zu: rule %u: %s\n", i, diag.rule, diag.text);
    }
    zt_texture_desc texture = scene_texture(&s, layers);
    zt_silmap_desc silmap = scene_silmap(&s), empty = silmap;
    CHECK(zt_writer_add_silmap(w, &texture, NULL, &diag, NULL) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_add_silmap(w, NULL, &silmap, &diag, NULL) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_add_silmap(NULL, &texture, &silmap, &diag, NULL) == ZT_BAD_ARGUMENT);
    empty.cells = NULL;
    CHECK(zt_writer_add_silmap(w, &texture, &empty, &diag, NULL) == ZT_BAD_ARGUMENT);
    /* A refusal harms nothing: the writer goes on. */
    must(zt_writer_finish(w, &diag), &diag);
    zt_writer_close(w);
    s.bytes = bytes;
    check_valid(&s);
    free(cells);
    scene_free(&s);
}

/* ---- recovery ---- */

static zt_result read_memory(void *user, uint64_t offset, void *dst, size_t size) {
    const memory_sink *bytes = user;
    memcpy(dst, bytes->data + offset, size);
    return ZT_OK;
}

static scene recover(scene *damaged, zt_recover_report *report) {
    scene out = *damaged;
    zt_sink sink = memory_sink_of(&out.bytes);
    zt_io io = {&damaged->bytes, read_memory, damaged->bytes.size};
    zt_writer *w;
    zt_diag diag;
    must(zt_writer_open_sink(&sink, NULL, &diag, &w), &diag);
    must(zt_recover(&io, w, NULL, &diag, report), &diag);
    must(zt_writer_finish(w, &diag), &diag);
    zt_writer_close(w);
    return out;
}

static void damage_chunk(scene *s, const char *type) {
    zt_file *file = scene_open(s);
    zt_chunk_info chunk;
    for (uint32_t i = 0; zt_get_chunk(file, i, &chunk) == ZT_OK; i++) {
        if (strcmp(chunk.type, type) == 0)
            s->bytes.data[chunk.offset + 64 + chunk.stored_size / 2] ^= 0x55;
    }
    zt_close(file);
}

static void check_recovery(void) {
    scene s = scene_make(&setup, 8);
    zt_recover_report report;
    zt_texture_info texture;
    scene out = recover(&s, &report);
    zt_file *file = scene_open(&out);
    CHECK(report.complete && report.textures_kept == 3);
    check_silmap(&s, file);
    zt_close(file);
    free(out.bytes.data);

    /* Without its cells a silmap is lost; the pictures that it had get textures of their own. */
    damage_chunk(&s, "SLMP");
    out = recover(&s, &report);
    file = scene_open(&out);
    CHECK(!report.complete && report.textures_lost == 1 && report.textures_kept == 2 && report.textures_rebuilt == 2);
    for (uint32_t i = 0; zt_get_texture(file, i, &texture) == ZT_OK; i++)
        CHECK(texture.kind == ZT_KIND_IMAGE);
    zt_close(file);
    free(out.bytes.data);

    /* The directory is gone: the chunks are found by their heads. */
    scene whole = scene_make(&setup, 8);
    whole.bytes.data[70] ^= 1;
    out = recover(&whole, &report);
    file = scene_open(&out);
    CHECK(!report.directory_intact && report.textures_kept == 3 && report.textures_lost == 0);
    check_silmap(&whole, file);
    zt_close(file);
    free(out.bytes.data);
    scene_free(&whole);
    scene_free(&s);
}

/* ---- memory ---- */

static zt_result use(const scene *s, const zt_allocator *allocator, zt_diag *diag) {
    zt_open_options options = {.allocator = allocator};
    zt_sampler_options layer = {.layer = 1};
    zt_point points[2] = {{.u = 0.3, .v = 0.6}, {.u = 0.7, .v = 0.2, .du_dx = 0.02, .dv_dy = 0.02, .array_layer = 1}};
    float out[8];
    zt_file *file;
    zt_sampler *sampler = NULL;
    zt_result result = zt_open_memory(s->bytes.data, s->bytes.size, &options, diag, &file);
    CHECK((result == ZT_OK) == (file != NULL));
    if (result == ZT_OK)
        result = zt_sampler_open(file, 0, &layer, diag, &sampler);
    if (result == ZT_OK)
        result = zt_sample(sampler, points, 2, out, diag);
    zt_sampler_close(sampler);
    zt_close(file);
    return result;
}

static void check_memory(void) {
    scene s = scene_make(&setup, 9);
    for (uint64_t n = 1;; n++) {
        counting memory;
        zt_diag diag = {0};
        counting_init(&memory);
        memory.fail_at = n;
        zt_result result = use(&s, &memory.allocator, &diag);
        CHECK(memory.live == 0);
        if (memory.calls < n) {
            CHECK(result == ZT_OK && n > 10);
            break;
        }
        CHECK(result == ZT_NO_MEMORY && diag.result == result && diag.text[0]);
    }
    scene_free(&s);
}

/* Cells count against the limit of memory. */
static void check_limit(void) {
    scene_setup large = setup;
    large.cells_x = 1024;
    large.cells_y = 1024;
    large.frames = large.cell_layers = 1;
    large.format = R8;
    large.alpha = ZT_ALPHA_NONE;
    large.layer_count = 1;
    large.minified = false;
    scene s = scene_make(&large, 10);
    zt_limits limits = {.memory = 1 << 20};
    zt_open_options options = {.limits = &limits};
    zt_file *file;
    zt_diag diag;
    CHECK(zt_open_memory(s.bytes.data, s.bytes.size, &options, &diag, &file) == ZT_LIMIT && file == NULL);
    limits.memory = 1 << 24;
    CHECK(zt_open_memory(s.bytes.data, s.bytes.size, &options, &diag, &file) == ZT_OK);
    zt_close(file);
    scene_free(&s);
}

int main(void) {
    check_back();
    check_extents();
    check_refusals();
    check_recovery();
    check_memory();
    check_limit();
    return test_end();
}
