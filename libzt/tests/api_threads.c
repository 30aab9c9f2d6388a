/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A file and a sampler are used by many threads at once, without a lock of the caller's: what is loaded on first touch
 * (tile indices, metadata, tiles of a sampler) is published once and is the same for all. Run under ThreadSanitizer.
 */
#include <pthread.h>
#include <stdatomic.h>

#include "corpus.h"
#include "test.h"

enum { THREADS = 8, ROUNDS = 20, POINTS = 16 };

typedef struct shared {
    const zt_file *file;
    const zt_sampler *sampler; /* NULL: the file has none */
    uint8_t *levels[64];       /* layer 0 of the levels of image 0, decoded alone */
    float samples[4 * POINTS];
    pthread_barrier_t start;
    atomic_int failures;
} shared;

static void points_of(zt_point *points) {
    uint64_t state = 7;
    memset(points, 0, POINTS * sizeof *points);
    for (int i = 0; i < POINTS; i++) {
        points[i].u = test_uniform(&state, -0.5, 1.5);
        points[i].v = test_uniform(&state, -0.5, 1.5);
        points[i].du_dx = points[i].dv_dy = test_uniform(&state, 0, 0.4);
    }
}

static bool decode_is_same(const shared *s, uint32_t level) {
    zt_level_info info;
    zt_diag diag;
    if (zt_get_level(s->file, 0, level, &info) != ZT_OK)
        return false;
    size_t size = (size_t)info.layer_size;
    uint8_t *texels = malloc(size);
    bool same = zt_decode_level(s->file, 0, level, 0, texels, size, 0, NULL, &diag) == ZT_OK &&
                memcmp(texels, s->levels[level], size) == 0;
    free(texels);
    return same;
}

static bool metadata_is_there(const shared *s) {
    uint32_t count;
    const char *key, *value;
    if (zt_load_metadata(s->file, &count, NULL) != ZT_OK)
        return false;
    for (uint32_t i = 0; i < count; i++) {
        if (zt_get_metadata(s->file, i, &key, &value) != ZT_OK || zt_find_metadata(s->file, key) != value)
            return false;
    }
    return true;
}

static bool samples_are_same(const shared *s) {
    zt_point points[POINTS];
    float out[4 * POINTS];
    if (!s->sampler)
        return true;
    points_of(points);
    return zt_sample(s->sampler, points, POINTS, out, NULL) == ZT_OK && memcmp(out, s->samples, sizeof out) == 0;
}

static void *worker(void *argument) {
    shared *s = argument;
    zt_image_info image;
    zt_tile_info tile;
    int failures = 0;
    pthread_barrier_wait(&s->start); /* so that first touches meet */
    failures += zt_get_image(s->file, 0, &image) != ZT_OK;
    for (uint32_t k = image.levels; k-- > 0;) {
        failures += zt_get_tile(s->file, 0, k, 0, &tile, NULL) != ZT_OK;
        failures += !decode_is_same(s, k);
    }
    failures += !metadata_is_there(s);
    failures += !samples_are_same(s);
    atomic_fetch_add(&s->failures, failures);
    return NULL;
}

/* What one thread gets from a file of its own. */
static void fill_expected(shared *s, blob b) {
    zt_file *file;
    zt_image_info image;
    zt_sampler *sampler;
    zt_point points[POINTS];
    CHECK(zt_open_memory(b.data, b.size, NULL, NULL, &file) == ZT_OK);
    CHECK(zt_get_image(file, 0, &image) == ZT_OK);
    for (uint32_t k = 0; k < image.levels; k++) {
        zt_level_info info;
        CHECK(zt_get_level(file, 0, k, &info) == ZT_OK);
        s->levels[k] = malloc((size_t)info.layer_size);
        CHECK(zt_decode_level(file, 0, k, 0, s->levels[k], (size_t)info.layer_size, 0, NULL, NULL) == ZT_OK);
    }
    points_of(points);
    if (zt_sampler_open(file, 0, NULL, NULL, &sampler) == ZT_OK)
        CHECK(zt_sample(sampler, points, POINTS, s->samples, NULL) == ZT_OK);
    zt_sampler_close(sampler);
    zt_close(file);
}

static void run_round(shared *s, blob b) {
    pthread_t threads[THREADS];
    zt_file *file;
    zt_sampler *sampler = NULL;
    CHECK(zt_open_memory(b.data, b.size, NULL, NULL, &file) == ZT_OK);
    if (zt_sampler_open(file, 0, NULL, NULL, &sampler) != ZT_OK)
        sampler = NULL;
    s->file = file;
    s->sampler = sampler;
    assert(pthread_barrier_init(&s->start, NULL, THREADS) == 0);
    for (int i = 0; i < THREADS; i++)
        assert(pthread_create(&threads[i], NULL, worker, s) == 0);
    for (int i = 0; i < THREADS; i++)
        pthread_join(threads[i], NULL);
    pthread_barrier_destroy(&s->start);
    zt_sampler_close(sampler);
    zt_close(file);
}

static void test_file(const char *name) {
    blob b = blob_read(VALID_FOLDER, name);
    shared s = {0};
    fill_expected(&s, b);
    for (int i = 0; i < ROUNDS; i++)
        run_round(&s, b);
    CHECK(atomic_load(&s.failures) == 0);
    for (size_t i = 0; i < sizeof s.levels / sizeof *s.levels; i++)
        free(s.levels[i]);
    blob_free(b);
}

/* A region decoded by a pool, while other threads do the same with the same pool's file. */
static void *pool_worker(void *argument) {
    shared *s = argument;
    zt_threads *threads;
    zt_level_info info;
    zt_diag diag;
    if (zt_threads_open(3, &threads) != ZT_OK || zt_get_level(s->file, 0, 0, &info) != ZT_OK) {
        atomic_fetch_add(&s->failures, 1);
        return NULL;
    }
    zt_parallel parallel = zt_threads_parallel(threads);
    zt_decode_options options = {.parallel = &parallel};
    uint8_t *texels = malloc((size_t)info.layer_size);
    for (int i = 0; i < 5; i++) {
        zt_result result = zt_decode_level(s->file, 0, 0, 0, texels, (size_t)info.layer_size, 0, &options, &diag);
        if (result != ZT_OK || memcmp(texels, s->levels[0], (size_t)info.layer_size) != 0)
            atomic_fetch_add(&s->failures, 1);
    }
    free(texels);
    zt_threads_close(threads);
    return NULL;
}

static void test_pools(const char *name) {
    blob b = blob_read(VALID_FOLDER, name);
    shared s = {0};
    pthread_t threads[4];
    zt_file *file;
    fill_expected(&s, b);
    CHECK(zt_open_memory(b.data, b.size, NULL, NULL, &file) == ZT_OK);
    s.file = file;
    for (int i = 0; i < 4; i++)
        assert(pthread_create(&threads[i], NULL, pool_worker, &s) == 0);
    for (int i = 0; i < 4; i++)
        pthread_join(threads[i], NULL);
    CHECK(atomic_load(&s.failures) == 0);
    zt_close(file);
    for (size_t i = 0; i < sizeof s.levels / sizeof *s.levels; i++)
        free(s.levels[i]);
    blob_free(b);
}

int main(void) {
    static const char *const names[] = {"first.ztex",      "tiles_many.ztex",        "levels_first_two_of_300x200.ztex",
                                        "meta_zstd.ztex",  "zip_several.ztex",       "zip_meta_unknown_chunk.ztex",
                                        "zip_in_zip.ztex", "tile_zstd_encoder.ztex", "volume_tiled.ztex"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        test_file(names[i]);
    test_pools("tiles_many.ztex");
    test_pools("tiles_edge_16_clipped.ztex");
    return test_end();
}
