/* SPDX-License-Identifier: Apache-2.0 */
#include "camera.h"

#include <math.h>
#include <string.h>

static double dot(const double a[3], const double b[3]) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const double a[3], const double b[3], double out[3]) {
    for (int c = 0; c < 3; c++)
        out[c] = a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3];
}

/* To a length; 0, or -1: there is none. */
static int scale_to(double v[3], double length) {
    double now = sqrt(dot(v, v));
    if (!(now > 1e-12) || !isfinite(now))
        return -1;
    for (int c = 0; c < 3; c++)
        v[c] *= length / now;
    return 0;
}

camera_pose camera_default(double aspect) {
    return (camera_pose){
        .eye = {0.5, aspect + 0.35, 0.42}, .target = {0.5, 0.6 * aspect, 0}, .up = {0, 0, 1}, .fov = 38};
}

const char *camera_open(const camera_pose *pose, uint32_t width, uint32_t height, camera *out) {
    double pixel = 2 * tan(pose->fov * 3.14159265358979323846 / 360) / height;
    if (!(pose->fov > 0 && pose->fov < 180))
        return "the field of view is above 0 and below 180 degrees";
    memcpy(out->eye, pose->eye, sizeof out->eye);
    for (int c = 0; c < 3; c++)
        out->forward[c] = pose->target[c] - pose->eye[c];
    if (scale_to(out->forward, 1))
        return "the eye is at its target";
    /* x right, y towards the viewer, z up is left-handed: so this is the right-hand side. */
    cross(pose->up, out->forward, out->right);
    if (scale_to(out->right, pixel))
        return "the camera looks along its up direction";
    cross(out->right, out->forward, out->down);
    if (scale_to(out->down, pixel))
        return "the picture has no height";
    out->left = -0.5 * width;
    out->top = -0.5 * height;
    return NULL;
}

void camera_direction(const camera *c, double x, double y, double direction[3]) {
    for (int k = 0; k < 3; k++)
        direction[k] = c->forward[k] + (x + c->left) * c->right[k] + (y + c->top) * c->down[k];
}

int camera_clip(const camera *c, const double direction[3], const double size[3], double range[2], int *leaves) {
    range[0] = 0;
    range[1] = INFINITY;
    *leaves = 0;
    for (int k = 0; k < 3; k++) {
        double d = direction[k], a = -c->eye[k] / d, b = (size[k] - c->eye[k]) / d;
        if (fabs(d) < 1e-15) {
            if (c->eye[k] < 0 || c->eye[k] > size[k])
                return -1;
            continue;
        }
        *leaves = k == 2 && d < 0 && a <= range[1];
        range[0] = fmax(range[0], fmin(a, b));
        range[1] = fmin(range[1], fmax(a, b));
    }
    return range[0] <= range[1] && isfinite(range[1]) ? 0 : -1;
}

int camera_ground(const camera *c, const double direction[3], double out[6]) {
    const double *steps[2] = {c->right, c->down};
    double t = -c->eye[2] / direction[2];
    if (!(t > 0) || !isfinite(t))
        return -1;
    for (int k = 0; k < 2; k++) {
        out[k] = c->eye[k] + t * direction[k];
        /* A step changes the direction by a pixel, and t so that z stays 0. */
        for (int s = 0; s < 2; s++)
            out[2 + 2 * s + k] = t * (steps[s][k] - direction[k] * steps[s][2] / direction[2]);
    }
    return 0;
}
