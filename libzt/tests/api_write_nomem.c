/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Every allocation of a whole writing is refused once, alone and with all that follow: the writer says so, closes, and
 * gives back all it had. Programs that write textures run where memory is short.
 */
#include "test.h"
#include "write_sink.h"

typedef struct counter {
    long calls, fail_at, live;
    int from_then_on;
} counter;

static void *count_alloc(void *user, size_t size) {
    counter *c = user;
    long n = c->calls++;
    if (n == c->fail_at || (c->from_then_on && n > c->fail_at))
        return NULL;
    c->live++;
    return malloc(size);
}

static void count_free(void *user, void *ptr, size_t size) {
    counter *c = user;
    memset(ptr, 0xDD, size); /* a wrong size shows */
    c->live--;
    free(ptr);
}

static zt_result add_silmap(zt_writer *w, const uint8_t *texels) {
    static uint8_t cells[40 * 30];
    zt_image_desc image = {.format = 43, .width = 41, .height = 31, .levels = 1, .tile_edge = 16};
    zt_texture_desc desc = {.name = "silmap", .wrap_u = ZT_WRAP_CLAMP, .wrap_v = ZT_WRAP_CLAMP};
    zt_diag diag;
    zt_result r;
    uint32_t samples, t;
    for (size_t i = 0; i < sizeof cells; i++) /* no arm leaves the texture */
        cells[i] = (uint8_t)(i % 40 == 0 || i < 40 ? 0x24 : texels[i] << 4 | texels[i + 1]);
    if ((r = zt_writer_add_image(w, &image, &diag, &samples)) != ZT_OK ||
        (r = zt_writer_put_rows(w, samples, texels, 31, 0, &diag)) != ZT_OK)
        return r;
    zt_silmap_desc silmap = {.cells_x = 40, .cells_y = 30, .cells = cells, .samples = &samples};
    return zt_writer_add_silmap(w, &desc, &silmap, &diag, &t);
}

static zt_result fill_writer(zt_writer *w, const uint8_t *texels) {
    uint32_t a, b, t;
    zt_diag diag;
    zt_result r;
    zt_image_desc root = {.format = 43, .width = 90, .height = 70, .tile_edge = 16};
    zt_image_desc patch = {.format = 43, .width = 65, .height = 33, .alpha_mode = ZT_ALPHA_STRAIGHT, .zero_border = 1};
    uint32_t root_source, patch_source;
    if ((r = zt_writer_add_image(w, &root, &diag, &a)) != ZT_OK ||
        (r = zt_writer_add_image(w, &patch, &diag, &b)) != ZT_OK)
        return r;
    if ((r = zt_writer_put_rows(w, a, texels, 70, 0, &diag)) != ZT_OK ||
        (r = zt_writer_put_rows(w, b, texels, 33, 0, &diag)) != ZT_OK)
        return r;
    zt_texture_desc desc = {.name = "picture", .image = a};
    if ((r = zt_writer_add_texture(w, &desc, &diag, &t)) != ZT_OK)
        return r;
    root_source = a;
    patch_source = b;
    zt_patch_desc patches[2] = {{.sources = &root_source, .mask = ZT_NONE, .matrix = {1, 0, 0, 0, 1, 0, 0, 0, 1}},
                                {.sources = &patch_source, .mask = ZT_NONE, .matrix = {4, 0, -1, 0, 4, -1, 0, 0, 1}}};
    zt_texture_desc zipmap = {.name = "zipmap"};
    if ((r = zt_writer_add_zipmap(w, &zipmap, patches, 2, &diag, &t)) != ZT_OK)
        return r;
    if ((r = add_silmap(w, texels)) != ZT_OK)
        return r;
    if ((r = zt_writer_set_metadata(w, "zt.title", "title", &diag)) != ZT_OK ||
        (r = zt_writer_set_metadata(w, "zt.title", "other", &diag)) != ZT_OK ||
        (r = zt_writer_add_chunk(w, "XONE", 1, 2, texels, 5000, &diag)) != ZT_OK)
        return r;
    r = zt_writer_finish(w, &diag);
    CHECK(r == ZT_OK || (diag.result == r && diag.text[0]));
    return r;
}

static zt_result run(counter *c, const uint8_t *texels, memory_sink *s) {
    zt_allocator allocator = {c, count_alloc, count_free};
    zt_writer_options options = {.allocator = &allocator, .effort = 1};
    zt_sink sink = memory_sink_of(s);
    zt_writer *w;
    zt_result r = zt_writer_open_sink(&sink, &options, NULL, &w);
    CHECK((r == ZT_OK) == (w != NULL));
    if (r == ZT_OK)
        r = fill_writer(w, texels);
    zt_writer_close(w);
    CHECK(c->live == 0);
    return r;
}

int main(void) {
    static uint8_t texels[90 * 70 * 4];
    uint64_t seed = 2;
    for (size_t i = 0; i < sizeof texels; i++)
        texels[i] = (uint8_t)(test_random(&seed) & 15);
    memory_sink whole, s;
    counter clean = {.fail_at = -1};
    CHECK(run(&clean, texels, &whole) == ZT_OK);
    zt_file *file;
    CHECK(zt_open_memory(whole.data, whole.size, NULL, NULL, &file) == ZT_OK);
    zt_close(file);
    CHECK(clean.calls > 40);
    for (long n = 0; n < clean.calls; n++)
        for (int then = 0; then < 2; then++) {
            counter c = {.fail_at = n, .from_then_on = then};
            zt_result r = run(&c, texels, &s);
            /* The spool may do without memory; then the file is the same. */
            CHECK(r == ZT_NO_MEMORY || (r == ZT_OK && s.size == whole.size && memcmp(s.data, whole.data, s.size) == 0));
            free(s.data);
        }
    free(whole.data);
    return test_end();
}
