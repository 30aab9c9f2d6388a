/* SPDX-License-Identifier: Apache-2.0 */
/* Homographies between the coordinates of pictures. */
#include <math.h>

#include "zipmap_private.h"

enum { CONTAINED_GRID = 64 };

static const double MOST_STRETCH = 4; /* of the magnification of one corner to that of another */

plane plane_identity(void) {
    return (plane){{1, 0, 0, 0, 1, 0, 0, 0, 1}};
}

plane plane_scale(double x, double y) {
    return (plane){{x, 0, 0, 0, y, 0, 0, 0, 1}};
}

plane plane_multiply(const plane *a, const plane *b) {
    plane out;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            out.m[r * 3 + c] = (a->m[r * 3] * b->m[c] + a->m[r * 3 + 1] * b->m[3 + c]) + a->m[r * 3 + 2] * b->m[6 + c];
    return out;
}

bool plane_inverse(const plane *a, plane *out) {
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            int i = (c + 1) % 3, j = (c + 2) % 3, x = (r + 1) % 3, y = (r + 2) % 3;
            out->m[r * 3 + c] = a->m[i * 3 + x] * a->m[j * 3 + y] - a->m[i * 3 + y] * a->m[j * 3 + x];
        }
    double d = a->m[0] * out->m[0] + a->m[1] * out->m[3] + a->m[2] * out->m[6];
    bool good = d != 0 && isfinite(d);
    for (int i = 0; i < 9; i++) {
        out->m[i] /= good ? d : 1;
        good = good && isfinite(out->m[i]);
    }
    return good;
}

bool plane_normalise(plane *a) {
    plane back;
    if (!plane_inverse(a, &back))
        return false;
    /* The preimage of (1/2, 1/2, 1) has w = 1 / third entry: scaling by its w makes that of the result 1. */
    double w = back.m[6] * 0.5 + back.m[7] * 0.5 + back.m[8];
    if (w == 0)
        return false;
    bool good = true;
    for (int i = 0; i < 9; i++) {
        a->m[i] = a->m[i] * w + 0.0;
        good = good && isfinite(a->m[i]);
    }
    return good;
}

bool plane_apply(const plane *a, double x, double y, double *u, double *v) {
    double w = a->m[6] * x + a->m[7] * y + a->m[8];
    if (!(w > 0))
        return false;
    *u = (a->m[0] * x + a->m[1] * y + a->m[2]) / w;
    *v = (a->m[3] * x + a->m[4] * y + a->m[5]) / w;
    return true;
}

double plane_magnification(const plane *a, double x, double y) {
    double u, v;
    if (!plane_apply(a, x, y, &u, &v))
        return 0;
    double w = a->m[6] * x + a->m[7] * y + a->m[8];
    double ux = (a->m[0] - u * a->m[6]) / w, uy = (a->m[1] - u * a->m[7]) / w;
    double vx = (a->m[3] - v * a->m[6]) / w, vy = (a->m[4] - v * a->m[7]) / w;
    double d = ux * vy - uy * vx;
    return d > 0 ? sqrt(d) : 0;
}

double plane_ratio(const plane *a, const uint32_t coarse[2], const uint32_t fine[2]) {
    plane back;
    double x, y;
    if (!plane_inverse(a, &back) || !plane_apply(&back, 0.5, 0.5, &x, &y))
        return 0;
    double texels = sqrt((double)fine[0] * fine[1] / ((double)coarse[0] * coarse[1]));
    return plane_magnification(a, x, y) * texels;
}

bool plane_plausible(const plane *a, const uint32_t coarse[2], const uint32_t fine[2]) {
    plane back;
    if (!plane_inverse(a, &back))
        return false;
    double texels = sqrt((double)fine[0] * fine[1] / ((double)coarse[0] * coarse[1]));
    double least = HUGE_VAL, most = 0;
    for (int i = 0; i < 5; i++) {
        double u = i == 4 ? 0.5 : i & 1, v = i == 4 ? 0.5 : i >> 1, x, y;
        if (!plane_apply(&back, u, v, &x, &y))
            return false;
        double m = plane_magnification(a, x, y) * texels;
        least = fmin(least, m);
        most = fmax(most, m);
    }
    return least > 0 && isfinite(most) && most < least * MOST_STRETCH;
}

double plane_contained(const plane *a) {
    plane back;
    int inside = 0;
    if (!plane_inverse(a, &back))
        return 0;
    for (int i = 0; i < CONTAINED_GRID * CONTAINED_GRID; i++) {
        double u = (i % CONTAINED_GRID + 0.5) / CONTAINED_GRID, v = (i / CONTAINED_GRID + 0.5) / CONTAINED_GRID, x, y;
        if (plane_apply(&back, u, v, &x, &y) && x >= 0 && x <= 1 && y >= 0 && y <= 1)
            inside++;
    }
    return (double)inside / (CONTAINED_GRID * CONTAINED_GRID);
}

bool plane_solve(double *a, double *x, size_t n) {
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j <= i; j++) {
            double sum = a[i * n + j];
            for (size_t k = 0; k < j; k++)
                sum -= a[i * n + k] * a[j * n + k];
            if (i == j && !(sum > 0))
                return false;
            a[i * n + j] = i == j ? sqrt(sum) : sum / a[j * n + j];
        }
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++)
            x[i] -= a[i * n + k] * x[k];
        x[i] /= a[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t k = i + 1; k < n; k++)
            x[i] -= a[k * n + i] * x[k];
        x[i] /= a[i * n + i];
    }
    return true;
}
