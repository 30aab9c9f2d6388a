/* SPDX-License-Identifier: Apache-2.0 */
/* Octaves of smooth noise; a view shows those that are wider than its pixels. */
#include "fractal.h"

#include <math.h>

enum { OCTAVES = 15, FIRST = 2 }; /* cells along the world: 2 to the power of these */

static double lattice(uint64_t world, int octave, int64_t x, int64_t y) {
    uint64_t h = world * 0x9E3779B97F4A7C15U + (uint64_t)octave * 0xC2B2AE3D27D4EB4FU;
    h ^= (uint64_t)x * 0xFF51AFD7ED558CCDU;
    h = (h ^ h >> 33) * 0xC4CEB9FE1A85EC53U;
    h ^= (uint64_t)y * 0xD6E8FEB86659FD93U;
    h = (h ^ h >> 32) * 0x9FB21C651E98DF25U;
    return (double)((h ^ h >> 28) >> 11) * 0x1p-53 - 0.5;
}

/* The quadratic B-spline of the lattice: smooth, so that a little blur in a camera changes it only a little. */
static double octave_at(uint64_t world, int octave, double x, double y) {
    double scale = ldexp(1, octave + FIRST), u = x * scale, v = y * scale, sum = 0;
    int64_t i = (int64_t)floor(u), j = (int64_t)floor(v);
    double a = u - (double)i, b = v - (double)j;
    const double across[3] = {(1 - a) * (1 - a) / 2, 0.75 - (a - 0.5) * (a - 0.5), a * a / 2};
    const double down[3] = {(1 - b) * (1 - b) / 2, 0.75 - (b - 0.5) * (b - 0.5), b * b / 2};
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            sum += across[c] * down[r] * lattice(world, octave, i + c - 1, j + r - 1);
    return sum;
}

static double light_at(uint64_t world, double x, double y, double pixel) {
    double sum = 0;
    for (int octave = 0; octave < OCTAVES; octave++) {
        double wide = 1 / (ldexp(1, octave + FIRST) * pixel); /* pixels of a cell */
        double share = fmin(fmax(wide - 0.5, 0), 1);
        if (share > 0)
            sum += share * pow(0.87, octave) * octave_at(world, octave, x, y);
    }
    return fmin(fmax(0.35 + 0.45 * sum, 0.01), 0.9);
}

fractal_view fractal_look(uint32_t width, uint32_t height, double x, double y, double across, double degrees,
                          double slant) {
    double turn = degrees * 3.14159265358979323846 / 180, c = across * cos(turn), s = across * sin(turn);
    double aspect = (double)height / width;
    plane place = {{c, -s * aspect, x, s, c * aspect, y, slant, slant / 2, 1}},
          centre = {{1, 0, -0.5, 0, 1, -0.5, 0, 0, 1}};
    return (fractal_view){
        .to_world = plane_multiply(&place, &centre), .width = width, .height = height, .exposure = 1, .world = 1};
}

author_result fractal_photograph(author_run *run, const fractal_view *shot, author_picture *out) {
    author_random random;
    author_result result = author_picture_create(run, shot->width, shot->height, 1, out);
    double pixel = 1 / (plane_magnification(&shot->to_world, 0.5, 0.5) > 0
                            ? sqrt((double)shot->width * shot->height) / plane_magnification(&shot->to_world, 0.5, 0.5)
                            : 1);
    author_random_seed(&random, shot->world, shot->width);
    for (size_t i = 0; i < (size_t)shot->width * shot->height && result == AUTHOR_OK; i++) {
        double u = ((double)(i % shot->width) + 0.5) / shot->width,
               v = ((double)(i / shot->width) + 0.5) / shot->height;
        double x = 0, y = 0, r = (2 * u - 1) * (2 * u - 1) + (2 * v - 1) * (2 * v - 1);
        plane_apply(&shot->to_world, u, v, &x, &y);
        double light = light_at(shot->world, x, y, pixel) * shot->exposure * (1 - shot->vignetting * r / 2);
        double root = sqrt(light) + shot->noise * (author_random_unit(&random) - 0.5) * sqrt(12);
        out->texels[i] = (float)(root * root);
    }
    return result;
}

plane fractal_between(const fractal_view *from, const fractal_view *to) {
    plane back, out = plane_identity();
    if (plane_inverse(&to->to_world, &back))
        out = plane_multiply(&back, &from->to_world);
    plane_normalise(&out);
    return out;
}

double fractal_error(const plane *matrix, const fractal_view *coarse, const fractal_view *fine) {
    plane truth = fractal_between(coarse, fine), back;
    double most = 0;
    if (!plane_inverse(&truth, &back))
        return HUGE_VAL;
    for (int i = 0; i < 4; i++) {
        double u = i & 1, v = i >> 1, x, y, a, b;
        if (!plane_apply(&back, u, v, &x, &y) || !plane_apply(matrix, x, y, &a, &b))
            return HUGE_VAL;
        most = fmax(most, hypot((a - u) * fine->width, (b - v) * fine->height));
    }
    return most;
}
