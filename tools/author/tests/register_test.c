/* SPDX-License-Identifier: Apache-2.0 */
/* A heap of photographs of one world, with one of another world and one of repeated texture among them, becomes the
 * right tree, each picture in its place, and nothing else is placed; the result has the same bytes for any number of
 * threads. This is what `ztex make zipmap` promises. The argument is the module with OpenCV. */
#include <assert.h>
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fractal.h"

enum { COUNT = 7, OTHER = 5, REPEATED = 6 };

typedef struct heap {
    fractal_view views[COUNT];
    author_photo photos[COUNT];
} heap;

static author_result load(void *user, size_t index, uint64_t max_texels, author_picture *out, char *error) {
    const heap *h = user;
    author_run run = {0};
    (void)max_texels;
    author_result result = fractal_photograph(&run, &h->views[index], out);
    memcpy(error, run.error, AUTHOR_ERROR);
    if (index != REPEATED || result != AUTHOR_OK)
        return result;
    enum { PERIOD = 40 };
    for (uint32_t y = 0; y < out->height; y++)
        for (uint32_t x = 0; x < out->width; x++)
            out->texels[(size_t)y * out->width + x] = out->texels[(size_t)(y % PERIOD) * out->width + x % PERIOD];
    return AUTHOR_OK;
}

/* 0 is the root, 1 and 2 lie in it, 3 in 1, 4 in 3: 27 times finer than the root. */
static const uint32_t parents[COUNT] = {AUTHOR_NONE, 0, 0, 1, 3, AUTHOR_NONE, AUTHOR_NONE};

static heap make_heap(void) {
    heap h = {.views = {fractal_look(520, 390, 0.5, 0.5, 0.8, 2, 0.03),
                        fractal_look(480, 360, 0.4, 0.45, 0.25, 75, 0.02),
                        fractal_look(480, 360, 0.66, 0.56, 0.2, -20, -0.02),
                        fractal_look(480, 360, 0.41, 0.46, 0.08, 10, 0.01),
                        fractal_look(480, 360, 0.405, 0.465, 0.027, 160, -0.004),
                        fractal_look(480, 360, 0.5, 0.5, 0.3, 0, 0), fractal_look(480, 360, 0.3, 0.3, 0.3, 0, 0)}};
    static const char *const names[COUNT] = {"root", "left", "right", "closer", "closest", "other", "repeated"};
    h.views[OTHER].world = 2;
    h.views[REPEATED].world = 3;
    for (int i = 0; i < COUNT; i++) {
        h.views[i].exposure = 1 - 0.07 * i;
        h.views[i].vignetting = 0.03 * i;
        h.views[i].noise = 0.004;
        h.photos[i] = (author_photo){names[i], h.views[i].width, h.views[i].height};
    }
    return h;
}

static void check_tree(const heap *h, const author_registration *found) {
    assert(found->group_count == 1 && found->roots[0] == 0 && found->order_count == OTHER && found->order[0] == 0);
    for (uint32_t i = 0; i < COUNT; i++) {
        const author_placing *p = &found->placings[i];
        plane matrix;
        memcpy(matrix.m, p->matrix, sizeof matrix.m);
        double error = parents[i] == AUTHOR_NONE ? 0 : fractal_error(&matrix, &h->views[parents[i]], &h->views[i]);
        printf("%-8s state %d parent %d ratio %.2f corners %.3f px, expected %.3f, correlation %.3f %s\n",
               h->photos[i].name, p->state, (int)p->parent, p->ratio, error, p->uncertainty, p->correlation, p->text);
        fflush(stdout);
        assert(p->state == (i == 0 ? AUTHOR_ROOT : i < OTHER ? AUTHOR_PLACED : AUTHOR_UNPLACED));
        assert(p->parent == parents[i] && error < 0.8);
        assert(i < OTHER || (p->reason != AUTHOR_REASON_NONE && p->text[0]));
    }
    for (size_t i = 1; i < found->order_count; i++)
        assert(found->placings[found->order[i]].state == AUTHOR_PLACED);
}

static author_registration registered(heap *h, const author_vision *vision, unsigned thread_count) {
    zt_threads *threads;
    assert(zt_threads_open(thread_count, &threads) == ZT_OK);
    zt_parallel parallel = zt_threads_parallel(threads);
    author_run run = {.parallel = &parallel};
    author_photos photos = {h->photos, COUNT, load, h};
    author_registration found;
    author_result result = author_register(&run, vision, &photos, NULL, &found);
    if (result != AUTHOR_OK)
        printf("author_register: %d %s\n", (int)result, run.error);
    assert(result == AUTHOR_OK);
    zt_threads_close(threads);
    return found;
}

int main(int argc, char **argv) {
    assert(argc == 2);
    void *module = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    const author_vision *vision = module ? dlsym(module, AUTHOR_VISION_SYMBOL) : NULL;
    assert(vision && vision->size == sizeof *vision);
    heap h = make_heap();
    author_registration one = registered(&h, vision, 1), three = registered(&h, vision, 3);
    check_tree(&h, &one);
    for (int i = 0; i < COUNT; i++) {
        const author_placing *a = &one.placings[i], *b = &three.placings[i];
        assert(a->state == b->state && a->parent == b->parent && strcmp(a->text, b->text) == 0);
        assert(memcmp(a->matrix, b->matrix, sizeof a->matrix) == 0);
        assert(memcmp(a->root_matrix, b->root_matrix, sizeof a->root_matrix) == 0);
    }
    assert(memcmp(one.order, three.order, COUNT * sizeof *one.order) == 0);
    assert(one.pair_count == three.pair_count);
    for (size_t i = 0; i < one.pair_count; i++) {
        const author_pair *a = &one.pairs[i], *b = &three.pairs[i];
        assert(a->coarse == b->coarse && a->fine == b->fine && a->inliers == b->inliers && a->reason == b->reason);
        assert(memcmp(a->matrix, b->matrix, sizeof a->matrix) == 0);
    }
    author_registration_release(&one);
    author_registration_release(&three);
    return 0;
}
