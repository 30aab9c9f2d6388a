/* SPDX-License-Identifier: Apache-2.0 */
/* A homography that is some pixels off is brought to the right one, to a small part of a pixel, whatever the exposure, the vignetting,
 * the noise and the zoom: the places of all patches come from this. And two pictures of different things do not pass for one. */
#include <assert.h>
#include <math.h>
#include <stdio.h>

#include "fractal.h"

static photo take(author_run *run, const fractal_view *shot) {
    photo out = {.pixels = {shot->width, shot->height}};
    author_picture picture;
    assert(fractal_photograph(run, shot, &picture) == AUTHOR_OK);
    assert(luma_create(run, &picture, &out.light) == AUTHOR_OK);
    author_picture_release(&picture);
    return out;
}

static refine_result refine(author_run *run, const fractal_view *coarse, const fractal_view *fine, double off) {
    photo a = take(run, coarse), b = take(run, fine);
    refine_result out;
    plane start = fractal_between(coarse, fine);
    plane wrong = {{1 + off, off / 2, off, -off / 2, 1 - off, -off, off / 4, 0, 1}};
    start = plane_multiply(&wrong, &start);
    assert(refine_plane(run, &a, &b, &start, 100000, &out) == AUTHOR_OK);
    luma_release(&a.light);
    luma_release(&b.light);
    return out;
}

int main(void) {
    /* zoom, and the error that noise may leave, in pixels of the fine picture: it grows as the footprint shrinks to 60 texels */
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
    return 0;
}
