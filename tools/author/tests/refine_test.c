/* SPDX-License-Identifier: Apache-2.0 */
/* A homography that is some pixels off is brought to the right one, to a small part of a pixel, whatever the exposure,
 * the vignetting, the noise and the zoom: the places of all patches come from this. And two pictures of different
 * things do not pass for one. */
#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "fractal.h"

/* averaged: each pixel is the mean of so many by so many. */
static photo take(author_run *run, const fractal_view *shot, uint32_t averaged) {
    photo out = {.pixels = {shot->width, shot->height}};
    fractal_view finer = *shot;
    author_picture picture, mean;
    finer.width *= averaged;
    finer.height *= averaged;
    assert(fractal_photograph(run, &finer, &picture) == AUTHOR_OK);
    assert(author_picture_create(run, shot->width, shot->height, 1, &mean) == AUTHOR_OK);
    for (size_t i = 0; i < (size_t)finer.width * finer.height; i++)
        mean.texels[i / finer.width / averaged * shot->width + i % finer.width / averaged] += picture.texels[i] /
                                                                                              (float)(averaged *
                                                                                                      averaged);
    assert(luma_create(run, &mean, &out.light) == AUTHOR_OK);
    author_picture_release(&picture);
    author_picture_release(&mean);
    return out;
}

static refine_result refine(author_run *run, const fractal_view *coarse, const fractal_view *fine, double off) {
    photo a = take(run, coarse, 1), b = take(run, fine, 1);
    refine_result out;
    plane start = fractal_between(coarse, fine);
    plane wrong = {{1 + off, off / 2, off, -off / 2, 1 - off, -off, off / 4, 0, 1}};
    start = plane_multiply(&wrong, &start);
    assert(refine_plane(run, &a, &b, &start, 100000, &out) == AUTHOR_OK);
    luma_release(&a.light);
    luma_release(&b.light);
    return out;
}

/* Where the coarse picture is an exact average, what is left is bias, from light that is not quite out. A chain of
 * zooms multiplies it, so that solving for place and light together must leave next to none. */
static void test_bias(author_run *run, uint32_t zoom, double most) {
    fractal_view coarse = fractal_look(400, 300, 0.5, 0.5, 0.9, 4, 0.02);
    fractal_view fine = fractal_look(360, 270, 0.45, 0.55, 0.81 / zoom, 40, -0.05);
    coarse.noise = fine.noise = 0.0005;
    fine.exposure = 0.7;
    fine.vignetting = 0.35;
    photo photos[2] = {take(run, &coarse, zoom), take(run, &fine, 1)};
    refine_result found;
    plane start = fractal_between(&coarse, &fine);
    assert(refine_plane(run, &photos[0], &photos[1], &start, 100000, &found) == AUTHOR_OK && found.converged);
    edge polished = {.coarse = 0, .fine = 1, .matrix = found.matrix};
    assert(pair_polish(run, photos, 100000, &polished) == AUTHOR_OK);
    double before = fractal_error(&found.matrix, &coarse, &fine);
    double after = fractal_error(&polished.matrix, &coarse, &fine);
    printf("zoom %u, no noise to speak of: corners %.4f px, with the light %.4f px, expected %.4f\n", zoom, before,
           after, polished.spread);
    fflush(stdout);
    assert(after < most && polished.spread > 0);
    luma_release(&photos[0].light);
    luma_release(&photos[1].light);
}

int main(void) {
    /* zoom, and the error that noise may leave, in pixels of the fine picture: it grows as the footprint shrinks to 60
     * texels */
    static const double cases[][2] = {{1, 0.05}, {2, 0.1}, {4, 0.4}, {8, 1}, {12, 3}};
    author_run run = {0};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        fractal_view coarse = fractal_look(600, 450, 0.5, 0.5, 0.9, 4, 0.02);
        fractal_view fine = fractal_look(480, 360, 0.45, 0.55, 0.72 / cases[i][0], 40, -0.05);
        fine.exposure = 0.7;
        fine.vignetting = 0.2;
        coarse.vignetting = 0.15;
        coarse.noise = fine.noise = 0.004;
        refine_result found = refine(&run, &coarse, &fine, 0.02);
        double error = fractal_error(&found.matrix, &coarse, &fine);
        printf("zoom %g: corners %.3f px, expected %.3f, correlation %.4f, detail %.3f, residual %.3f\n", cases[i][0],
               error, found.spread, found.correlation, found.local_correlation, found.residual);
        assert(found.converged && found.correlation > 0.95 && found.local_correlation > 0.7);
        fflush(stdout);
        assert(error < cases[i][1] && error < 3 * found.spread);
    }
    fractal_view coarse = fractal_look(600, 450, 0.5, 0.5, 0.9, 4, 0),
                 other = fractal_look(480, 360, 0.5, 0.5, 0.3, 0, 0);
    other.world = 2;
    refine_result found = refine(&run, &coarse, &other, 0);
    printf("another world: converged %d, correlation %.3f, detail %.3f\n", found.converged, found.correlation,
           found.local_correlation);
    assert(!found.converged || found.correlation < 0.8);
    test_bias(&run, 2, 0.03);
    test_bias(&run, 4, 0.045);
    return 0;
}
