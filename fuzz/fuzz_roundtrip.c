/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Writing: a valid file that is decoded and written again, once from rows of texels and once from stored tiles, is
 * valid and has the same texels, and the same calls give the same bytes. Then the input is read as the description of
 * a new file: the writer refuses it with a reason, or what it writes is valid.
 */
#include <stdbool.h>

#include <zt/zt_write.h>

#include "support.h"

enum { MOST_BYTES = 1 << 20, MOST_IMAGES = 32 };

/* ---- a file in memory ---- */

typedef struct output {
    uint8_t *data;
    size_t size, capacity;
} output;

static zt_result collect(void *user, const void *data, size_t size) {
    output *out = user;
    if (size > out->capacity - out->size) {
        out->capacity = 2 * (out->size + size);
        out->data = realloc(out->data, out->capacity);
        REQUIRE(out->data != NULL);
    }
    memcpy(out->data + out->size, data, size);
    out->size += size;
    return ZT_OK;
}

static zt_writer *begin(output *out, fuzz_memory *memory, uint32_t flags) {
    zt_limits limits = {.memory = memory->ceiling};
    zt_sink sink = {out, collect};
    zt_writer_options options = {
        .allocator = &memory->allocator, .limits = &limits, .effort = 1, .raw_only = flags & 1};
    zt_writer *writer;
    zt_diag diag;
    memset(out, 0, sizeof *out);
    zt_result result = zt_writer_open_sink(&sink, &options, &diag, &writer);
    fuzz_require_diag(&diag, result, 0);
    REQUIRE(result == ZT_OK && writer != NULL);
    return writer;
}

/* What a writer may answer: success, or a refusal that says why. */
static bool accepted(zt_result result, const zt_diag *diag) {
    fuzz_require_diag(diag, result, 0);
    REQUIRE(result == ZT_OK || result == ZT_BAD_ARGUMENT || result == ZT_LIMIT || result == ZT_UNSUPPORTED);
    return result == ZT_OK;
}

/* The coverage at the border of patches (R8112) is the caller's business: the writer does not look at texels. */
static int on_finding(void *user, const zt_finding *finding) {
    uint64_t *borders = user;
    *borders += finding->rule == 8112;
    return 0;
}

static void require_valid(const output *out, const zt_limits *limits) {
    zt_diag diag;
    zt_check_summary summary;
    uint64_t borders = 0;
    zt_check_options options = {.limits = limits, .user = &borders, .finding = on_finding};
    REQUIRE(zt_check_memory(out->data, out->size, &options, &diag, &summary) == ZT_OK);
    REQUIRE(summary.errors == borders && summary.limits == 0 && summary.complete);
}

/* ---- copying a file ---- */

/* All levels fit into what one input may cost; a layer of a tail costs the whole tail. */
static bool is_small(const zt_file *file, const zt_file_info *info) {
    zt_image_info im;
    zt_level_info level;
    uint64_t sum = 0;
    if (info->image_count > MOST_IMAGES)
        return false;
    for (uint32_t i = 0; zt_get_image(file, i, &im) == ZT_OK; i++) {
        for (uint32_t k = 0; zt_get_level(file, i, k, &level) == ZT_OK; k++)
            sum += level.level_size * (k < im.tail_level ? 1 : im.layers) + 64 * level.tile_count;
    }
    return sum <= MOST_BYTES;
}

static void put_rows(zt_writer *writer, const zt_file *file, uint32_t image, uint32_t level, uint32_t layers) {
    zt_level_info info;
    zt_diag diag;
    REQUIRE(zt_get_level(file, image, level, &info) == ZT_OK);
    size_t size = (size_t)info.layer_size;
    uint32_t rows = info.blocks_y * info.depth;
    uint8_t *texels = fuzz_malloc(size);
    for (uint32_t layer = 0; layer < layers; layer++) {
        REQUIRE(zt_decode_level(file, image, level, layer, texels, size, 0, NULL, &diag) == ZT_OK);
        uint32_t half = rows / 2; /* in two pieces */
        REQUIRE(half == 0 || zt_writer_put_level_rows(writer, image, level, texels, half, 0, &diag) == ZT_OK);
        zt_result result = zt_writer_put_level_rows(writer, image, level, texels + half * info.row_size, rows - half, 0,
                                                    &diag);
        fuzz_require_diag(&diag, result, 0);
        REQUIRE(result == ZT_OK);
    }
    free(texels);
}

static void put_tiles(zt_writer *writer, const zt_file *file, uint32_t image, uint32_t level) {
    zt_level_info info;
    zt_tile_info tile;
    zt_diag diag;
    REQUIRE(zt_get_level(file, image, level, &info) == ZT_OK);
    for (uint64_t t = info.tile_count; t-- > 0;) { /* in any order */
        REQUIRE(zt_get_tile(file, image, level, t, &tile, &diag) == ZT_OK);
        uint8_t *stored = fuzz_malloc(tile.stored_size);
        REQUIRE(zt_read_tile(file, image, level, t, stored, tile.stored_size, &diag) == ZT_OK);
        zt_result result = zt_writer_put_stored_tile(writer, image, level, t, tile.codec, tile.hash, stored,
                                                     tile.stored_size, &diag);
        fuzz_require_diag(&diag, result, 0);
        REQUIRE(result == ZT_OK);
        free(stored);
    }
}

static void copy_images(zt_writer *writer, const zt_file *file, uint32_t count, bool tiles) {
    zt_image_info im;
    zt_diag diag;
    uint32_t index;
    for (uint32_t i = 0; i < count; i++) {
        REQUIRE(zt_get_image(file, i, &im) == ZT_OK);
        zt_image_desc desc;
        zt_describe_image(&im, &desc);
        zt_result result = zt_writer_add_image(writer, &desc, &diag, &index);
        fuzz_require_diag(&diag, result, 0);
        REQUIRE(result == ZT_OK && index == i);
        for (uint32_t k = 0; k < im.levels; k++) {
            if (!tiles)
                put_rows(writer, file, i, k, im.layers);
            else if (k <= im.tail_level)
                put_tiles(writer, file, i, k);
        }
    }
}

static void copy_zipmap(zt_writer *writer, const zt_file *file, uint32_t texture, const zt_texture_desc *desc,
                        uint32_t patch_count) {
    zt_diag diag;
    zt_patch_desc *patches = fuzz_malloc(patch_count * sizeof *patches);
    uint32_t *sources = fuzz_malloc((size_t)patch_count * desc->layer_count * sizeof *sources);
    for (uint32_t p = 0; p < patch_count; p++) {
        zt_patch_info info;
        uint32_t *own = sources + (size_t)p * desc->layer_count;
        REQUIRE(zt_get_patch(file, texture, p, &info) == ZT_OK);
        for (uint32_t k = 0; k < desc->layer_count; k++)
            own[k] = info.texture != ZT_NONE ? info.texture : zt_get_patch_image(file, texture, p, k);
        zt_patch_desc patch = {
            .parent = info.parent, .shows_texture = info.texture != ZT_NONE, .sources = own, .mask = info.mask};
        memcpy(patch.matrix, info.matrix, sizeof patch.matrix);
        patches[p] = patch;
    }
    zt_result result = zt_writer_add_zipmap(writer, desc, patches, patch_count, &diag, NULL);
    fuzz_require_diag(&diag, result, 0);
    REQUIRE(result == ZT_OK);
    free(patches);
    free(sources);
}

static void copy_silmap(zt_writer *writer, const zt_file *file, uint32_t texture, const zt_texture_desc *desc) {
    uint32_t samples[32], minified[32];
    zt_silmap_info info;
    zt_diag diag;
    REQUIRE(zt_get_silmap(file, texture, &info) == ZT_OK);
    for (uint32_t k = 0; k < desc->layer_count; k++) {
        samples[k] = desc->layers[k].image;
        minified[k] = zt_get_silmap_minified(file, texture, k);
    }
    zt_silmap_desc silmap = {info.cells_x, info.cells_y, info.cell_layers, info.filter, info.cells, samples, minified};
    zt_result result = zt_writer_add_silmap(writer, desc, &silmap, &diag, NULL);
    fuzz_require_diag(&diag, result, 0);
    REQUIRE(result == ZT_OK);
}

static void copy_umbrellas(zt_writer *writer, const zt_file *file, uint32_t texture, const zt_texture_desc *desc) {
    zt_umbrella_info info;
    zt_diag diag;
    REQUIRE(zt_get_umbrellas(file, texture, &info) == ZT_OK);
    zt_result result = zt_writer_add_umbrellas(writer, desc, &info, &diag, NULL);
    fuzz_require_diag(&diag, result, 0);
    REQUIRE(result == ZT_OK);
}

static void copy_textures(zt_writer *writer, const zt_file *file, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        zt_texture_info info;
        zt_layer_desc layers[32];
        zt_diag diag;
        REQUIRE(zt_get_texture(file, i, &info) == ZT_OK && info.layer_count <= 32);
        for (uint32_t k = 0; k < info.layer_count; k++) {
            zt_layer_info layer;
            REQUIRE(zt_get_layer(file, i, k, &layer) == ZT_OK);
            layers[k].semantic = layer.semantic;
            layers[k].image = layer.image;
        }
        zt_texture_desc desc = {info.name, info.wrap_u, info.wrap_v, info.wrap_w, layers, info.layer_count, 0};
        if (info.kind == ZT_KIND_ZIPMAP) {
            copy_zipmap(writer, file, i, &desc, info.patch_count);
            continue;
        }
        if (info.kind == ZT_KIND_SILMAP) {
            copy_silmap(writer, file, i, &desc);
            continue;
        }
        if (info.kind == ZT_KIND_UMBRELLA) {
            copy_umbrellas(writer, file, i, &desc);
            continue;
        }
        zt_result result = zt_writer_add_texture(writer, &desc, &diag, NULL);
        fuzz_require_diag(&diag, result, 0);
        REQUIRE(result == ZT_OK);
    }
}

static output rewrite(const zt_file *file, bool tiles) {
    zt_file_info info;
    fuzz_memory memory;
    output out;
    zt_diag diag;
    uint32_t dropped;
    zt_get_file(file, &info);
    fuzz_memory_init(&memory, UINT64_C(1) << 30);
    zt_writer *writer = begin(&out, &memory, 0);
    copy_images(writer, file, info.image_count, tiles);
    copy_textures(writer, file, info.texture_count);
    zt_result result = zt_writer_copy_rest(writer, file, &diag, &dropped);
    fuzz_require_diag(&diag, result, info.file_size);
    REQUIRE(result == ZT_OK);
    result = zt_writer_finish(writer, &diag);
    fuzz_require_diag(&diag, result, 0);
    REQUIRE(result == ZT_OK);
    zt_writer_close(writer);
    REQUIRE(memory.live == 0);
    return out;
}

static void require_same_texels(const zt_file *a, const zt_file *b, uint32_t image_count) {
    zt_level_info level, other;
    zt_image_info im;
    zt_diag diag;
    for (uint32_t i = 0; i < image_count; i++) {
        REQUIRE(zt_get_image(a, i, &im) == ZT_OK);
        for (uint32_t k = 0; k < im.levels; k++) {
            REQUIRE(zt_get_level(a, i, k, &level) == ZT_OK && zt_get_level(b, i, k, &other) == ZT_OK);
            REQUIRE(level.layer_size == other.layer_size);
            size_t size = (size_t)level.layer_size;
            uint8_t *texels = fuzz_malloc(size), *again = fuzz_malloc(size);
            for (uint32_t layer = 0; layer < im.layers && layer < 64; layer++) {
                REQUIRE(zt_decode_level(a, i, k, layer, texels, size, 0, NULL, &diag) == ZT_OK);
                REQUIRE(zt_decode_level(b, i, k, layer, again, size, 0, NULL, &diag) == ZT_OK);
                REQUIRE(memcmp(texels, again, size) == 0);
            }
            free(texels);
            free(again);
        }
    }
}

static void require_same_array(const void *a, const void *b, uint32_t a_count, uint32_t b_count, size_t size) {
    REQUIRE(a_count == b_count && (a_count == 0 || memcmp(a, b, a_count * size) == 0));
}

/* Structs of 4-byte words: no byte of them is padding. */
static void require_same_umbrellas(const zt_file *a, const zt_file *b, uint32_t texture) {
    zt_umbrella_info x, y;
    if (zt_get_umbrellas(a, texture, &x) != ZT_OK)
        return;
    REQUIRE(zt_get_umbrellas(b, texture, &y) == ZT_OK);
    require_same_array(x.levels, y.levels, x.level_count, y.level_count, sizeof *x.levels);
    require_same_array(x.bases, y.bases, x.base_count, y.base_count, sizeof *x.bases);
    require_same_array(x.umbrellas, y.umbrellas, x.umbrella_count, y.umbrella_count, sizeof *x.umbrellas);
    require_same_array(x.explicit_vertices, y.explicit_vertices, x.explicit_vertex_count, y.explicit_vertex_count,
                       sizeof *x.explicit_vertices);
    require_same_array(x.explicit_colours, y.explicit_colours, x.explicit_colour_count, y.explicit_colour_count,
                       sizeof *x.explicit_colours);
    require_same_array(x.list_starts, y.list_starts, x.cell_count + 1, y.cell_count + 1, sizeof *x.list_starts);
    require_same_array(x.entries, y.entries, x.entry_count, y.entry_count, sizeof *x.entries);
}

static void require_equal(const zt_file *file, const output *out, const zt_limits *limits) {
    zt_file *again;
    zt_file_info info, written;
    zt_diag diag;
    zt_open_options options = {.limits = limits};
    require_valid(out, limits);
    REQUIRE(zt_open_memory(out->data, out->size, &options, &diag, &again) == ZT_OK);
    zt_get_file(file, &info);
    zt_get_file(again, &written);
    REQUIRE(info.image_count == written.image_count && info.texture_count == written.texture_count);
    require_same_texels(file, again, info.image_count);
    for (uint32_t i = 0; i < info.texture_count; i++)
        require_same_umbrellas(file, again, i);
    zt_close(again);
}

static void copy_valid(const uint8_t *data, size_t size, const zt_limits *limits) {
    zt_check_summary summary;
    zt_file_info info;
    zt_file *file = NULL;
    zt_open_options open = {.limits = limits};
    zt_check_options check = {.limits = limits};
    if (zt_check_memory(data, size, &check, NULL, &summary) != ZT_OK || summary.errors > 0 || summary.limits > 0)
        return;
    REQUIRE(zt_open_memory(data, size, &open, NULL, &file) == ZT_OK);
    zt_get_file(file, &info);
    if (is_small(file, &info)) {
        for (int tiles = 0; tiles < 2; tiles++) {
            output first = rewrite(file, tiles), second = rewrite(file, tiles);
            REQUIRE(first.size == second.size && memcmp(first.data, second.data, first.size) == 0);
            require_equal(file, &first, limits);
            free(first.data);
            free(second.data);
        }
    }
    zt_close(file);
}

/* ---- a file from bytes ---- */

typedef struct input {
    const uint8_t *data;
    size_t size, at;
    fuzz_random random; /* goes on where the bytes end */
} input;

static uint32_t take8(input *in) {
    return in->at < in->size ? in->data[in->at++] : (uint32_t)(fuzz_next(&in->random) >> 56);
}

/* True once in so many times: for what is mostly refused. */
static bool seldom(input *in) {
    return take8(in) % 32 == 31;
}

/* Mostly a small number from 1 on, sometimes any. */
static uint32_t take_number(input *in) {
    uint32_t kind = take8(in), value = take8(in);
    if (kind < 240)
        return 1 + value % 40;
    value |= take8(in) << 8;
    return kind < 253 ? value : value | take8(in) << 16 | take8(in) << 24;
}

static void take_strange(input *in, zt_image_desc *desc) {
    desc->primaries = (uint8_t)take8(in);
    desc->transfer = (uint8_t)take8(in);
    desc->block_width = (uint8_t)take8(in);
    desc->block_height = (uint8_t)take8(in);
    desc->block_bytes = (uint8_t)take8(in);
    desc->alpha_mode = (zt_alpha)(take8(in) % 5);
    desc->layer_kind = (zt_layer_kind)(take8(in) % 5);
    desc->tile_edge = take_number(in);
    desc->format = take_number(in);
}

static zt_image_desc take_desc(input *in) {
    const zt_format_info *format = zt_get_format(take8(in) % 100);
    zt_image_desc desc = {.format = format ? format->format : 43};
    uint32_t flags = take8(in);
    format = zt_find_format(desc.format);
    desc.width = take_number(in);
    desc.height = take_number(in);
    desc.depth = (flags & 7) == 7 ? take_number(in) : 0;
    desc.layers = (flags & 24) == 24 ? take_number(in) : 0;
    desc.levels = flags & 32 ? 1 : 0;
    desc.tile_edge = UINT32_C(16) << take8(in) % 6;
    desc.alpha_mode = format && format->has_alpha ? (zt_alpha)(take8(in) % 3) : ZT_ALPHA_NONE;
    desc.layer_kind = seldom(in) ? ZT_LAYERS_CUBE : take8(in) % 2 ? ZT_LAYERS_FRAMES : ZT_LAYERS_ARRAY;
    desc.given_levels = !format || !format->is_plain || flags >> 6 & 1;
    flags = take8(in);
    desc.mip_filter = flags & 3;
    desc.wrap_u = flags >> 2 & 3;
    desc.wrap_v = flags >> 4 & 3;
    desc.wrap_w = flags >> 6 & 3;
    desc.is_normal = take8(in) % 4 == 0;
    desc.zero_border = take8(in) % 2 == 0 && desc.alpha_mode != ZT_ALPHA_NONE;
    if (seldom(in))
        take_strange(in, &desc);
    return desc;
}

/* Bytes of all levels of a description, or UINT64_MAX: too many for one input. */
static uint64_t cost_of(const zt_image_desc *desc) {
    uint64_t depth = desc->depth ? desc->depth : 1, layers = desc->layers ? desc->layers : 1;
    if (desc->width > 4096 || desc->height > 4096 || depth > 256 || layers > 256)
        return UINT64_MAX;
    return (uint64_t)desc->width * desc->height * depth * layers * 16;
}

static zt_result fill_level(zt_writer *writer, input *in, uint32_t image, const zt_image_desc *desc, uint32_t level) {
    const zt_format_info *format = zt_find_format(desc->format);
    uint32_t bw = format ? format->block_width : desc->block_width,
             bytes = format ? format->block_bytes : desc->block_bytes;
    uint32_t bh = format ? format->block_height : desc->block_height;
    uint32_t width = desc->width >> level ? desc->width >> level : 1;
    uint32_t height = desc->height >> level ? desc->height >> level : 1;
    uint32_t depth = desc->depth >> level ? desc->depth >> level : 1, layers = desc->layers ? desc->layers : 1;
    size_t row = (size_t)((width + bw - 1) / bw) * bytes;
    uint8_t *texels = fuzz_malloc(row);
    zt_result result = ZT_OK;
    zt_diag diag;
    for (uint32_t n = (height + bh - 1) / bh * depth * layers; n > 0 && result == ZT_OK; n--) {
        for (size_t i = 0; i < row; i++)
            texels[i] = (uint8_t)take8(in);
        result = desc->given_levels ? zt_writer_put_level_rows(writer, image, level, texels, 1, 0, &diag)
                                    : zt_writer_put_rows(writer, image, texels, 1, 0, &diag);
        accepted(result, &diag);
    }
    free(texels);
    return result;
}

/* True when the image is full; *count goes up when the writer knows it. */
static bool add_image(zt_writer *writer, input *in, uint32_t *count, uint64_t *cost) {
    uint32_t image;
    zt_image_desc desc = take_desc(in);
    zt_diag diag;
    uint64_t bytes = cost_of(&desc);
    if (bytes > MOST_BYTES - *cost)
        return true;
    if (!accepted(zt_writer_add_image(writer, &desc, &diag, &image), &diag))
        return true; /* refused without a trace */
    REQUIRE(image == (*count)++);
    *cost += bytes;
    uint32_t levels = desc.given_levels ? desc.levels : 1, edge = desc.width > desc.height ? desc.width : desc.height;
    edge = edge > desc.depth ? edge : desc.depth;
    for (uint32_t n = edge; desc.given_levels && desc.levels == 0 && n > 0; n >>= 1)
        levels++;
    for (uint32_t k = 0; k < levels; k++) {
        if (fill_level(writer, in, image, &desc, k) != ZT_OK)
            return false;
    }
    return true;
}

static void take_text(input *in, char *text, size_t size) {
    size_t length = take8(in) % size;
    for (size_t i = 0; i < length; i++)
        text[i] = (char)(seldom(in) ? take8(in) : 'a' + take8(in) % 26);
    text[length] = 0;
}

/* An image that is there, or seldom one that is not. */
static uint32_t take_image(input *in, uint32_t count) {
    return take8(in) % (count + seldom(in));
}

static void add_zipmap(zt_writer *writer, input *in, const zt_texture_desc *desc, uint32_t image_count) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    uint32_t sources[3][2];
    zt_patch_desc patches[3] = {{.mask = ZT_NONE}};
    zt_diag diag;
    for (uint32_t p = 0; p < 3; p++) {
        memcpy(patches[p].matrix, identity, sizeof identity);
        sources[p][0] = take_image(in, image_count);
        sources[p][1] = take_image(in, image_count);
        patches[p].sources = sources[p];
        patches[p].shows_texture = p > 0 && take8(in) % 4 == 3;
        patches[p].mask = p > 0 && take8(in) % 3 == 2 ? take_image(in, image_count) : ZT_NONE;
        patches[p].parent = p > 0 ? take8(in) % (p + seldom(in)) : 0;
        for (int i = 0; i < 9 && p > 0; i++)
            patches[p].matrix[i] += i < 6 || seldom(in) ? ((double)take8(in) - 128) / 256 : 0;
    }
    accepted(zt_writer_add_zipmap(writer, desc, patches, 1 + take8(in) % 3, &diag, NULL), &diag);
}

/* An image of a silmap, filled; ZT_NONE: the writer refuses it. */
static uint32_t add_silmap_image(zt_writer *writer, input *in, zt_image_desc *desc) {
    uint32_t image;
    zt_diag diag;
    if (!accepted(zt_writer_add_image(writer, desc, &diag, &image), &diag))
        return ZT_NONE;
    return fill_level(writer, in, image, desc, 0) == ZT_OK ? image : ZT_NONE;
}

static void add_silmap(zt_writer *writer, input *in, const zt_texture_desc *desc) {
    static const uint32_t formats[] = {9, 23, 43, 97};
    enum { EDGE = 16 };
    uint8_t cells[EDGE * EDGE];
    uint32_t samples[2], minified[2];
    zt_diag diag;
    zt_silmap_desc silmap = {.cells_x = 1 + take8(in) % EDGE,
                             .cells_y = 1 + take8(in) % EDGE,
                             .filter = (zt_silmap_filter)(take8(in) % (3 + seldom(in))),
                             .cells = cells,
                             .samples = samples,
                             .minified = minified};
    zt_image_desc image = {.format = formats[take8(in) % 4],
                           .width = silmap.cells_x + (desc->wrap_u != ZT_WRAP_REPEAT) + seldom(in),
                           .height = silmap.cells_y + (desc->wrap_v != ZT_WRAP_REPEAT),
                           .levels = 1};
    bool leaving = seldom(in);
    for (uint32_t i = 0; i < silmap.cells_x * silmap.cells_y; i++) {
        cells[i] = (uint8_t)take8(in);
        if (desc->wrap_u != ZT_WRAP_REPEAT && i % silmap.cells_x == 0 && !leaving)
            cells[i] &= (uint8_t)~ZT_SILMAP_WEST;
        if (desc->wrap_v != ZT_WRAP_REPEAT && i < silmap.cells_x && !leaving)
            cells[i] &= (uint8_t)~ZT_SILMAP_NORTH;
    }
    samples[0] = samples[1] = add_silmap_image(writer, in, &image);
    image.width = silmap.cells_x;
    image.height = silmap.cells_y;
    image.levels = 0;
    minified[0] = minified[1] = take8(in) % 2 ? add_silmap_image(writer, in, &image) : ZT_NONE;
    accepted(zt_writer_add_silmap(writer, desc, &silmap, &diag, NULL), &diag);
}

enum { MOST_UMBRELLAS = 6, CORNERS = 4, GRID = 4 };

/* The arrays of umbrellas that come from bytes. */
typedef struct scatter {
    zt_umbrella_level level;
    zt_umbrella_base base;
    zt_umbrella_texel corners[CORNERS];
    zt_umbrella_colour variants[2 * (1 + CORNERS)];
    zt_umbrella umbrellas[MOST_UMBRELLAS];
    zt_umbrella_offset offsets[MOST_UMBRELLAS * CORNERS];
    zt_umbrella_colour colours[MOST_UMBRELLAS * (1 + CORNERS)];
    uint32_t starts[GRID * GRID + 1], entries[GRID * GRID * MOST_UMBRELLAS];
} scatter;

static void take_base(input *in, scatter *s, uint32_t image_count) {
    static const zt_umbrella_texel corners[CORNERS] = {{60000, 30000}, {30000, 60000}, {900, 30000}, {30000, 900}};
    zt_umbrella_base base = {.source = take_image(in, image_count),
                             .aspect = 1 + take8(in) * 300,
                             .first_morph = ZT_NONE,
                             .vertex_count = CORNERS,
                             .variant_count = (uint8_t)(take8(in) % 2 * 2),
                             .centre = {(uint16_t)(20000 + take8(in) * 100), (uint16_t)(20000 + take8(in) * 60)},
                             .height = (uint16_t)take8(in),
                             .ellipsoid = (uint8_t)(1 + take8(in) % 2)};
    memcpy(s->corners, corners, sizeof corners);
    if (seldom(in))
        s->corners[take8(in) % CORNERS].x = (uint16_t)(take8(in) << 8);
    s->base = base;
}

static void take_umbrella(input *in, scatter *s, zt_umbrella_info *info) {
    uint32_t form = take8(in) % (3 + seldom(in));
    bool has_base = form != ZT_UMBRELLA_COLOURED, corners = form != ZT_UMBRELLA_PARAMETRIC;
    zt_umbrella m = {.x = (int32_t)(take8(in) * 256),
                     .y = (int32_t)(take8(in) * 256),
                     .a = corners ? 0 : 1 + (int32_t)take8(in),
                     .vertex_count = corners ? CORNERS : 0,
                     .form = (uint8_t)form,
                     .strength = has_base ? (uint8_t)take8(in) : 0,
                     .ellipsoid = has_base ? ZT_ELLIPSOID_OF_BASE : ZT_ELLIPSOID_FLAT,
                     .lift = (uint16_t)(take8(in) * 255)};
    for (uint32_t k = 0; k < CORNERS && corners; k++) {
        int32_t reach = (int32_t)(1 + take8(in)) * (seldom(in) ? -1 : 1);
        zt_umbrella_offset v = {k == 0 ? reach : k == 2 ? -reach : 0, k == 1 ? reach : k == 3 ? -reach : 0};
        s->offsets[info->explicit_vertex_count++] = v;
    }
    s->umbrellas[info->umbrella_count++] = m;
}

static void take_lists(input *in, scatter *s, zt_umbrella_info *info) {
    for (uint32_t cell = 0; cell < info->grid_x * info->grid_y; cell++) {
        for (uint32_t i = 0; i < info->umbrella_count; i++) {
            if (take8(in) % 2)
                s->entries[info->entry_count++] = (i + seldom(in)) | UINT32_C(4) << ZT_UMBRELLA_SHIFT;
        }
        s->starts[cell + 1] = info->entry_count;
    }
}

static void add_umbrellas(zt_writer *writer, input *in, const zt_texture_desc *desc, uint32_t image_count) {
    scatter s = {.level = {.bits = take8(in) % 17}};
    zt_diag diag;
    zt_umbrella_info info = {.grid_x = 1 + take8(in) % GRID,
                             .grid_y = 1 + take8(in) % GRID,
                             .level_count = 1,
                             .base_count = 1,
                             .base_vertex_count = CORNERS,
                             .colour_mode = (zt_umbrella_colour_mode)(take8(in) % (2 + seldom(in))),
                             .background_source = ZT_NONE,
                             .mean = {(float)take8(in)},
                             .taper_end = 0.125F,
                             .levels = &s.level,
                             .bases = &s.base,
                             .base_vertices = s.corners,
                             .variant_colours = s.variants,
                             .umbrellas = s.umbrellas,
                             .explicit_vertices = s.offsets,
                             .explicit_colours = s.colours,
                             .list_starts = s.starts,
                             .entries = s.entries};
    take_base(in, &s, image_count);
    info.variant_colour_count = s.base.variant_count * (1U + CORNERS);
    for (uint32_t n = take8(in) % MOST_UMBRELLAS; n > 0; n--)
        take_umbrella(in, &s, &info);
    s.level.umbrella_count = info.umbrella_count;
    take_lists(in, &s, &info);
    accepted(zt_writer_add_umbrellas(writer, desc, &info, &diag, NULL), &diag);
}

static void add_textures(zt_writer *writer, input *in, uint32_t image_count) {
    zt_diag diag;
    char name[40], value[40];
    for (uint32_t n = 1 + take8(in) % 3; n > 0; n--) {
        zt_layer_desc layers[2] = {{take8(in), take_image(in, image_count)}, {take8(in), take_image(in, image_count)}};
        take_text(in, name, sizeof name);
        zt_texture_desc desc = {.name = name, .layers = layers, .layer_count = 1 + take8(in) % 8 / 7};
        desc.wrap_u = (zt_wrap)(take8(in) % (4 + seldom(in)));
        desc.wrap_v = (zt_wrap)(take8(in) % 4);
        uint32_t kind = take8(in) % 5;
        if (kind == 3)
            add_silmap(writer, in, &desc);
        else if (kind == 4)
            add_umbrellas(writer, in, &desc, image_count);
        else if (kind % 2)
            accepted(zt_writer_add_texture(writer, &desc, &diag, NULL), &diag);
        else
            add_zipmap(writer, in, &desc, image_count);
    }
    while (take8(in) % 4 == 3) {
        take_text(in, name, sizeof name);
        take_text(in, value, sizeof value);
        accepted(zt_writer_set_metadata(writer, name, value, &diag), &diag);
    }
}

/* Files differ in few places, so of a .ztex file it is a hash that describes the new one. */
static void write_new(const uint8_t *data, size_t size, const zt_limits *limits) {
    input in = {data, size > 0 && data[0] == 0xAB ? 0 : size, 0, fuzz_random_of(data, size)};
    fuzz_memory memory;
    output out;
    zt_diag diag;
    uint64_t cost = 0;
    uint32_t count = 0; /* images that the writer took */
    bool full = true;
    fuzz_memory_init(&memory, UINT64_C(1) << 28);
    zt_writer *writer = begin(&out, &memory, take8(&in));
    for (uint32_t n = 1 + take8(&in) % 3; n > 0; n--)
        full &= add_image(writer, &in, &count, &cost);
    if (count > 0)
        add_textures(writer, &in, count);
    bool finished = accepted(zt_writer_finish(writer, &diag), &diag);
    REQUIRE(full || !finished);
    if (finished)
        require_valid(&out, limits);
    zt_writer_close(writer);
    REQUIRE(memory.live == 0);
    free(out.data);
}

/* ---- the target ---- */

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    zt_limits limits = fuzz_limits();
    uint8_t *copy = fuzz_copy(data, size);
    copy_valid(copy, size, &limits);
    write_new(copy, size, &limits);
    free(copy);
    return 0;
}
