/* SPDX-License-Identifier: Apache-2.0 */
/* Of many photographs of several worlds, a quick look finds every pair of which one is a zoom into the other, among a
 * few candidates for each photograph, and the same ones for any number of threads: a pair that is not looked at is a
 * place that is not found. The argument is the module with OpenCV. */
#include <assert.h>
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fractal.h"

enum { WORLDS = 6, VIEWS = 4, COUNT = WORLDS * VIEWS, WANTED = 4, FEATURES = 4000 };

/* Of the views of one world. */
static const uint32_t parents[VIEWS] = {AUTHOR_NONE, 0, 0, 1};

static fractal_view view_of(uint64_t world, int number) {
    fractal_view views[VIEWS] = {
        fractal_look(400, 300, 0.5, 0.5, 0.8, 3, 0.02), fractal_look(320, 240, 0.4, 0.42, 0.24, 80, 0.02),
        fractal_look(320, 240, 0.62, 0.55, 0.12, -30, -0.02), fractal_look(320, 240, 0.41, 0.43, 0.08, 170, 0.01)};
    fractal_view shot = views[number];
    shot.world = world + 1;
    shot.exposure = 1 - 0.1 * number;
    shot.noise = 0.004;
    return shot;
}

static void take(author_run *run, const author_vision *vision, const fractal_view *shot, photo *out) {
    author_picture picture;
    luma_level level;
    uint8_t *bytes;
    *out = (photo){.pixels = {shot->width, shot->height}, .feature_size = {shot->width, shot->height}};
    assert(fractal_photograph(run, shot, &picture) == AUTHOR_OK &&
           luma_create(run, &picture, &out->light) == AUTHOR_OK);
    assert(luma_shrink(run, &out->light, LUMA_GREY, 1, shot->width, shot->height, &level) == AUTHOR_OK);
    assert(luma_bytes(run, &level, &bytes) == AUTHOR_OK);
    assert(vision->detect(bytes, level.width, level.height, FEATURES, &out->features, run->error) == 0);
    author_picture_release(&picture);
    free(level.texels);
    free(bytes);
}

static edge_list selected(const author_vision *vision, const photo *photos, unsigned thread_count) {
    zt_threads *threads;
    edge_list list = {0};
    assert(zt_threads_open(thread_count, &threads) == ZT_OK);
    zt_parallel parallel = zt_threads_parallel(threads);
    author_run run = {.parallel = &parallel};
    assert(select_pairs(&run, vision, photos, COUNT, WANTED, 1 << 26, &list) == AUTHOR_OK);
    zt_threads_close(threads);
    return list;
}

static bool listed(const edge_list *list, uint32_t a, uint32_t b) {
    for (size_t i = 0; i < list->count; i++)
        if (list->edges[i].coarse == a && list->edges[i].fine == b)
            return true;
    return false;
}

static void check_pairs(const edge_list *list) {
    unsigned missing = 0;
    for (uint32_t i = 0; i < COUNT; i++) {
        uint32_t parent = parents[i % VIEWS];
        if (parent == AUTHOR_NONE || listed(list, i - i % VIEWS + parent, i))
            continue;
        printf("world %u: view %u is not compared with its parent %u\n", i / VIEWS, i % VIEWS, parent);
        missing++;
    }
    for (size_t i = 1; i < list->count; i++) {
        const edge *a = &list->edges[i - 1], *b = &list->edges[i];
        assert(a->coarse < a->fine && (a->coarse < b->coarse || (a->coarse == b->coarse && a->fine < b->fine)));
    }
    printf("%zu of %d pairs\n", list->count, COUNT * (COUNT - 1) / 2);
    fflush(stdout);
    assert(missing == 0 && list->count <= COUNT * WANTED);
}

int main(int argc, char **argv) {
    assert(argc == 2);
    void *module = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    const author_vision *vision = module ? dlsym(module, AUTHOR_VISION_SYMBOL) : NULL;
    assert(vision && vision->size == sizeof *vision);
    static photo photos[COUNT];
    author_run run = {0};
    for (int i = 0; i < COUNT; i++) {
        fractal_view shot = view_of((uint64_t)(i / VIEWS), i % VIEWS);
        take(&run, vision, &shot, &photos[i]);
    }
    edge_list one = selected(vision, photos, 1), three = selected(vision, photos, 3);
    check_pairs(&one);
    assert(one.count == three.count);
    for (size_t i = 0; i < one.count; i++)
        assert(one.edges[i].coarse == three.edges[i].coarse && one.edges[i].fine == three.edges[i].fine);
    for (int i = 0; i < COUNT; i++) {
        luma_release(&photos[i].light);
        vision->release(photos[i].features);
    }
    free(one.edges);
    free(three.edges);
    return 0;
}
