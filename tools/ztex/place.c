/* SPDX-License-Identifier: Apache-2.0 */
/* Where a patch lies: from what people write down to the matrix of zipmap.md, parent coordinates to the patch's. */
#include "make.h"

#include <math.h>
#include <string.h>

const double make_identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

void make_matrix_multiply(const double a[9], const double b[9], double out[9]) {
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++)
            out[3 * r + c] = (a[3 * r] * b[c] + a[3 * r + 1] * b[3 + c]) + a[3 * r + 2] * b[6 + c];
}

/* Row r, column c of the adjugate. */
static double cofactor(const double m[9], int r, int c) {
    int a = (c + 1) % 3, b = (c + 2) % 3, x = (r + 1) % 3, y = (r + 2) % 3;
    return m[3 * a + x] * m[3 * b + y] - m[3 * a + y] * m[3 * b + x];
}

int make_matrix_invert(const double m[9], double out[9]) {
    double determinant = 0.0;
    for (int i = 0; i < 3; i++)
        determinant += m[i] * cofactor(m, i, 0);
    if (!isfinite(determinant) || determinant == 0.0)
        return -1;
    for (int i = 0; i < 9; i++)
        out[i] = cofactor(m, i / 3, i % 3) / determinant;
    return 0;
}

/* The rectangle [u, u + w] x [v, v + h] becomes the unit square. */
static const char *from_rectangle(double u, double v, double w, double h, double m[9]) {
    if (!(fabs(w) > 0.0 && fabs(h) > 0.0))
        return "the rectangle is empty";
    const double rectangle[9] = {1.0 / w, 0, -u / w, 0, 1.0 / h, -v / h, 0, 0, 1};
    memcpy(m, rectangle, sizeof rectangle);
    return NULL;
}

/* Twice the area of the triangle a, b, c with its sign. */
static double turn(const double *a, const double *b, const double *c) {
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* The homography that takes the unit square to the quadrilateral (Heckbert, Fundamentals of Texture Mapping and Image
 * Warping, 1989, section 2.2.3), inverted. */
static const char *from_corners(const double q[8], double m[9]) {
    double bends[4];
    for (int i = 0; i < 4; i++)
        bends[i] = turn(q + 2 * i, q + 2 * ((i + 1) % 4), q + 2 * ((i + 2) % 4));
    for (int i = 0; i < 4; i++)
        if (!(bends[i] * bends[0] > 0.0))
            return "the four corners do not make a convex quadrilateral: the order is that of the "
                   "patch's corners (0,0), (1,0), (1,1), (0,1)";
    double sx = (q[0] - q[2]) + (q[4] - q[6]), sy = (q[1] - q[3]) + (q[5] - q[7]);
    double g = 0.0, h = 0.0;
    if (sx != 0.0 || sy != 0.0) {
        double dx1 = q[2] - q[4], dx2 = q[6] - q[4], dy1 = q[3] - q[5], dy2 = q[7] - q[5];
        double below = dx1 * dy2 - dx2 * dy1;
        g = (sx * dy2 - dx2 * sy) / below;
        h = (dx1 * sy - sx * dy1) / below;
    }
    const double square_to_quad[9] = {q[2] - q[0] + g * q[2],
                                      q[6] - q[0] + h * q[6],
                                      q[0],
                                      q[3] - q[1] + g * q[3],
                                      q[7] - q[1] + h * q[7],
                                      q[1],
                                      g,
                                      h,
                                      1.0};
    return make_matrix_invert(square_to_quad, m) ? "the four corners do not make a quadrilateral" : NULL;
}

static const char *from_root(const double root_to_patch[9], const make_parent *parent, double m[9]) {
    double back[9];
    if (make_matrix_invert(parent->root_matrix, back))
        return "the parent's own placement cannot be inverted";
    make_matrix_multiply(root_to_patch, back, m);
    return NULL;
}

static const char *from_crop(const make_crop *crop, double m[9]) {
    double w = crop->full_width, h = crop->full_height;
    if (crop->rect.width == 0)
        return "at_crop needs an image with a crop rectangle";
    return from_rectangle(crop->rect.x / w, crop->rect.y / h, crop->rect.width / w, crop->rect.height / h, m);
}

static const char *place(const make_patch *patch, const make_parent *parent, const make_crop *crop, double m[9]) {
    const double *n = patch->numbers;
    switch (patch->place) {
    case PLACE_OFFSET:
        return from_rectangle(n[0], n[1], n[2], n[3], m);
    case PLACE_CORNERS:
        return from_corners(n, m);
    case PLACE_PIXELS:
        return from_rectangle(n[0] / parent->width, n[1] / parent->height, n[2] / parent->width, n[3] / parent->height,
                              m);
    case PLACE_MATRIX_ROOT:
        return from_root(n, parent, m);
    case PLACE_CROP:
        return from_crop(crop, m);
    default:
        memcpy(m, n, 9 * sizeof *m);
        return NULL;
    }
}

const char *make_place_matrix(const make_patch *patch, const make_parent *parent, const make_crop *crop,
                              double matrix[9]) {
    const char *wrong = place(patch, parent, crop, matrix);
    for (int i = 0; !wrong && i < 9; i++) {
        if (!isfinite(matrix[i]))
            return "the placement is too small or too far away for the numbers of the format";
        matrix[i] += 0.0; /* negative zero becomes zero: [R8109] */
    }
    return wrong;
}
