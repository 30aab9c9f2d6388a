/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is written is what is read, is valid, and does not depend on threads, on memory for the spool, or on the pieces
 * in which rows come. A writer that fails or is given up leaves the old file and nothing else: people's work is at that
 * path.
 */
#include <dirent.h>
#include <signal.h>
#include <sys/resource.h>
#include <unistd.h>

#include "test.h"
#include "write_sink.h"
#include "zt/zt_check.h"

enum { WIDTH = 83, HEIGHT = 59, LAYERS = 2 };

static int print_finding(void *user, const zt_finding *f) {
    (void)user;
    fprintf(stderr, "rule %u at %s: %s\n", (unsigned)f->rule, f->path, f->text);
    return 0;
}

static void check_valid(const memory_sink *s) {
    zt_check_summary summary;
    zt_check_options options = {.finding = print_finding};
    CHECK(zt_check_memory(s->data, s->size, &options, NULL, &summary) == ZT_OK);
    CHECK(summary.errors == 0 && summary.warnings == 0 && summary.complete);
}

/* Bytes that compress somewhat. Float formats get no NaN and no infinity: the exponent's upper bit stays clear. */
static void fill(const zt_format_info *f, uint8_t *bytes, size_t size, uint64_t seed) {
    for (size_t i = 0; i < size; i++) {
        uint64_t r = test_random(&seed);
        bytes[i] = (uint8_t)(r % 16 ? i / 7 : r >> 20);
        if (f->is_float)
            bytes[i] &= 0x3F;
    }
}

static void put_in_pieces(zt_writer *w, uint32_t image, const uint8_t *rows, uint32_t count, size_t row,
                          uint32_t piece) {
    for (uint32_t y = 0; y < count; y += piece) {
        uint32_t n = count - y < piece ? count - y : piece;
        CHECK(zt_writer_put_rows(w, image, rows + y * row, n, 0, NULL) == ZT_OK);
    }
}

static void write_image(const zt_sink *sink, const zt_writer_options *options, const zt_image_desc *desc,
                        const uint8_t *texels, uint32_t rows, size_t row, uint32_t piece) {
    zt_writer *w;
    zt_diag diag;
    uint32_t image;
    CHECK(zt_writer_open_sink(sink, options, NULL, &w) == ZT_OK);
    CHECK(zt_writer_add_image(w, desc, &diag, &image) == ZT_OK);
    put_in_pieces(w, image, texels, rows, row, piece);
    zt_texture_desc texture = {.name = "one", .image = image};
    CHECK(zt_writer_add_texture(w, &texture, NULL, NULL) == ZT_OK);
    CHECK(zt_writer_set_metadata(w, "zt.title", "t", NULL) == ZT_OK);
    zt_result r = zt_writer_finish(w, &diag);
    CHECK(r == ZT_OK);
    if (r != ZT_OK)
        fprintf(stderr, "%s\n", diag.text);
    CHECK(zt_writer_finish(w, NULL) == ZT_BAD_ARGUMENT);
    zt_writer_close(w);
}

static void compare(const memory_sink *s, const uint8_t *texels, size_t layer_size) {
    zt_file *file;
    zt_diag diag;
    uint8_t *got = malloc(layer_size);
    CHECK(zt_open_memory(s->data, s->size, NULL, &diag, &file) == ZT_OK);
    for (uint32_t layer = 0; file && layer < LAYERS; layer++) {
        CHECK(zt_decode_level(file, 0, 0, layer, got, layer_size, 0, NULL, &diag) == ZT_OK);
        CHECK(memcmp(got, texels + layer * layer_size, layer_size) == 0);
    }
    zt_close(file);
    free(got);
}

static void test_formats(void) {
    static const uint32_t edges[] = {16, 32, 64, 256};
    const zt_format_info *f;
    for (uint32_t i = 0; (f = zt_get_format(i)) != NULL && f->is_plain; i++) {
        size_t row = (size_t)WIDTH * f->block_bytes, size = row * HEIGHT * LAYERS;
        uint8_t *texels = malloc(size);
        fill(f, texels, size, 7 + i);
        for (uint32_t e = 0; e < 8; e++) {
            memory_sink s;
            zt_sink sink = memory_sink_of(&s);
            zt_writer_options options = {.raw_only = (int)(e & 1), .effort = 1};
            zt_image_desc desc = {.format = f->format,
                                  .width = WIDTH,
                                  .height = HEIGHT,
                                  .layers = LAYERS,
                                  .tile_edge = edges[e / 2],
                                  .wrap_v = (uint8_t)(e % 4),
                                  .wrap_u = (uint8_t)(i % 4)};
            write_image(&sink, &options, &desc, texels, HEIGHT * LAYERS, row, 1 + 13 * e);
            check_valid(&s);
            compare(&s, texels, row * HEIGHT);
            free(s.data);
        }
        free(texels);
    }
}

/* Block formats: levels are given, and come in any order. */
static void test_blocks(void) {
    memory_sink s;
    zt_sink sink = memory_sink_of(&s);
    zt_writer *w;
    uint32_t image;
    zt_image_desc desc = {.format = 145, .width = 301, .height = 203, .given_levels = 1, .tile_edge = 16};
    uint8_t *rows = calloc(76 * 51, 16);
    uint64_t seed = 5;
    for (size_t i = 0; i < 76 * 51 * 16; i++)
        rows[i] = (uint8_t)test_random(&seed);
    CHECK(zt_writer_open_sink(&sink, NULL, NULL, &w) == ZT_OK);
    CHECK(zt_writer_add_image(w, &desc, NULL, &image) == ZT_OK);
    for (uint32_t level = 9; level-- > 0;) {
        uint32_t h = (203U >> level) > 0 ? 203U >> level : 1;
        CHECK(zt_writer_put_level_rows(w, image, level, rows, (h + 3) / 4, 0, NULL) == ZT_OK);
        CHECK(zt_writer_put_level_rows(w, image, level, rows, 1, 0, NULL) == ZT_BAD_ARGUMENT);
    }
    zt_texture_desc texture = {.image = image};
    CHECK(zt_writer_add_texture(w, &texture, NULL, NULL) == ZT_OK);
    CHECK(zt_writer_finish(w, NULL) == ZT_OK);
    zt_writer_close(w);
    check_valid(&s);
    free(s.data);
    free(rows);
}

static void test_canonical(void) {
    static const unsigned threads[] = {0, 2, 8};
    enum { W = 700, H = 530 };
    uint8_t *texels = malloc(W * H * 4);
    fill(zt_find_format(43), texels, W * H * 4, 99);
    for (uint8_t wrap = 0; wrap < 4; wrap++) {
        memory_sink first = {0};
        for (int i = 0; i < 6; i++) {
            memory_sink s;
            zt_sink sink = memory_sink_of(&s);
            zt_threads *pool = NULL;
            zt_parallel parallel;
            zt_writer_options options = {.spool_memory = i < 3 ? 0 : 1 << 20, .effort = 3};
            if (threads[i % 3] != 0) {
                CHECK(zt_threads_open(threads[i % 3], &pool) == ZT_OK);
                parallel = zt_threads_parallel(pool);
                options.parallel = &parallel;
            }
            zt_image_desc desc = {.format = 43,
                                  .width = W,
                                  .height = H,
                                  .alpha_mode = ZT_ALPHA_STRAIGHT,
                                  .tile_edge = 64,
                                  .wrap_u = wrap,
                                  .wrap_v = wrap};
            write_image(&sink, &options, &desc, texels, H, W * 4, (uint32_t)(1 + 57 * i));
            if (i == 0) {
                first = s;
                check_valid(&s);
            } else {
                CHECK(s.size == first.size && memcmp(s.data, first.data, s.size) == 0);
                free(s.data);
            }
            zt_threads_close(pool);
        }
        free(first.data);
    }
    free(texels);
}

/* An image that exceeds the memory of the spool, filled in turns with a second one. */
static void test_turns(void) {
    enum { W = 1024, H = 1024 };
    memory_sink s[2];
    uint8_t *texels = malloc(W * H * 4);
    uint64_t seed = 3;
    for (size_t i = 0; i < W * H * 4; i++)
        texels[i] = (uint8_t)test_random(&seed);
    for (int turn = 0; turn < 2; turn++) {
        zt_sink sink = memory_sink_of(&s[turn]);
        zt_writer_options options = {.spool_memory = turn ? 1 << 20 : 0, .raw_only = 1};
        zt_image_desc desc = {.format = 37, .width = W, .height = H};
        zt_writer *w;
        uint32_t a, b;
        CHECK(zt_writer_open_sink(&sink, &options, NULL, &w) == ZT_OK);
        CHECK(zt_writer_add_image(w, &desc, NULL, &a) == ZT_OK);
        CHECK(zt_writer_add_image(w, &desc, NULL, &b) == ZT_OK);
        for (uint32_t y = 0; y < H; y += 64) {
            CHECK(zt_writer_put_rows(w, a, texels + y * W * 4, 64, 0, NULL) == ZT_OK);
            if (turn == 0)
                CHECK(zt_writer_put_rows(w, b, texels + y * W * 4, 64, 0, NULL) == ZT_OK);
        }
        if (turn == 1)
            CHECK(zt_writer_put_rows(w, b, texels, H, 0, NULL) == ZT_OK);
        zt_texture_desc t = {.image = b};
        CHECK(zt_writer_add_texture(w, &t, NULL, NULL) == ZT_OK);
        CHECK(zt_writer_finish(w, NULL) == ZT_OK);
        zt_writer_close(w);
    }
    check_valid(&s[0]);
    CHECK(s[0].size == s[1].size && memcmp(s[0].data, s[1].data, s[0].size) == 0);
    free(s[0].data);
    free(s[1].data);
    free(texels);
}

static void test_sink_fails(void) {
    uint8_t texels[64 * 64 * 4];
    uint64_t seed = 1;
    for (size_t i = 0; i < sizeof texels; i++)
        texels[i] = (uint8_t)test_random(&seed);
    for (long n = 0;; n++) {
        memory_sink s;
        zt_sink sink = memory_sink_of(&s);
        zt_writer_options options = {.raw_only = 1};
        zt_image_desc desc = {.format = 37, .width = 64, .height = 64, .layers = 300, .levels = 1};
        zt_texture_desc texture = {.image = 0};
        zt_writer *w;
        zt_diag diag;
        uint32_t image;
        s.fail_at = n;
        CHECK(zt_writer_open_sink(&sink, &options, NULL, &w) == ZT_OK);
        CHECK(zt_writer_add_image(w, &desc, NULL, &image) == ZT_OK);
        for (int layer = 0; layer < 300; layer++)
            CHECK(zt_writer_put_rows(w, image, texels, 64, 0, NULL) == ZT_OK);
        CHECK(zt_writer_add_texture(w, &texture, NULL, NULL) == ZT_OK);
        zt_result r = zt_writer_finish(w, &diag);
        zt_writer_close(w);
        free(s.data);
        if (r == ZT_OK) {
            CHECK(n > 3);
            return;
        }
        CHECK(r == ZT_IO && diag.result == ZT_IO);
    }
}

static void test_arguments(void) {
    memory_sink s;
    zt_sink sink = memory_sink_of(&s);
    zt_writer *w;
    zt_diag diag;
    uint32_t image;
    uint8_t row[64 * 4] = {0};
    zt_writer_options bad = {.effort = 10};
    CHECK(zt_writer_open_sink(&sink, &bad, &diag, &w) == ZT_BAD_ARGUMENT && !w);
    CHECK(zt_writer_open_path("/nowhere/at/all.ztex", NULL, &diag, &w) == ZT_IO && !w);
    CHECK(zt_writer_open_sink(&sink, NULL, NULL, &w) == ZT_OK);
    static const struct {
        zt_image_desc desc;
        uint32_t rule;
    } refused[] = {
        {{.format = 37, .width = 0, .height = 1}, 6002},
        {{.format = 37, .width = 4, .height = 4, .levels = 4}, 6003},
        {{.format = 37, .width = 4, .height = 4, .tile_edge = 24}, 6004},
        {{.format = 37, .width = 4, .height = 4, .block_width = 2, .block_height = 1, .block_bytes = 4}, 6005},
        {{.format = 9, .width = 4, .height = 4, .alpha_mode = ZT_ALPHA_STRAIGHT}, 6006},
        {{.format = 37, .width = 4, .height = 4, .layers = 5, .layer_kind = ZT_LAYERS_CUBE}, 6007},
        {{.format = 43, .width = 4, .height = 4, .transfer = 8}, 6008},
        {{.format = 145, .width = 64, .height = 64}, 0},
        {{.format = 23, .width = 64, .height = 64, .zero_border = 1}, 0},
        {{.format = 37, .width = 64, .height = 64, .mip_filter = 9}, 0},
    };
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        CHECK(zt_writer_add_image(w, &refused[i].desc, &diag, &image) == ZT_BAD_ARGUMENT);
        CHECK(diag.rule == refused[i].rule && image == ZT_NONE);
    }
    zt_image_desc good = {.format = 37, .width = 64, .height = 4};
    CHECK(zt_writer_add_image(w, &good, &diag, &image) == ZT_OK);
    CHECK(zt_writer_put_rows(w, image + 1, row, 1, 0, &diag) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_put_rows(w, image, row, 5, 0, &diag) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_put_rows(w, image, row, 1, 255, &diag) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_put_rows(w, image, NULL, 1, 0, &diag) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_put_level_rows(w, image, 1, row, 1, 0, &diag) == ZT_BAD_ARGUMENT);
    zt_texture_desc t = {.name = "a\xFF", .image = image};
    CHECK(zt_writer_add_texture(w, &t, &diag, NULL) == ZT_BAD_ARGUMENT && diag.rule == 6107);
    t.name = "a";
    t.image = 7;
    CHECK(zt_writer_add_texture(w, &t, &diag, NULL) == ZT_BAD_ARGUMENT && diag.rule == 6106);
    t.image = image;
    t.wrap_u = (zt_wrap)4;
    CHECK(zt_writer_add_texture(w, &t, &diag, NULL) == ZT_BAD_ARGUMENT && diag.rule == 6104);
    t.wrap_u = ZT_WRAP_REPEAT;
    CHECK(zt_writer_add_texture(w, &t, &diag, NULL) == ZT_OK);
    CHECK(zt_writer_add_texture(w, &t, &diag, NULL) == ZT_BAD_ARGUMENT && diag.rule == 6108);
    CHECK(zt_writer_set_metadata(w, "", "v", &diag) == ZT_BAD_ARGUMENT && diag.rule == 7002);
    CHECK(zt_writer_set_metadata(w, "k", "\xC0\x80", &diag) == ZT_BAD_ARGUMENT && diag.rule == 7004);
    CHECK(zt_writer_add_chunk(w, "xABC", 1, 2, row, 4, &diag) == ZT_BAD_ARGUMENT && diag.rule == 3004);
    CHECK(zt_writer_add_chunk(w, "XABC", 1, 1, row, 4, &diag) == ZT_BAD_ARGUMENT && diag.rule == 3012);
    CHECK(zt_writer_add_chunk(w, "META", 1, 2, row, 4, &diag) == ZT_BAD_ARGUMENT);
    CHECK(zt_writer_finish(w, &diag) == ZT_BAD_ARGUMENT); /* not full */
    CHECK(zt_writer_put_rows(w, image, row, 1, 0, &diag) == ZT_BAD_ARGUMENT);
    zt_writer_close(w);
    CHECK(s.size == 0);
}

static int files_in(const char *folder) {
    DIR *d = opendir(folder);
    int n = 0;
    if (!d)
        return -1;
    for (struct dirent *e; (e = readdir(d)) != NULL;)
        n += strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0;
    closedir(d);
    return n;
}

static int never(void *user, double done) {
    (void)user;
    return done > 0.6;
}

static void write_path(const char *path, uint32_t rows, int (*progress)(void *, double), zt_result expected) {
    enum { W = 1024, H = 1024 };
    zt_writer *w;
    uint32_t image;
    uint64_t seed = 11;
    uint8_t *texels = malloc(W * H * 4);
    for (size_t i = 0; i < W * H * 4; i++)
        texels[i] = (uint8_t)test_random(&seed);
    zt_writer_options options = {.raw_only = 1, .spool_memory = 1 << 20, .progress = progress};
    zt_image_desc desc = {.format = 37, .width = W, .height = H};
    CHECK(zt_writer_open_path(path, &options, NULL, &w) == ZT_OK);
    CHECK(zt_writer_add_image(w, &desc, NULL, &image) == ZT_OK);
    zt_result r = zt_writer_put_rows(w, image, texels, rows, 0, NULL);
    CHECK(r == ZT_OK || (r == ZT_IO && expected == ZT_IO)); /* the spool is full, too */
    zt_texture_desc t = {.image = image};
    CHECK(zt_writer_add_texture(w, &t, NULL, NULL) == (r == ZT_OK ? ZT_OK : ZT_BAD_ARGUMENT));
    if (r == ZT_OK && expected != ZT_AGAIN) /* given up */
        CHECK(zt_writer_finish(w, NULL) == expected);
    zt_writer_close(w);
    free(texels);
}

static void test_paths(void) {
    char folder[200], path[256], text[16] = "";
    const char *temporary = getenv("TMPDIR");
    snprintf(folder, sizeof folder, "%s/zt-write-XXXXXX", temporary ? temporary : "/tmp");
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof path, "%s/old.ztex", folder);
    FILE *f = fopen(path, "wb");
    fputs("precious", f);
    fclose(f);
    write_path(path, 1000, NULL, ZT_AGAIN);
    write_path(path, 1000, NULL, ZT_BAD_ARGUMENT);
    write_path(path, 1024, never, ZT_CANCELLED);
    /* A full disk, as the system reports it. */
    static const rlim_t sizes[] = {0, 100000, 3000000, 4000000, 5000000};
    signal(SIGXFSZ, SIG_IGN);
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        struct rlimit old, limit;
        getrlimit(RLIMIT_FSIZE, &old);
        limit = old;
        limit.rlim_cur = sizes[i];
        setrlimit(RLIMIT_FSIZE, &limit);
        write_path(path, 1024, NULL, ZT_IO);
        setrlimit(RLIMIT_FSIZE, &old);
    }
    f = fopen(path, "rb");
    CHECK(fgets(text, sizeof text, f) && strcmp(text, "precious") == 0);
    fclose(f);
    CHECK(files_in(folder) == 1);
    write_path(path, 1024, NULL, ZT_OK);
    CHECK(files_in(folder) == 1);
    zt_check_summary summary;
    CHECK(zt_check_path(path, NULL, NULL, &summary) == ZT_OK && summary.errors == 0);
    unlink(path);
    rmdir(folder);
}

int main(void) {
    test_formats();
    test_blocks();
    test_canonical();
    test_turns();
    test_sink_fails();
    test_arguments();
    test_paths();
    return test_end();
}
