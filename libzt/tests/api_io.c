/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A reader whose bytes come from elsewhere. Whichever read fails or must wait, the call says so with the range that it
 * wants, and the same call succeeds once the bytes are there. A decoding call reads nothing but what zt_query_extents
 * promises, which is what a loader over a network relies on. A file whose end is missing gives the levels before the
 * cut.
 */
#include "corpus.h"
#include "test.h"

enum { MOST_READS = 4096, MOST_EXTENTS = 4096 };

typedef struct source {
    blob b;
    zt_result refusal;  /* ZT_AGAIN or ZT_IO */
    uint64_t refuse_at; /* the read with this number, from 1; 0: none */
    bool refuse_on;     /* and those behind it */
    uint64_t reads;
    zt_extent log[MOST_READS];
    zt_extent refused; /* the last one */
} source;

static zt_result read_at(void *user, uint64_t offset, void *dst, size_t size) {
    source *s = user;
    assert(size > 0 && offset <= s->b.size && size <= s->b.size - offset);
    zt_extent extent = {offset, size};
    s->reads++;
    if (s->refuse_at > 0 && (s->reads == s->refuse_at || (s->refuse_on && s->reads > s->refuse_at))) {
        s->refused = extent;
        return s->refusal;
    }
    if (s->reads <= MOST_READS)
        s->log[s->reads - 1] = extent;
    memcpy(dst, s->b.data + offset, size);
    return ZT_OK;
}

static zt_io io_of(source *s) {
    zt_io io = {s, read_at, s->b.size};
    return io;
}

static void check_refused(const source *s, const zt_diag *diag, zt_result result) {
    CHECK(result == s->refusal && diag->result == result && diag->text[0]);
    CHECK(diag->offset == s->refused.offset);
    CHECK(result != ZT_AGAIN || diag->size == s->refused.size);
}

/* ---- opening ---- */

static void test_open(const char *name, zt_result refusal, bool on) {
    static source s;
    memset(&s, 0, sizeof s);
    s.b = blob_read(VALID_FOLDER, name);
    s.refusal = refusal;
    s.refuse_on = on;
    bool done = false;
    for (uint64_t n = 1; !done && n < 1000; n++) {
        zt_io io = io_of(&s);
        zt_diag diag;
        zt_file *file = (zt_file *)&s;
        counting memory;
        counting_init(&memory);
        zt_open_options options = {.allocator = &memory.allocator};
        s.refuse_at = n;
        s.reads = 0;
        zt_result result = zt_open_io(&io, &options, &diag, &file);
        done = result == ZT_OK && s.reads < n;
        if (!done) {
            check_refused(&s, &diag, result);
            CHECK(file == NULL);
        }
        zt_close(file);
        CHECK(memory.live == 0);
    }
    CHECK(done);
    blob_free(s.b);
}

/* ---- calls on an open file: each is made again on the same file until it succeeds ---- */

typedef zt_result call(const zt_file *file, zt_diag *diag);

static zt_result call_levels(const zt_file *file, zt_diag *diag) {
    zt_image_info image;
    zt_level_info info;
    zt_result result = ZT_OK;
    for (uint32_t i = 0; zt_get_image(file, i, &image) == ZT_OK && result == ZT_OK; i++) {
        for (uint32_t k = 0; k < image.levels && result == ZT_OK; k++) {
            CHECK(zt_get_level(file, i, k, &info) == ZT_OK);
            uint8_t *texels = malloc((size_t)info.layer_size);
            result = zt_decode_level(file, i, k, 0, texels, (size_t)info.layer_size, 0, NULL, diag);
            free(texels);
        }
    }
    return result;
}

static zt_result call_tile(const zt_file *file, zt_diag *diag) {
    zt_tile_info tile;
    zt_result result = zt_get_tile(file, 0, 0, 0, &tile, diag);
    if (result != ZT_OK)
        return result;
    uint8_t *bytes = malloc(tile.decoded_size);
    result = zt_decode_tile(file, 0, 0, 0, bytes, tile.decoded_size, diag);
    if (result == ZT_OK)
        result = zt_read_tile(file, 0, 0, 0, bytes, tile.decoded_size, diag);
    free(bytes);
    return result;
}

static zt_result call_metadata(const zt_file *file, zt_diag *diag) {
    uint32_t count;
    zt_result result = zt_load_metadata(file, &count, diag);
    CHECK(result == ZT_OK || count == 0);
    return result;
}

static zt_result call_chunks(const zt_file *file, zt_diag *diag) {
    zt_chunk_info info;
    zt_result result = ZT_OK;
    for (uint32_t i = 0; zt_get_chunk(file, i, &info) == ZT_OK && result == ZT_OK; i++) {
        if (strcmp(info.type, "TEXL") == 0)
            continue;
        uint8_t *bytes = malloc((size_t)info.decoded_size);
        result = zt_read_chunk(file, i, bytes, (size_t)info.decoded_size, diag);
        free(bytes);
    }
    return result;
}

static zt_result call_sample(const zt_file *file, zt_diag *diag) {
    zt_sampler *sampler;
    zt_point points[3] = {{.u = 0.5, .v = 0.5}, {.u = 0.1, .v = 0.9, .du_dx = 0.3, .dv_dy = 0.3}, {.u = -3}};
    float out[12];
    zt_result result = zt_sampler_open(file, 0, NULL, diag, &sampler);
    if (result == ZT_OK)
        result = zt_sample(sampler, points, 3, out, diag);
    zt_sampler_close(sampler);
    return result;
}

/* The read with number n is refused, and with on those behind it. A call may read again what was refused once. */
static void test_call(const char *name, call *what, zt_result refusal, bool on) {
    static source s;
    memset(&s, 0, sizeof s);
    s.b = blob_read(VALID_FOLDER, name);
    s.refusal = refusal;
    s.refuse_on = on;
    zt_io io = io_of(&s);
    zt_diag diag;
    zt_file *file;
    bool done = false;
    for (uint64_t n = 1; !done && n < 10000; n++) {
        counting memory;
        counting_init(&memory);
        zt_open_options options = {.allocator = &memory.allocator};
        s.refuse_at = 0;
        CHECK(zt_open_io(&io, &options, &diag, &file) == ZT_OK);
        s.refuse_at = n;
        s.reads = 0;
        memset(&diag, 0, sizeof diag);
        zt_result result = what(file, &diag);
        done = result == ZT_OK && s.reads < n;
        if (!done && (on || result != ZT_OK))
            check_refused(&s, &diag, result);
        s.refuse_at = 0; /* the bytes are there now */
        CHECK(what(file, &diag) == ZT_OK);
        zt_close(file);
        CHECK(memory.live == 0);
    }
    CHECK(done);
    blob_free(s.b);
}

/* ---- what is read is what was promised ---- */

static bool is_covered(const zt_extent *extents, size_t count, zt_extent read) {
    for (size_t i = 0; i < count; i++) {
        if (read.offset >= extents[i].offset && read.offset + read.size <= extents[i].offset + extents[i].size)
            return true;
    }
    return false;
}

static void check_reads(const source *s, const zt_extent *extents, size_t count) {
    CHECK(s->reads > 0 && s->reads <= MOST_READS);
    for (uint64_t i = 0; i < s->reads && i < MOST_READS; i++)
        CHECK(is_covered(extents, count, s->log[i]));
}

/* With fresh: a file that has read nothing yet; else what the query has loaded need not be read again. */
static void test_region(source *s, uint32_t image, const zt_region *region, size_t size) {
    static zt_extent extents[MOST_EXTENTS];
    zt_io io = io_of(s);
    zt_diag diag;
    zt_file *file = NULL, *fresh = NULL;
    size_t count;
    zt_request request = {.texture = ZT_NONE, .patch = ZT_NONE, .image = image, .region = region};
    s->refuse_at = 0;
    CHECK(zt_open_io(&io, NULL, &diag, &file) == ZT_OK && zt_open_io(&io, NULL, &diag, &fresh) == ZT_OK);
    CHECK(zt_query_extents(file, &request, extents, MOST_EXTENTS, &count, &diag) == ZT_OK);
    CHECK(count > 0 && count <= MOST_EXTENTS);
    uint8_t *texels = malloc(size);
    s->reads = 0;
    CHECK(zt_decode_region(fresh, image, region, texels, size, 0, 0, NULL, &diag) == ZT_OK);
    check_reads(s, extents, count);
    zt_close(fresh);
    zt_close(file);
    free(texels);
}

static void test_level_reads(source *s, uint32_t image, const zt_image_info *im, uint32_t k, uint64_t *state) {
    zt_level_info info;
    zt_io io = io_of(s);
    zt_file *file;
    CHECK(zt_open_io(&io, NULL, NULL, &file) == ZT_OK && zt_get_level(file, image, k, &info) == ZT_OK);
    for (int i = 0; i < 6; i++) {
        zt_region r = {.level = k, .layer = test_below(state, im->layers)};
        r.x = test_below(state, info.blocks_x) * im->block_width;
        r.y = test_below(state, info.blocks_y) * im->block_height;
        r.z = test_below(state, info.depth);
        r.width = (1 + test_below(state, (info.width - r.x + im->block_width - 1) / im->block_width)) * im->block_width;
        r.height = (1 + test_below(state, (info.height - r.y + im->block_height - 1) / im->block_height)) *
                   im->block_height;
        r.width = r.width < info.width - r.x ? r.width : info.width - r.x;
        r.height = r.height < info.height - r.y ? r.height : info.height - r.y;
        r.depth = 1 + test_below(state, info.depth - r.z);
        test_region(s, image, &r, (size_t)info.layer_size);
    }
    zt_close(file);
}

/* All layers of some levels at once. */
static void test_whole_levels(source *s, uint32_t image, const zt_image_info *im, uint32_t first, uint32_t last) {
    static zt_extent extents[MOST_EXTENTS];
    zt_io io = io_of(s);
    zt_diag diag;
    zt_file *file;
    size_t count, again;
    zt_level_info info;
    zt_request request = {.texture = ZT_NONE, .patch = ZT_NONE, .image = image, .min_level = first, .max_level = last};
    CHECK(zt_open_io(&io, NULL, &diag, &file) == ZT_OK);
    s->reads = 0;
    CHECK(zt_query_extents(file, &request, extents, MOST_EXTENTS, &count, &diag) == ZT_OK);
    CHECK(zt_query_extents(file, &request, NULL, 0, &again, &diag) == ZT_OK && again == count);
    CHECK(s->reads == 0); /* whole levels need no reading */
    for (uint32_t k = first; k <= last && k < im->levels; k++) {
        CHECK(zt_get_level(file, image, k, &info) == ZT_OK);
        uint8_t *texels = malloc((size_t)info.layer_size);
        for (uint32_t layer = 0; layer < im->layers && layer < 8; layer++)
            CHECK(zt_decode_level(file, image, k, layer, texels, (size_t)info.layer_size, 0, NULL, &diag) == ZT_OK);
        free(texels);
    }
    check_reads(s, extents, count);
    zt_close(file);
}

static void test_reads(const char *name) {
    static source s;
    uint64_t state = 11;
    zt_image_info im;
    zt_file *file;
    memset(&s, 0, sizeof s);
    s.b = blob_read(VALID_FOLDER, name);
    zt_io io = io_of(&s);
    CHECK(zt_open_io(&io, NULL, NULL, &file) == ZT_OK);
    for (uint32_t i = 0; i < 4 && zt_get_image(file, i, &im) == ZT_OK; i++) {
        for (uint32_t k = 0; k < im.levels; k++) {
            test_level_reads(&s, i, &im, k, &state);
            test_whole_levels(&s, i, &im, k, k + test_below(&state, 3));
        }
    }
    zt_close(file);
    blob_free(s.b);
}

/* A region of a level whose index is not here: the one extent is the index. */
static void test_again_for_index(const char *name) {
    static source s;
    zt_diag diag;
    zt_file *file;
    zt_extent extents[4];
    size_t count;
    zt_level_info info;
    memset(&s, 0, sizeof s);
    s.b = blob_read(VALID_FOLDER, name);
    s.refusal = ZT_AGAIN;
    zt_io io = io_of(&s);
    CHECK(zt_open_io(&io, NULL, &diag, &file) == ZT_OK && zt_get_level(file, 0, 0, &info) == ZT_OK);
    zt_region region = {.width = info.width, .height = info.height, .depth = 1};
    zt_request request = {.texture = ZT_NONE, .patch = ZT_NONE, .region = &region};
    s.reads = 0;
    s.refuse_at = 1;
    CHECK(zt_query_extents(file, &request, extents, 4, &count, &diag) == ZT_AGAIN);
    CHECK(count == 1 && extents[0].offset == info.unit_offset && extents[0].size == 16 * info.tile_count);
    CHECK(diag.result == ZT_AGAIN && diag.offset == extents[0].offset && diag.size == extents[0].size);
    s.refuse_at = 0;
    CHECK(zt_query_extents(file, &request, extents, 4, &count, &diag) == ZT_OK && count >= 1);
    zt_close(file);
    blob_free(s.b);
}

/* ---- a file whose end is missing ---- */

static void test_cut_levels(const zt_file *file, size_t size) {
    zt_image_info im;
    zt_level_info info;
    zt_diag diag;
    for (uint32_t i = 0; zt_get_image(file, i, &im) == ZT_OK; i++) {
        for (uint32_t k = 0; k < im.levels; k++) {
            CHECK(zt_get_level(file, i, k, &info) == ZT_OK);
            bool there = info.unit_offset + info.unit_size <= size;
            CHECK(zt_level_state(file, i, k) == (there ? ZT_OK : ZT_TRUNCATED));
            uint8_t *texels = malloc((size_t)info.layer_size);
            bool all = true;
            for (uint32_t layer = 0; layer < im.layers; layer++) {
                zt_result result = zt_decode_level(file, i, k, layer, texels, (size_t)info.layer_size, 0, NULL, &diag);
                CHECK(result == ZT_OK || (!there && result == ZT_TRUNCATED && diag.rule == 2006));
                all &= result == ZT_OK;
            }
            CHECK(all == there);
            free(texels);
        }
    }
}

static void test_best_effort(const char *name) {
    blob whole = blob_read(VALID_FOLDER, name);
    size_t opened = 0;
    for (size_t size = 0; size <= whole.size; size++) {
        blob cut = blob_prefix(whole, size);
        zt_diag diag;
        zt_file *file;
        zt_open_options options = {.flags = ZT_OPEN_BEST_EFFORT};
        zt_result result = zt_open_memory(cut.data, cut.size, &options, &diag, &file);
        CHECK(result == ZT_OK || result == ZT_TRUNCATED || (size < 10 && result == ZT_NOT_ZTEX));
        CHECK(opened == 0 || result == ZT_OK); /* more bytes never open less */
        if (result == ZT_OK) {
            opened++;
            test_cut_levels(file, size);
        }
        zt_close(file);
        blob_free(cut);
    }
    CHECK(opened > 1);
    blob_free(whole);
}

int main(void) {
    static const char *const names[] = {"first.ztex",      "zip_in_zip.ztex",  "meta_zstd_encoder.ztex",
                                        "tiles_many.ztex", "array_tiled.ztex", "zip_several.ztex"};
    static const char *const read[] = {"first.ztex",
                                       "tiles_many.ztex",
                                       "tiles_edge_16_clipped.ztex",
                                       "array_tiled.ztex",
                                       "volume_tiled.ztex",
                                       "array_of_volumes_tiled.ztex",
                                       "tiles_of_blocks.ztex",
                                       "units_interleaved.ztex",
                                       "levels_full_100x37.ztex",
                                       "tiles_of_astc_12x12.ztex",
                                       "tile_zstd_encoder.ztex"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        for (int again = 0; again < 2; again++) {
            zt_result refusal = again ? ZT_AGAIN : ZT_IO;
            static call *const calls[] = {call_levels, call_tile, call_metadata, call_chunks, call_sample};
            test_open(names[i], refusal, false);
            test_open(names[i], refusal, true);
            for (size_t k = 0; k < sizeof calls / sizeof *calls; k++) {
                test_call(names[i], calls[k], refusal, false);
                test_call(names[i], calls[k], refusal, true);
            }
        }
    }
    for (size_t i = 0; i < sizeof read / sizeof *read; i++)
        test_reads(read[i]);
    test_again_for_index("tiles_many.ztex");
    test_best_effort("first.ztex");
    test_best_effort("tiles_many.ztex");
    test_best_effort("levels_full_100x37.ztex");
    test_best_effort("units_interleaved.ztex");
    test_best_effort("array_tiled.ztex");
    return test_end();
}
