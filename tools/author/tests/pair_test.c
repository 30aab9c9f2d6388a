/* SPDX-License-Identifier: Apache-2.0 */
/* A zoom is found again among features that mislead: when many take the same place for theirs, when more of them agree
 * on a wrong size than on the right one, and when the finer picture of a pair is given first, so that the corners of
 * the other one are beyond its horizon. Photographs of plain things are lost otherwise. The argument is the module with
 * OpenCV. */
#include <assert.h>
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fractal.h"

enum { WIDTH = 1000, HEIGHT = 800, RIGHT = 24, MOST = 128 };

/* Features whose matches are known beforehand: feature i of one picture is taken for feature taken[i] of the other
 * one. */
struct author_features {
    author_point points[MOST];
    uint32_t taken[MOST];
    size_t count;
};

static const author_point *points(const author_features *features, size_t *count) {
    *count = features->count;
    return features->points;
}

static int match(const author_features *query, size_t query_count, const author_features *train, author_match *out,
                 size_t *count, char *error) {
    (void)train;
    (void)error;
    *count = query->count < query_count ? query->count : query_count;
    for (size_t i = 0; i < *count; i++)
        out[i] = (author_match){(uint32_t)i, query->taken[i], 0.5F};
    return 0;
}

typedef struct scene {
    fractal_view views[2]; /* coarse, fine */
    author_features features[2];
    author_random random;
} scene;

static double within(scene *s, double most) {
    return (0.05 + 0.9 * author_random_unit(&s->random)) * most;
}

static scene make_scene(double slant) {
    scene s = {.views = {fractal_look(WIDTH, HEIGHT, 0.5, 0.5, 0.8, 0, 0),
                         fractal_look(WIDTH, HEIGHT, 0.2, 0.25, 0.1, 25, slant)}};
    author_random_seed(&s.random, 1, 1);
    return s;
}

/* One more feature of each picture, which are taken for each other: blobs of these sizes at these places. */
static void add(scene *s, const double at[2][2], double size, double turn) {
    for (int i = 0; i < 2; i++) {
        author_features *f = &s->features[i];
        assert(f->count < MOST);
        f->points[f->count] = (author_point){(float)at[i][0], (float)at[i][1], i ? (float)size : 3,
                                             i ? (float)turn : 0};
        f->taken[f->count] = (uint32_t)f->count;
        f->count++;
    }
}

static void add_right(scene *s, int count) {
    plane to_coarse = fractal_between(&s->views[1], &s->views[0]);
    for (int i = 0; i < count; i++) {
        double at[2][2] = {{0, 0}, {within(s, WIDTH), within(s, HEIGHT)}};
        assert(plane_apply(&to_coarse, at[1][0] / WIDTH, at[1][1] / HEIGHT, &at[0][0], &at[0][1]));
        at[0][0] *= WIDTH;
        at[0][1] *= HEIGHT;
        add(s, at, 24, 25);
    }
}

static void add_wrong(scene *s, int count, double size, double turn) {
    for (int i = 0; i < count; i++) {
        const double at[2][2] = {{within(s, WIDTH), within(s, HEIGHT)}, {within(s, WIDTH), within(s, HEIGHT)}};
        add(s, at, size, turn);
    }
}

static pair_places look(const author_vision *module, scene *s, int fine_first) {
    author_run run = {0};
    author_vision vision = {.points = points, .match = match, .homography = module->homography};
    photo photos[2] = {{.pixels = {WIDTH, HEIGHT}, .feature_size = {WIDTH, HEIGHT}},
                       {.pixels = {WIDTH, HEIGHT}, .feature_size = {WIDTH, HEIGHT}}};
    photos[0].features = &s->features[fine_first];
    photos[1].features = &s->features[!fine_first];
    const edge pair = {.coarse = 0, .fine = 1};
    pair_places places;
    assert(pair_match(&run, &vision, photos, &pair, &places) == AUTHOR_OK);
    return places;
}

static void check(const char *what, const scene *s, const pair_places *places, uint32_t coarse) {
    const edge *best = &places->edges[0];
    double error = fractal_error(&best->matrix, &s->views[0], &s->views[1]);
    printf("%s: %u of %u features agree, corners %.2f px, %s\n", what, best->inliers, best->matches, error,
           author_reason_name(best->reason));
    fflush(stdout);
    assert(best->reason == AUTHOR_REASON_NONE && best->coarse == coarse && best->fine == !coarse);
    assert(best->inliers >= RIGHT - 2 && error < 5);
}

int main(int argc, char **argv) {
    assert(argc == 2);
    void *module = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    const author_vision *vision = module ? dlsym(module, AUTHOR_VISION_SYMBOL) : NULL;
    assert(vision && vision->size == sizeof *vision);

    scene crowd = make_scene(0);
    add_right(&crowd, RIGHT);
    add_wrong(&crowd, 4 * RIGHT, 24, 25);
    for (size_t i = RIGHT; i < crowd.features[1].count; i++)
        crowd.features[1].taken[i] = RIGHT;
    pair_places places = look(vision, &crowd, 0);
    check("a crowd in one place", &crowd, &places, 0);

    scene sizes = make_scene(0);
    add_right(&sizes, RIGHT);
    add_wrong(&sizes, 2 * RIGHT, 4, 100);
    places = look(vision, &sizes, 0);
    check("a wrong size", &sizes, &places, 0);

    scene slanted = make_scene(0.08);
    add_right(&slanted, 4 * RIGHT);
    places = look(vision, &slanted, 1);
    check("the finer one first", &slanted, &places, 1);
    return 0;
}
