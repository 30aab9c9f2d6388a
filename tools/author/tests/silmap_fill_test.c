/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Properties of flat drawings as shapes: at every place there is the colour that painting one shape over the other
 * gives, for both fill rules, for shapes within others and for what is seen through, as a slow painter finds it point
 * by point; the picture has the mean of that over each texel; neither depends on threads; a fit is held to exact
 * borders and pure colours; and shapes that cannot be are refused. It matters because the fit takes these regions as
 * the truth.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "checks.h"
#include "silmap_fill.h"

#define W 24
#define H 20
#define FINER 32 /* places along a texel */
#define DRAWINGS 60
#define MOST 12 /* shapes of a drawing */
#define POINTS 7

/* ---- drawings ------------------------------------------------------------------------------------------- */

typedef struct flat_art {
    double points[MOST * 2 * POINTS * 2];
    author_path paths[MOST * 2];
    author_silmap_shape shapes[MOST];
    author_silmap_input input;
} flat_art;

/* Two paths each, partly outside; every fourth is for others to be within. */
static void scatter(author_random *chance, int see_through, flat_art *out) {
    double *at = out->points;
    *out = (flat_art){
        .input = {.paths = out->paths, .path_count = MOST * 2, .shapes = out->shapes, .shape_count = MOST}};
    for (size_t p = 0; p < MOST * 2; p++, at += 2 * POINTS) {
        out->paths[p] = (author_path){at, 3 + author_random_below(chance, POINTS - 2), 1};
        for (size_t i = 0; i < 2 * POINTS; i++)
            at[i] = 1.6 * author_random_unit(chance) - 0.3;
    }
    for (uint32_t s = 0; s < MOST; s++) {
        author_silmap_shape *shape = &out->shapes[s];
        *shape = (author_silmap_shape){.first = 2 * (size_t)s,
                                       .count = 2,
                                       .even_odd = (int)author_random_below(chance, 2),
                                       .bounds = s % 4 == 1,
                                       .opacity = 1};
        /* The last one that bounds. */
        if (s > 1 && author_random_below(chance, 2))
            shape->within = (s - 2) / 4 * 4 + 2;
        if (see_through && author_random_below(chance, 2))
            shape->opacity = (float)(0.1 + 0.8 * author_random_unit(chance));
        for (int c = 0; c < 3; c++)
            shape->colour[c] = (float)author_random_unit(chance);
    }
}

/* ---- the slow painter ----------------------------------------------------------------------------------- */

static int is_in(const author_silmap_input *input, uint32_t number, double x, double y) {
    const author_silmap_shape *shape = &input->shapes[number];
    int winding = 0;
    for (size_t p = shape->first; p < shape->first + shape->count; p++) {
        const author_path *path = &input->paths[p];
        for (size_t i = 0; i < path->count; i++) {
            const double *a = path->points + 2 * i, *b = path->points + 2 * ((i + 1) % path->count);
            double side = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
            winding += a[1] <= y && b[1] > y && side > 0;
            winding -= b[1] <= y && a[1] > y && side < 0;
        }
    }
    if (!(shape->even_odd ? winding & 1 : winding != 0))
        return 0;
    return shape->within == 0 || is_in(input, shape->within - 1, x, y);
}

static void paint(const author_silmap_input *input, int plain, double x, double y, double value[4]) {
    memset(value, 0, 4 * sizeof *value);
    for (uint32_t s = 0; s < input->shape_count; s++) {
        const author_silmap_shape *shape = &input->shapes[s];
        double opacity = (double)shape->opacity;
        if (shape->bounds || !is_in(input, s, x, y))
            continue;
        for (int c = 0; c < 4; c++) {
            float own = c == 3 ? 1 : plain ? shape->colour[c] : zt_transfer_encode(13, shape->colour[c]);
            value[c] += opacity * ((double)own - value[c]);
        }
    }
}

/* ---- properties ----------------------------------------------------------------------------------------- */

static double worst_colour(const silmap_truth *truth, const author_silmap_input *input, int plain) {
    enum { PLACES = 97 };
    silmap_sweep sweep;
    double worst = 0;
    CHECK(silmap_sweep_create(truth, &sweep) == AUTHOR_OK);
    for (int j = 0; j < PLACES; j++) {
        double y = (j + 0.5) / PLACES;
        const silmap_run *run = sweep.runs;
        CHECK(run[silmap_fills_runs(&sweep, y, 0.5 / PLACES, 1.0 / PLACES, PLACES) - 1].end == PLACES);
        for (int i = 0; i < PLACES; i++) {
            double value[4];
            run += run->end <= (size_t)i;
            paint(input, plain, (i + 0.5) / PLACES, y, value);
            for (int c = 0; c < 4; c++)
                worst = fmax(worst, fabs(value[c] * 255 - (double)(run->key >> (24 - 8 * c) & 255)));
        }
    }
    silmap_sweep_release(&sweep);
    return worst;
}

static void test_places(void) {
    author_random chance;
    author_run run = {0};
    author_random_seed(&chance, 11, 1);
    for (int d = 0; d < DRAWINGS; d++) {
        flat_art art;
        author_picture picture = {W, H, 4, NULL};
        silmap_truth truth = {.picture = &picture};
        scatter(&chance, d % 2, &art);
        CHECK(silmap_fills_create(&run, &art.input, d % 3 == 0, &truth) == AUTHOR_OK);
        CHECK(worst_colour(&truth, &art.input, d % 3 == 0) < 0.51);
        silmap_truth_release(&truth);
    }
}

/* The same rows by other workers and in another order. */
static void backwards(void *user, size_t count, void (*task)(void *context, size_t index, unsigned worker),
                      void *context) {
    (void)user;
    for (size_t i = count; i-- > 0;)
        task(context, i, (unsigned)(i % 3));
}

static author_picture draw(const flat_art *art, const zt_parallel *parallel) {
    author_run run = {.parallel = parallel};
    author_picture picture;
    CHECK(author_picture_create(&run, W, H, 4, &picture) == AUTHOR_OK);
    CHECK(author_silmap_draw(&run, &art->input, 0, &picture) == AUTHOR_OK);
    return picture;
}

/* The largest difference between a texel and the mean of what is painted in it. */
static double worst_texel(const flat_art *art, const author_picture *picture) {
    double worst = 0;
    for (size_t i = 0; i < (size_t)W * H; i++) {
        double mean[4] = {0}, value[4];
        for (size_t k = 0; k < FINER * FINER; k++) {
            double x = (double)(i % W) + ((double)(k % FINER) + 0.5) / FINER;
            double y = (double)(i / W) + ((double)(k / FINER) + 0.5) / FINER;
            paint(&art->input, 0, x / W, y / H, value);
            for (int c = 0; c < 4; c++)
                mean[c] += value[c] / (FINER * FINER);
        }
        const float *texel = picture->texels + 4 * i;
        for (int c = 0; c < 4; c++) {
            double shown = (double)(c == 3 ? texel[3] : zt_transfer_encode(13, texel[c]) * texel[3]);
            worst = fmax(worst, fabs(shown - mean[c]));
        }
    }
    return worst;
}

static void test_texels(void) {
    const zt_parallel other = {.run = backwards, .workers = 3};
    author_random chance;
    author_random_seed(&chance, 12, 1);
    for (int d = 0; d < DRAWINGS / 10; d++) {
        flat_art art;
        scatter(&chance, d % 2, &art);
        author_picture picture = draw(&art, NULL), again = draw(&art, &other);
        CHECK(memcmp(picture.texels, again.texels, (size_t)W * H * 4 * sizeof(float)) == 0);
        /* The painter's places are as coarse as that. */
        CHECK(worst_texel(&art, &picture) < 1.2 / FINER);
        author_picture_release(&picture);
        author_picture_release(&again);
    }
}

/* A square whose sides are where points can stand. */
static void test_fit(void) {
    double low = (2 + 3.5 / 8) / 16, high = (13 + 4.5 / 8) / 16;
    const double square[] = {low, low, high, low, high, high, low, high};
    author_path path = {square, 4, 1};
    author_silmap_shape shape = {.count = 1, .colour = {0.25f, 0.5f, 0.125f}, .opacity = 1};
    author_picture picture;
    author_run run = {0};
    author_silmap_input input = {
        .picture = &picture, .paths = &path, .path_count = 1, .shapes = &shape, .shape_count = 1};
    author_silmap_options options = {.cells_x = 16, .cells_y = 16};
    author_silmap_result result;
    CHECK(author_picture_create(&run, 256, 256, 4, &picture) == AUTHOR_OK);
    CHECK(author_silmap_draw(&run, &input, 0, &picture) == AUTHOR_OK);
    CHECK(author_silmap_fit(&run, &input, &options, &result) == AUTHOR_OK);
    CHECK(result.disagreement < 1e-9);
    for (size_t s = 0; s < 17 * 17; s++) {
        const float *sample = result.samples.texels + 4 * s;
        int in = s % 17 > 2 && s % 17 < 14 && s / 17 > 2 && s / 17 < 14;
        CHECK(fabsf(sample[3] - (float)in) < 1e-6f);
        for (int c = 0; c < 3 && in; c++)
            CHECK(fabsf(sample[c] - shape.colour[c]) < 1e-6f);
    }
    author_silmap_release(&result);
    author_picture_release(&picture);
}

static void refuse(author_silmap_input input, const char *word) {
    author_run run = {0};
    author_picture picture;
    CHECK(author_picture_create(&run, 8, 8, 4, &picture) == AUTHOR_OK);
    CHECK(author_silmap_draw(&run, &input, 0, &picture) == AUTHOR_BAD_INPUT);
    if (!strstr(run.error, word) && failures++ < 30)
        fprintf(stderr, "\"%s\" does not say \"%s\"\n", run.error, word);
    author_picture_release(&picture);
}

static void test_refused(void) {
    double points[] = {0, 0, 1, 0, 0, 1};
    author_path path = {points, 3, 1};
    author_silmap_shape shapes[100] = {{.count = 1}};
    author_silmap_input input = {.paths = &path, .path_count = 1, .shapes = shapes, .shape_count = 1};
    shapes[0].count = 2;
    refuse(input, "paths that are not there");
    shapes[0] = (author_silmap_shape){.first = SIZE_MAX, .count = 1};
    refuse(input, "paths that are not there");
    shapes[0] = (author_silmap_shape){.count = 1, .within = 1};
    refuse(input, "within one that comes later");
    shapes[0].within = 0;
    for (int i = 0; i < 3; i++) {
        points[3] = i == 0 ? NAN : i == 1 ? INFINITY : -1e12;
        refuse(input, "nowhere near");
    }
    points[3] = 0;
    for (uint32_t i = 1; i < 100; i++)
        shapes[i] = (author_silmap_shape){.count = 1, .within = i};
    input.shape_count = 100;
    refuse(input, "within each other");
    input.shape_count = SIZE_MAX;
    refuse(input, "more than");
}

int main(void) {
    test_places();
    test_texels();
    test_fit();
    test_refused();
    return failures != 0;
}
