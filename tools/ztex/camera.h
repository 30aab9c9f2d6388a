/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pinhole camera over the ground that a texture lies on, z = 0. All lengths are in widths of the ground; x goes to
 * the right, y down as in the texture, and z up.
 */
#ifndef ZTEX_CAMERA_H
#define ZTEX_CAMERA_H

#include <stdint.h>

typedef struct camera_pose {
    double eye[3], target[3], up[3];
    double fov; /* degrees, of the picture's height */
} camera_pose;

/* The parts of a pose, as a set. */
enum { CAMERA_EYE = 1, CAMERA_TARGET = 2, CAMERA_UP = 4, CAMERA_FOV = 8 };

/* right and down lead from a pixel to the next, at one unit of length along forward, which has length 1. */
typedef struct camera {
    double eye[3], forward[3], right[3], down[3];
    double left, top; /* of the picture's outer corner, in pixels from the middle */
} camera;

/* Looks from the near side of a ground as high as aspect widths. */
camera_pose camera_default(double aspect);

/* NULL, or what is wrong with the pose. */
const char *camera_open(const camera_pose *pose, uint32_t width, uint32_t height, camera *out);

/* The direction to a place in the picture, in pixels: one unit of it is one along forward. */
void camera_direction(const camera *c, double x, double y, double direction[3]);

/* A ray inside of the box from 0 to size: eye + t direction, t from range[0] to range[1], at least 0. 0, or -1: it
 * misses. leaves: 1 when it leaves through z = 0. */
int camera_clip(const camera *c, const double direction[3], const double size[3], double range[2], int *leaves);

/* Where the ground is met, and its change for a step of a pixel to the right and down: x, y, dx, dy of right, dx, dy of
 * down. 0, or -1: not at all. */
int camera_ground(const camera *c, const double direction[3], double out[6]);

#endif
