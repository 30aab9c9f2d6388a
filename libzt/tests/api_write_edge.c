/* SPDX-License-Identifier: Apache-2.0 */
/* The tile edge that libzt chooses at the highest effort: level 0 is no larger than with any of the edges it tries; all
 * levels hold what they hold with the usual edge; threads and the pieces in which rows come change no byte; and an edge
 * that the caller names, given levels, lower efforts, large levels and tight limits keep the usual one. Without memory
 * at any point it fails and leaves nothing behind. */
#include "test.h"
#include "write_sink.h"
#include "zt/zt_check.h"

enum { WIDTH = 520, HEIGHT = 150, LAYERS = 2, BYTES = WIDTH * HEIGHT * LAYERS * 4 };

/* Rows of noise that come again after 50 rows: a wide tile says so once; or slopes. */
static void paint(uint8_t *texels, int repeats) {
    uint64_t seed = 11;
    for (uint32_t i = 0; i < WIDTH * HEIGHT * LAYERS; i++)
        for (uint32_t c = 0; c < 4; c++) {
            uint32_t x = i % WIDTH, y = i / WIDTH;
            texels[4 * i + c] = (uint8_t)(x + 2 * y + c);
            if (repeats && y % HEIGHT >= 50)
                texels[4 * i + c] = texels[4 * (i - 50 * WIDTH) + c];
            else if (repeats)
                texels[4 * i + c] = (uint8_t)(test_random(&seed) >> 40);
        }
}

static memory_sink write_it(const zt_writer_options *options, const zt_image_desc *desc, const uint8_t *texels,
                            uint32_t piece) {
    memory_sink s;
    zt_sink sink = memory_sink_of(&s);
    zt_writer *w;
    zt_diag diag = {0};
    uint32_t image;
    uint32_t rows = desc->height * (desc->layers ? desc->layers : 1), width = desc->width;
    CHECK(zt_writer_open_sink(&sink, options, NULL, &w) == ZT_OK);
    CHECK(zt_writer_add_image(w, desc, &diag, &image) == ZT_OK);
    for (uint32_t y = 0; y < rows; y += piece) {
        uint32_t n = rows - y < piece ? rows - y : piece;
        CHECK(zt_writer_put_rows(w, image, texels + (size_t)y * width * 4, n, 0, &diag) == ZT_OK);
    }
    CHECK(zt_writer_put_rows(w, image, texels, 1, 0, NULL) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_add_texture(w, &(zt_texture_desc){.image = image}, NULL, NULL) == ZT_OK);
    CHECK(zt_writer_finish(w, &diag) == ZT_OK);
    zt_writer_close(w);
    return s;
}

static uint32_t edge_of(const memory_sink *s) {
    zt_file *file = NULL;
    zt_image_info info = {0};
    CHECK(zt_open_memory(s->data, s->size, NULL, NULL, &file) == ZT_OK && zt_get_image(file, 0, &info) == ZT_OK);
    zt_close(file);
    return info.tile_edge;
}

/* Bytes of the tiles and their records in level 0. */
static uint64_t level_size(const memory_sink *s) {
    zt_file *file = NULL;
    zt_tile_info tile;
    uint64_t size = 0;
    CHECK(zt_open_memory(s->data, s->size, NULL, NULL, &file) == ZT_OK);
    for (uint64_t i = 0; zt_get_tile(file, 0, 0, i, &tile, NULL) == ZT_OK; i++)
        size += tile.stored_size + 16;
    zt_close(file);
    return size;
}

/* All levels and layers of both files hold the same. */
static void same_texels(const memory_sink *a, const memory_sink *b) {
    static uint8_t x[BYTES], y[BYTES];
    zt_file *first = NULL, *second = NULL;
    zt_image_info info = {0};
    CHECK(zt_open_memory(a->data, a->size, NULL, NULL, &first) == ZT_OK);
    CHECK(zt_open_memory(b->data, b->size, NULL, NULL, &second) == ZT_OK);
    CHECK(zt_get_image(first, 0, &info) == ZT_OK && info.levels > 1);
    for (uint32_t level = 0; level < info.levels; level++)
        for (uint32_t layer = 0; layer < info.layers; layer++) {
            zt_level_info l;
            CHECK(zt_get_level(first, 0, level, &l) == ZT_OK);
            CHECK(zt_decode_level(first, 0, level, layer, x, sizeof x, 0, NULL, NULL) == ZT_OK);
            CHECK(zt_decode_level(second, 0, level, layer, y, sizeof y, 0, NULL, NULL) == ZT_OK);
            CHECK(memcmp(x, y, (size_t)l.layer_size) == 0);
        }
    zt_close(first);
    zt_close(second);
}

static void check_choice(const uint8_t *texels, zt_image_desc desc) {
    static const uint32_t tried[] = {256, 512, 1024};
    zt_writer_options options = {.effort = 9};
    zt_check_summary summary;
    memory_sink chosen = write_it(&options, &desc, texels, 1000);
    CHECK(zt_check_memory(chosen.data, chosen.size, NULL, NULL, &summary) == ZT_OK && summary.errors == 0);
    uint64_t least = UINT64_MAX;
    uint32_t best = 0;
    for (uint32_t i = 0; i < 3; i++) {
        desc.tile_edge = tried[i];
        memory_sink s = write_it(&options, &desc, texels, 17);
        best = level_size(&s) < least ? tried[i] : best;
        least = level_size(&s) < least ? level_size(&s) : least;
        same_texels(&chosen, &s);
        free(s.data);
    }
    CHECK(level_size(&chosen) == least && edge_of(&chosen) == best);
    desc.tile_edge = best;
    memory_sink again = write_it(&options, &desc, texels, 17);
    CHECK(again.size == chosen.size && memcmp(again.data, chosen.data, again.size) == 0);
    free(again.data);
    free(chosen.data);
}

static void check_threads(const uint8_t *texels, const zt_image_desc *desc) {
    zt_writer_options options = {.effort = 9};
    memory_sink one = write_it(&options, desc, texels, 1);
    zt_threads *pool;
    CHECK(zt_threads_open(8, &pool) == ZT_OK);
    zt_parallel parallel = zt_threads_parallel(pool);
    options.parallel = &parallel;
    memory_sink many = write_it(&options, desc, texels, 801);
    CHECK(many.size == one.size && memcmp(many.data, one.data, one.size) == 0);
    free(many.data);
    zt_threads_close(pool);
    free(one.data);
}

static void check_usual(const char *what, zt_writer_options options, const zt_image_desc *desc, const uint8_t *texels,
                        uint32_t expected) {
    memory_sink s = write_it(&options, desc, texels, 64);
    uint32_t edge = edge_of(&s);
    CHECK(edge == expected);
    if (edge != expected)
        fprintf(stderr, "%s: edge %u\n", what, (unsigned)edge);
    free(s.data);
}

typedef struct failing {
    long left, held; /* allocations until one fails; that have not been freed */
} failing;

static void *failing_alloc(void *user, size_t size) {
    failing *f = user;
    if (f->left-- == 0)
        return NULL;
    f->held++;
    return malloc(size);
}

static void failing_free(void *user, void *block, size_t size) {
    failing *f = user;
    (void)size;
    f->held -= block != NULL;
    free(block);
}

static zt_result write_small(failing *f, const uint8_t *texels) {
    memory_sink s;
    zt_sink sink = memory_sink_of(&s);
    zt_allocator allocator = {f, failing_alloc, failing_free};
    zt_writer_options options = {.effort = 9, .allocator = &allocator};
    zt_image_desc desc = {.format = 9, .width = 600, .height = 20};
    zt_writer *w = NULL;
    uint32_t image;
    zt_result r = zt_writer_open_sink(&sink, &options, NULL, &w);
    if (r == ZT_OK)
        r = zt_writer_add_image(w, &desc, NULL, &image);
    if (r == ZT_OK)
        r = zt_writer_put_rows(w, image, texels, 20, 0, NULL);
    if (r == ZT_OK)
        r = zt_writer_add_texture(w, &(zt_texture_desc){.image = image}, NULL, NULL);
    if (r == ZT_OK)
        r = zt_writer_finish(w, NULL);
    zt_writer_close(w);
    free(s.data);
    return r;
}

static void check_no_memory(const uint8_t *texels) {
    zt_result r = ZT_NO_MEMORY;
    for (long n = 0; r != ZT_OK && n < 1000; n++) {
        failing f = {n, 0};
        r = write_small(&f, texels);
        CHECK(r == ZT_OK || r == ZT_NO_MEMORY);
        CHECK(f.held == 0);
    }
    CHECK(r == ZT_OK);
}

int main(void) {
    uint8_t *texels = malloc(BYTES), *large = calloc(1, 4200u * 1000 * 4);
    zt_writer_options nine = {.effort = 9}, eight = {.effort = 8}, raw = {.effort = 9, .raw_only = 1};
    zt_limits limits = {.memory = 32u << 20};
    zt_writer_options tight = {.effort = 9, .limits = &limits};
    zt_image_desc desc = {.format = 37, .width = WIDTH, .height = HEIGHT, .layers = LAYERS};
    CHECK(texels && large);
    for (int repeats = 0; repeats < 2; repeats++) {
        paint(texels, repeats);
        check_choice(texels, desc);
    }
    desc.wrap_u = desc.wrap_v = ZT_WRAP_CLAMP;
    desc.zero_border = 1;
    check_threads(texels, &desc);
    desc.levels = 1;
    check_usual("one level, highest effort", nine, &desc, texels, 1024);
    check_usual("lower effort", eight, &desc, texels, 256);
    check_usual("raw", raw, &desc, texels, 256);
    check_usual("tight memory", tight, &desc, texels, 256);
    zt_image_desc named = desc, given = desc, wide = desc;
    named.tile_edge = 128;
    check_usual("named", nine, &named, texels, 128);
    given.given_levels = 1;
    given.zero_border = 0;
    check_usual("given levels", nine, &given, texels, 256);
    wide.width = 4200;
    wide.height = 1000;
    wide.layers = 1;
    check_usual("above 16 MiB", nine, &wide, large, 256);
    check_no_memory(texels);
    free(texels);
    free(large);
    return test_end();
}
