/* SPDX-License-Identifier: Apache-2.0 */
/* The eight unknowns of a homography that is nearly right, and how large residuals are: what both refinements share. */
#include <math.h>
#include <string.h>

#include "zipmap_private.h"

static const double REACH = 0.25; /* of residuals; larger ones fall into the last bin */

void residuals_add(residuals *all, double value) {
    double bin = fabs(value) * (RESIDUAL_BINS / REACH);
    all->bins[bin < RESIDUAL_BINS - 1 ? (size_t)bin : RESIDUAL_BINS - 1]++;
    all->count++;
}

double residuals_deviation(const residuals *all) {
    size_t below = 0, i = 0;
    while (i < RESIDUAL_BINS - 1 && (below += all->bins[i]) * 2 < all->count)
        i++;
    return 1.4826 * ((double)i + 0.5) * REACH / RESIDUAL_BINS;
}

void motion_row(const view *v, const double place[2], const double gradient[2], double row[MOTION]) {
    double gs = gradient[0] * v->coarse.width / 2, gt = gradient[1] * v->coarse.height / 2;
    double s = place[0], t = place[1], radial = gs * s + gt * t;
    const double all[MOTION] = {gs, gs * s, gs * t, gt, gt * s, gt * t, radial * s, radial * t};
    memcpy(row, all, sizeof all);
}

/* Coarse coordinates to places in the footprint's box. */
static plane box_of(const view *v) {
    double w = v->box[2] - v->box[0], h = v->box[3] - v->box[1];
    return (plane){{2.0 * v->size[0] / w, 0, -2.0 * v->box[0] / w - 1, 0, 2.0 * v->size[1] / h,
                    -2.0 * v->box[1] / h - 1, 0, 0, 1}};
}

void motion_apply(const view *v, const double d[MOTION], plane *matrix) {
    plane motion = {{1 + d[1], d[2], d[0], d[4], 1 + d[5], d[3], -d[6], -d[7], 1}};
    plane box = box_of(v), back;
    plane_inverse(&box, &back);
    plane a = plane_multiply(&motion, &box), b = plane_multiply(&back, &a);
    *matrix = plane_multiply(matrix, &b);
}

double motion_travel(const view *v, const double d[MOTION]) {
    double most = 0;
    for (int i = 0; i < 4; i++) {
        double s = i & 1 ? 1 : -1, t = i & 2 ? 1 : -1;
        double ds = d[0] + d[1] * s + d[2] * t + s * (d[6] * s + d[7] * t);
        double dt = d[3] + d[4] * s + d[5] * t + t * (d[6] * s + d[7] * t);
        most = fmax(most, hypot(ds * v->coarse.width / 2, dt * v->coarse.height / 2));
    }
    return most;
}

double motion_spread(const view *v, const double *normal, size_t unknowns) {
    double total = 0, a[MOST_UNKNOWNS * MOST_UNKNOWNS], row[MOST_UNKNOWNS], column[MOST_UNKNOWNS];
    for (int i = 0; i < 8; i++) {
        const double place[2] = {i & 1 ? 1 : -1, i & 2 ? 1 : -1}, gradient[2] = {i < 4, i >= 4};
        memset(row, 0, sizeof row);
        motion_row(v, place, gradient, row);
        memcpy(a, normal, unknowns * unknowns * sizeof *a);
        memcpy(column, row, sizeof column);
        if (!plane_solve(a, column, unknowns))
            return HUGE_VAL;
        for (size_t k = 0; k < unknowns; k++)
            total += row[k] * column[k];
    }
    return sqrt(total / 4);
}
