/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: author_harmonic gives the function of the discrete Laplace equation that the border fixes, in sizes of
 * every kind, to 1e-4 of the border's range, and leaves the border alone. It matters because every colour correction is
 * this function: where it is wrong, a patch shows a cloud that neither picture has.
 */
#include "author_adjust.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* sin(a x) sinh(b y) is discretely harmonic when 2 cos a + 2 cosh b = 4; so is the saddle x^2 - y^2, and so are their
 * sums. */
static double known(int which, double x, double y, double size) {
    double a = 3.14159265358979 / size * 3.0, b = acosh(2.0 - cos(a));
    if (which == 0)
        return (x * x - y * y + 3.0 * x) / (size * size);
    if (which == 1)
        return sin(a * x) * sinh(b * y) / sinh(b * size);
    return cos(a * y) * cosh(b * x) / cosh(b * size) + x * y / (size * size);
}

static double worst_of(uint32_t w, uint32_t h) {
    double size = w > h ? w : h, worst = 0.0;
    float *planes[3];
    author_run run = {0};
    for (int p = 0; p < 3; p++) {
        planes[p] = malloc((size_t)w * h * sizeof(float));
        assert(planes[p]);
        for (uint32_t y = 0; y < h; y++)
            for (uint32_t x = 0; x < w; x++) {
                int border = x == 0 || y == 0 || x + 1 == w || y + 1 == h;
                planes[p][(size_t)y * w + x] = border ? (float)known(p, x, y, size) : 1e6f;
            }
    }
    assert(author_harmonic(&run, planes, 3, w, h) == AUTHOR_OK);
    for (int p = 0; p < 3; p++) {
        for (uint32_t y = 0; y < h; y++)
            for (uint32_t x = 0; x < w; x++)
                worst = fmax(worst, fabs((double)planes[p][(size_t)y * w + x] - known(p, x, y, size)));
        free(planes[p]);
    }
    return worst;
}

int main(void) {
    static const uint32_t sizes[][2] = {{1, 1},   {2, 5},   {3, 3},   {3, 200},   {4, 7},    {5, 5},    {6, 9},
                                        {17, 33}, {18, 31}, {100, 3}, {128, 128}, {129, 65}, {251, 97}, {640, 481}};
    int bad = 0;
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        double worst = worst_of(sizes[i][0], sizes[i][1]);
        if (worst <= 1e-4)
            continue;
        printf("%u x %u: off by %g\n", (unsigned)sizes[i][0], (unsigned)sizes[i][1], worst);
        bad = 1;
    }
    return bad;
}
