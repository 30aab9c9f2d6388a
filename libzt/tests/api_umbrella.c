/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Umbrellas through the public calls: what is written comes back, whatever the derived fields held before; what breaks
 * a rule is refused by number and harms nothing; a request names the bytes of all pictures; recovery keeps what is
 * intact and follows textures that move; and every call survives any allocation that fails.
 */
#include <zt/zt_check.h>
#include <zt/zt_write.h>

#include "corpus.h"
#include "umbrella_heap.h"
#include "write_sink.h"

enum { ZIPMAP, PICTURE, FIRST, SECOND, TEXTURES };

/* Texture 0 is a zipmap of image 0, texture 1 shows image 1; FIRST has all there is, SECOND no bases. */
static const heap_setup setups[2] = {{.grid_x = 9,
                                      .grid_y = 6,
                                      .level_count = 4,
                                      .base_count = 4,
                                      .umbrella_count = 21,
                                      .repeat_x = true,
                                      .image = 2,
                                      .texture = PICTURE,
                                      .below = ZT_BACKGROUND_TEXTURE},
                                     {.grid_x = 3,
                                      .grid_y = 2,
                                      .level_count = 1,
                                      .umbrella_count = 5,
                                      .repeat_y = true,
                                      .texture = ZT_NONE,
                                      .below = ZT_BACKGROUND_COLOUR}};

static zt_texture_desc desc_of(const heap_setup *t) {
    zt_texture_desc desc = {.wrap_u = t->repeat_x ? ZT_WRAP_REPEAT : ZT_WRAP_MIRROR,
                            .wrap_v = t->repeat_y ? ZT_WRAP_REPEAT : ZT_WRAP_BORDER};
    return desc;
}

static zt_result add_images(zt_writer *w, zt_diag *diag) {
    static uint8_t texels[70 * 50 * 4];
    uint32_t image;
    zt_result result = ZT_OK;
    uint64_t seed = 4;
    for (size_t i = 0; i < sizeof texels; i++)
        texels[i] = (uint8_t)test_below(&seed, 8);
    for (uint32_t i = 0; i < 3 && result == ZT_OK; i++) {
        zt_image_desc desc = {.format = 43,
                              .width = 70,
                              .height = 50,
                              .tile_edge = 16,
                              .alpha_mode = i == 2 ? ZT_ALPHA_STRAIGHT : ZT_ALPHA_NONE};
        result = zt_writer_add_image(w, &desc, diag, &image);
        if (result == ZT_OK)
            result = zt_writer_put_rows(w, image, texels, 50, 0, diag);
    }
    return result;
}

static zt_result add_textures(zt_writer *w, zt_diag *diag) {
    const uint32_t root = 0;
    const zt_patch_desc patch = {.sources = &root, .mask = ZT_NONE, .matrix = {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    const zt_texture_desc zipmap = {.name = "zipmap"}, picture = {.name = "picture", .image = 1};
    zt_result result = zt_writer_add_zipmap(w, &zipmap, &patch, 1, diag, NULL);
    return result == ZT_OK ? zt_writer_add_texture(w, &picture, diag, NULL) : result;
}

static zt_result add_heap(zt_writer *w, const heap *h, const heap_setup *t, zt_diag *diag) {
    zt_texture_desc desc = desc_of(t);
    return zt_writer_add_umbrellas(w, &desc, &h->info, diag, NULL);
}

/* What the writer derives may hold anything. */
static void garble(heap *h) {
    for (uint32_t l = 0; l < h->info.level_count; l++)
        h->levels[l].first_umbrella = h->levels[l].first_cell = h->levels[l].width = h->levels[l].height = 77;
    for (uint32_t i = 0; i < h->info.base_count; i++) {
        h->bases[i].first_vertex = h->bases[i].first_colour = h->bases[i].reserved = 0xABCDEF01;
        h->bases[i].first_morph = h->bases[i].first_morph == ZT_NONE ? ZT_NONE : 0xFFFFFFF0;
    }
    for (uint32_t i = 0; i < h->info.umbrella_count; i++) {
        h->umbrellas[i].first_vertex = h->umbrellas[i].first_colour = 0xABCDEF01;
        h->umbrellas[i].reserved = 0xABCD;
    }
    for (uint32_t i = 0; i < h->info.explicit_colour_count; i++)
        h->explicit_colours[i].reserved = 0xAB;
    for (uint32_t i = 0; i < h->info.variant_colour_count; i++)
        h->variant_colours[i].reserved = 0xAB;
    h->info.explicit_colour_count = h->info.cell_count = h->info.longest_list = 0xABCDEF01;
    for (int k = 0; k < 4; k++)
        h->info.mean[k] = h->info.background[k] > 0 ? h->info.mean[k] : -0.0F;
}

static zt_result fill(zt_writer *w, bool garbled, zt_diag *diag) {
    zt_result result = add_images(w, diag);
    if (result == ZT_OK)
        result = add_textures(w, diag);
    for (uint32_t i = 0; i < 2 && result == ZT_OK; i++) {
        heap *h = heap_make(&setups[i], 10 + i);
        if (garbled)
            garble(h);
        result = add_heap(w, h, &setups[i], diag);
        heap_free(h);
    }
    return result;
}

static memory_sink make(bool garbled) {
    memory_sink bytes;
    zt_sink sink = memory_sink_of(&bytes);
    zt_writer_options options = {.effort = 1};
    zt_writer *w;
    zt_diag diag;
    must(zt_writer_open_sink(&sink, &options, &diag, &w), &diag);
    must(fill(w, garbled, &diag), &diag);
    must(zt_writer_finish(w, &diag), &diag);
    zt_writer_close(w);
    return bytes;
}

static void check_valid(const memory_sink *bytes) {
    zt_check_summary summary;
    zt_diag diag;
    must(zt_check_memory(bytes->data, bytes->size, NULL, &diag, &summary), &diag);
    CHECK(summary.errors == 0 && summary.warnings == 0 && summary.complete);
}

/* ---- what comes back ---- */

/* moved: places of texture PICTURE and of the umbrellas in the file. */
static void check_heap(const zt_file *file, uint32_t which, uint32_t texture, uint32_t picture) {
    heap *h = heap_make(&setups[which], 10 + which);
    zt_umbrella_info info;
    for (uint32_t i = 0; i < h->info.base_count; i++)
        h->bases[i].source = h->bases[i].shows_texture ? picture : h->bases[i].source;
    if (h->info.background_kind == ZT_BACKGROUND_TEXTURE)
        h->info.background_source = picture;
    CHECK(zt_get_umbrellas(file, texture, &info) == ZT_OK);
    CHECK(heap_equal(&info, &h->info));
    heap_free(h);
}

static void check_getters(const zt_file *file) {
    zt_umbrella_info info;
    zt_texture_info texture;
    zt_layer_info layer;
    zt_silmap_info silmap;
    CHECK(zt_get_texture(file, FIRST, &texture) == ZT_OK && texture.kind == ZT_KIND_UMBRELLA);
    CHECK(texture.layer_count == 1 && texture.patch_count == 0);
    CHECK(zt_get_layer(file, FIRST, 0, &layer) == ZT_OK && layer.image == ZT_NONE);
    CHECK(zt_get_silmap(file, FIRST, &silmap) == ZT_BAD_ARGUMENT);
    CHECK(zt_get_umbrellas(file, PICTURE, &info) == ZT_BAD_ARGUMENT && info.levels == NULL);
    CHECK(zt_get_umbrellas(file, TEXTURES, &info) == ZT_BAD_ARGUMENT);
    CHECK(zt_get_umbrellas(NULL, FIRST, &info) == ZT_BAD_ARGUMENT);
    CHECK(zt_get_umbrellas(file, FIRST, NULL) == ZT_BAD_ARGUMENT);
}

static void check_back(void) {
    memory_sink plain = make(false), garbled = make(true);
    zt_file *file = memory_sink_open(&plain);
    check_valid(&plain);
    check_heap(file, 0, FIRST, PICTURE);
    check_heap(file, 1, SECOND, PICTURE);
    check_getters(file);
    zt_close(file);
    CHECK(plain.size == garbled.size && memcmp(plain.data, garbled.data, plain.size) == 0);
    free(plain.data);
    free(garbled.data);
}

/* ---- extents ---- */

/* FIRST shows image 2, and image 1 through a texture; image 0 is nothing to it. */
static void check_extents(void) {
    memory_sink bytes = make(false);
    zt_file *file = memory_sink_open(&bytes);
    zt_request request = {.texture = FIRST, .patch = ZT_NONE, .max_level = 30};
    zt_extent extents[64];
    size_t count;
    zt_diag diag;
    must(zt_query_extents(file, &request, extents, 64, &count, &diag), &diag);
    for (uint32_t image = 0; image < 3; image++) {
        zt_level_info level;
        CHECK(zt_get_level(file, image, 0, &level) == ZT_OK);
        CHECK(covers(extents, count, level.unit_offset, level.unit_size) == (image != 0));
    }
    request.texture = SECOND;
    CHECK(zt_query_extents(file, &request, extents, 64, &count, &diag) == ZT_OK && count == 0);
    request.patch = 0;
    CHECK(zt_query_extents(file, &request, extents, 64, &count, &diag) == ZT_BAD_ARGUMENT);
    zt_close(file);
    free(bytes.data);
}

/* ---- what is refused ---- */

typedef void spoil(heap *h, zt_texture_desc *desc);

static void wide_grid(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->info.grid_x = 8193;
}

static void many_levels(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->info.level_count = 5;
}

static void two_layers(heap *h, zt_texture_desc *desc) {
    static const zt_layer_desc layers[2] = {{ZT_SEMANTIC_BASE_COLOUR, 0}, {ZT_SEMANTIC_NORMAL, 0}};
    (void)h;
    desc->layers = layers;
    desc->layer_count = 2;
}

static void unknown_mode(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->info.colour_mode = (zt_umbrella_colour_mode)256;
}

static void unknown_background(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->info.background_kind = (zt_background_kind)3;
}

static void no_height(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->info.prism_height = NAN;
}

static void late_taper(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->info.taper_start = h->info.taper_end;
}

static void more_umbrellas(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->levels[0].umbrella_count++;
}

static void more_vertices(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->bases[1].vertex_count++;
}

static void fewer_entries(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->info.entry_count--;
}

static void fine_level(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->levels[3].bits = 17;
}

static void later_texture(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->bases[1].source = FIRST;
}

static void unknown_kind(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->bases[1].shows_texture = 2;
}

static void no_image(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->bases[0].source = 3;
}

static void no_aspect(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->bases[0].aspect = 0;
}

static void outer_centre(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->bases[2].centre.y = 0;
}

static void folded_morph(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->morph_vertices[0].x = 0;
}

static void base_form(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->umbrellas[0].form = 3;
}

static void mirrored_twice(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->umbrellas[3].mirrored = 2;
}

static void unknown_base(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->umbrellas[0].base = 4;
}

static void two_vertices(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->umbrellas[2].vertex_count = 2;
}

static void far_vertex(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->explicit_vertices[1].y = INT32_MIN;
}

static void turned_over(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->explicit_vertices[0].x *= -1;
    h->explicit_vertices[1].y *= -1;
}

static void outside(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->umbrellas[1].x = 9 * 65536;
}

static void other_wrap(heap *h, zt_texture_desc *desc) {
    (void)h;
    desc->wrap_v = ZT_WRAP_REPEAT; /* centres above the grid are none then */
    h->umbrellas[0].y = -1;
}

static void too_high(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->umbrellas[0].lift = 65535;
}

static void no_repeat(heap *h, zt_texture_desc *desc) {
    (void)h;
    desc->wrap_u = ZT_WRAP_CLAMP; /* its lists have shifts */
}

static void descending(heap *h, zt_texture_desc *desc) {
    uint32_t cell = 0;
    (void)desc;
    while (h->list_starts[cell + 1] - h->list_starts[cell] < 2)
        cell++;
    uint32_t *e = h->entries + h->list_starts[cell], swap = e[0];
    e[0] = e[1];
    e[1] = swap;
}

static void starts_go_back(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->list_starts[1] = UINT32_MAX;
}

static void starts_late(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->list_starts[0] = 1;
}

static void no_levels(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->info.levels = NULL;
}

static void no_entries(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->info.entries = NULL;
}

static void no_colours(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->info.explicit_colours = NULL;
}

static void endless(heap *h, zt_texture_desc *desc) {
    (void)desc;
    h->info.entry_count = 1 << 30;
}

/* rule 0: an argument that is no umbrellas at all. */
static const struct {
    uint32_t rule;
    spoil *spoil;
} refusals[] = {
    {8301, wide_grid},
    {8301, many_levels},
    {8301, two_layers},
    {8302, unknown_mode},
    {8302, unknown_background},
    {8303, no_height},
    {8303, late_taper},
    {8304, more_umbrellas},
    {8304, more_vertices},
    {8304, fewer_entries},
    {8304, fine_level},
    {8305, later_texture},
    {8305, unknown_kind},
    {8305, no_image},
    {8306, no_aspect},
    {8307, outer_centre},
    {8308, folded_morph},
    {8309, base_form},
    {8309, mirrored_twice},
    {8310, unknown_base},
    {8311, two_vertices},
    {8312, far_vertex},
    {8312, turned_over},
    {8313, outside},
    {8313, other_wrap},
    {8314, too_high},
    {8315, no_repeat},
    {8315, descending},
    {0, starts_go_back},
    {0, starts_late},
    {0, no_levels},
    {0, no_entries},
    {0, no_colours},
    {0, endless},
};

static void refuse(zt_writer *w, size_t row) {
    heap *h = heap_make(&setups[0], 10);
    zt_texture_desc desc = desc_of(&setups[0]);
    uint32_t index = 7;
    zt_diag diag;
    refusals[row].spoil(h, &desc);
    CHECK(zt_writer_add_umbrellas(w, &desc, &h->info, &diag, &index) == ZT_BAD_ARGUMENT);
    CHECK(index == 0 && diag.rule == refusals[row].rule && diag.text[0]);
    if (diag.rule != refusals[row].rule)
        fprintf(stderr, "refusal %zu: rule %u: %s\n", row, diag.rule, diag.text);
    heap_free(h);
}

static void check_refusals(void) {
    memory_sink bytes;
    zt_sink sink = memory_sink_of(&bytes);
    zt_writer *w;
    zt_diag diag;
    heap *h = heap_make(&setups[0], 10);
    zt_texture_desc desc = desc_of(&setups[0]);
    must(zt_writer_open_sink(&sink, NULL, &diag, &w), &diag);
    must(add_images(w, &diag), &diag);
    must(add_textures(w, &diag), &diag);
    for (size_t i = 0; i < sizeof refusals / sizeof *refusals; i++)
        refuse(w, i);
    CHECK(zt_writer_add_umbrellas(w, &desc, NULL, &diag, NULL) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_add_umbrellas(w, NULL, &h->info, &diag, NULL) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_add_umbrellas(NULL, &desc, &h->info, &diag, NULL) == ZT_BAD_ARGUMENT);
    /* A refusal harms nothing: the writer goes on. */
    must(add_heap(w, h, &setups[0], &diag), &diag);
    must(zt_writer_finish(w, &diag), &diag);
    zt_writer_close(w);
    check_valid(&bytes);
    zt_file *file = memory_sink_open(&bytes);
    check_heap(file, 0, FIRST, PICTURE);
    zt_close(file);
    heap_free(h);
    free(bytes.data);
}

/* ---- recovery ---- */

static zt_result read_memory(void *user, uint64_t offset, void *dst, size_t size) {
    const memory_sink *bytes = user;
    memcpy(dst, bytes->data + offset, size);
    return ZT_OK;
}

static memory_sink recover(memory_sink *damaged, zt_recover_report *report) {
    memory_sink out;
    zt_sink sink = memory_sink_of(&out);
    zt_io io = {damaged, read_memory, damaged->size};
    zt_writer *w;
    zt_diag diag;
    must(zt_writer_open_sink(&sink, NULL, &diag, &w), &diag);
    must(zt_recover(&io, w, NULL, &diag, report), &diag);
    must(zt_writer_finish(w, &diag), &diag);
    zt_writer_close(w);
    check_valid(&out);
    return out;
}

static void damage_first(memory_sink *bytes, const char *type) {
    zt_file *file = memory_sink_open(bytes);
    zt_chunk_info chunk;
    uint32_t i = 0;
    while (zt_get_chunk(file, i, &chunk) == ZT_OK && strcmp(chunk.type, type) != 0)
        i++;
    bytes->data[chunk.offset + 64 + chunk.stored_size / 2] ^= 0x55;
    zt_close(file);
}

static void check_recovery(void) {
    zt_recover_report report;
    memory_sink whole = make(false), out = recover(&whole, &report);
    zt_file *file = memory_sink_open(&out);
    CHECK(report.complete && report.textures_kept == TEXTURES);
    check_heap(file, 0, FIRST, PICTURE);
    check_heap(file, 1, SECOND, PICTURE);
    zt_close(file);
    free(out.data);

    /* Without their payload umbrellas are lost; the others keep theirs. */
    memory_sink damaged = make(false);
    damage_first(&damaged, "UMBR");
    out = recover(&damaged, &report);
    file = memory_sink_open(&out);
    CHECK(report.textures_lost == 1 && report.textures_kept == 3 && report.textures_rebuilt == 1);
    check_heap(file, 1, FIRST, PICTURE);
    zt_close(file);
    free(out.data);
    free(damaged.data);

    /* Without the zipmap in front all textures move up, and what shows them follows. */
    damaged = make(false);
    damage_first(&damaged, "ZPMP");
    out = recover(&damaged, &report);
    file = memory_sink_open(&out);
    CHECK(report.textures_lost == 1 && report.textures_kept == 3);
    check_heap(file, 0, FIRST - 1, PICTURE - 1);
    check_heap(file, 1, SECOND - 1, PICTURE - 1);
    zt_close(file);
    free(out.data);
    free(damaged.data);

    /* The directory is gone: the chunks are found by their heads. */
    whole.data[70] ^= 1;
    out = recover(&whole, &report);
    file = memory_sink_open(&out);
    CHECK(!report.directory_intact && report.textures_kept == TEXTURES);
    check_heap(file, 0, FIRST, PICTURE);
    check_heap(file, 1, SECOND, PICTURE);
    zt_close(file);
    free(out.data);
    free(whole.data);
}

/* A lost tile of a base's picture covers nothing: made-up leaves would hide what lies beneath. */
static void check_lost_tile(void) {
    memory_sink bytes = make(false);
    zt_file *file = memory_sink_open(&bytes);
    zt_recover_report report;
    zt_tile_info tile;
    zt_diag diag;
    uint8_t texels[16 * 16 * 4], sum = 0;
    must(zt_get_tile(file, 2, 0, 0, &tile, &diag), &diag);
    bytes.data[tile.offset + tile.stored_size / 2] ^= 0x55;
    zt_close(file);
    memory_sink out = recover(&bytes, &report);
    file = memory_sink_open(&out);
    CHECK(report.tiles_replaced == 1 && report.textures_kept == TEXTURES);
    must(zt_decode_tile(file, 2, 0, 0, texels, sizeof texels, &diag), &diag);
    for (size_t i = 0; i < sizeof texels; i++)
        sum |= texels[i];
    CHECK(sum == 0);
    zt_close(file);
    free(out.data);
    free(bytes.data);
}

/* ---- memory ---- */

/* Every allocation of opening and of writing fails once. */
static void check_memory(void) {
    memory_sink bytes = make(false);
    bool done = false;
    for (uint64_t n = 1; !done; n++) {
        counting memory;
        zt_diag diag = {0};
        zt_file *file;
        counting_init(&memory);
        memory.fail_at = n;
        zt_open_options options = {.allocator = &memory.allocator};
        zt_result result = zt_open_memory(bytes.data, bytes.size, &options, &diag, &file);
        done = memory.calls < n;
        CHECK(result == (done ? ZT_OK : ZT_NO_MEMORY) && (file != NULL) == done);
        CHECK(done || (diag.result == result && diag.text[0]));
        zt_close(file);
        CHECK(memory.live == 0);
    }
    free(bytes.data);
}

static zt_result write_with(counting *memory, memory_sink *bytes) {
    zt_sink sink = memory_sink_of(bytes);
    zt_writer_options options = {.allocator = &memory->allocator, .effort = 1};
    zt_writer *w;
    zt_diag diag;
    zt_result result = zt_writer_open_sink(&sink, &options, &diag, &w);
    heap *h = heap_make(&setups[1], 3);
    if (result == ZT_OK)
        result = add_images(w, &diag);
    if (result == ZT_OK)
        result = add_heap(w, h, &setups[1], &diag);
    if (result == ZT_OK)
        result = zt_writer_finish(w, &diag);
    CHECK(result == ZT_OK || (diag.result == result && diag.text[0]));
    heap_free(h);
    zt_writer_close(w);
    return result;
}

static void check_writer_memory(void) {
    memory_sink whole, bytes;
    counting memory;
    counting_init(&memory);
    CHECK(write_with(&memory, &whole) == ZT_OK);
    uint64_t calls = memory.calls;
    for (uint64_t n = 1; n <= calls; n++) {
        counting_init(&memory);
        memory.fail_at = n;
        zt_result result = write_with(&memory, &bytes);
        /* The spool may do without memory; then the file is the same. */
        bool same = bytes.size == whole.size && memcmp(bytes.data, whole.data, whole.size) == 0;
        CHECK(result == ZT_NO_MEMORY || (result == ZT_OK && same));
        CHECK(memory.live == 0);
        free(bytes.data);
    }
    free(whole.data);
}

/* Cells count against the limit of memory, for readers and writers. */
static void check_limit(void) {
    heap_setup large = setups[1];
    large.grid_x = large.grid_y = 1024;
    large.umbrella_count = 0;
    heap *h = heap_make(&large, 10);
    zt_limits limits = {.memory = 1 << 20};
    zt_open_options options = {.limits = &limits};
    memory_sink bytes;
    zt_sink sink = memory_sink_of(&bytes);
    zt_writer *w;
    zt_file *file;
    zt_diag diag;
    must(zt_writer_open_sink(&sink, NULL, &diag, &w), &diag);
    must(add_images(w, &diag), &diag);
    must(add_heap(w, h, &large, &diag), &diag);
    must(zt_writer_finish(w, &diag), &diag);
    zt_writer_close(w);
    CHECK(bytes.size < 1 << 20);
    CHECK(zt_open_memory(bytes.data, bytes.size, &options, &diag, &file) == ZT_LIMIT && file == NULL);
    CHECK(diag.rule == 1010);
    limits.memory = 1 << 23;
    CHECK(zt_open_memory(bytes.data, bytes.size, &options, &diag, &file) == ZT_OK);
    zt_close(file);
    free(bytes.data);
    heap_free(h);
}

int main(void) {
    check_back();
    check_extents();
    check_refusals();
    check_recovery();
    check_lost_tile();
    check_memory();
    check_writer_memory();
    check_limit();
    return test_end();
}
