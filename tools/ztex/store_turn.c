/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Normals of patches. A normal map gives directions in the frame of its own picture; all layers are blended in the
 * root's. So the normals of a patch that lies turned, mirrored or in perspective are turned with it. Slopes are
 * gradients of a height: with K the derivative of the root's texels by the patch's they become K^-T times themselves,
 * and are as steep as before where K only turns and enlarges.
 */
#include "make.h"

#include <math.h>
#include <string.h>

#define NEARLY 1e-3 /* of a unit vector: less than half a step of 8 bits */

/* Texels of the first layers of root and patch, which are taken for squares. */
typedef struct turn_sizes {
    uint32_t root_width, root_height, width, height;
} turn_sizes;

/* What the x and y of normals are multiplied by at a point of the patch, rows first. 0, or -1: beyond the horizon. */
static int factors_at(const make_turn *t, double x, double y, double out[4]) {
    const double *n = t->to_root;
    double w = n[6] * x + n[7] * y + n[8];
    double u = (n[0] * x + n[1] * y + n[2]) / w, v = (n[3] * x + n[4] * y + n[5]) / w;
    double k[4] = {(n[0] - u * n[6]) * t->scale[0], (n[1] - u * n[7]) * t->scale[1], (n[3] - v * n[6]) * t->scale[2],
                   (n[4] - v * n[7]) * t->scale[3]};
    double determinant = k[0] * k[3] - k[1] * k[2];
    double norm = (determinant < 0.0 ? -1.0 : 1.0) / sqrt(fabs(determinant));
    double flip = t->y_down ? 1.0 : -1.0;
    /* K has a factor 1 / w that the norm takes out; its sign stays. */
    norm = w < 0.0 ? -norm : norm;
    if (!isfinite(norm))
        return -1;
    out[0] = k[3] * norm;
    out[1] = -k[2] * norm * flip;
    out[2] = -k[1] * norm * flip;
    out[3] = k[0] * norm;
    return 0;
}

/* 1: normals have to be turned. */
static int begin_turn(const turn_sizes *sizes, const double root_matrix[9], int y_down, make_turn *t) {
    double factors[4];
    int turns = 0;
    *t = (make_turn){.y_down = y_down};
    memcpy(t->to_patch, make_identity, sizeof t->to_patch);
    if (make_matrix_invert(root_matrix, t->to_root))
        return 0;
    t->scale[0] = (double)sizes->root_width / sizes->width;
    t->scale[1] = (double)sizes->root_width / sizes->height;
    t->scale[2] = (double)sizes->root_height / sizes->width;
    t->scale[3] = (double)sizes->root_height / sizes->height;
    for (int i = 0; i < 4; i++) {
        if (factors_at(t, i & 1, i >> 1, factors))
            return 0;
        turns |= fabs(factors[0] - 1.0) > NEARLY || fabs(factors[1]) > NEARLY || fabs(factors[2]) > NEARLY ||
                 fabs(factors[3] - 1.0) > NEARLY;
    }
    return turns;
}

/* A direction with the length that it had; of two channels the third is understood. */
static void turn_normal(const double f[4], uint32_t channels, double n[3]) {
    if (channels == 2)
        n[2] = sqrt(fmax(0.0, 1.0 - n[0] * n[0] - n[1] * n[1]));
    double before = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
    double x = f[0] * n[0] + f[1] * n[1], y = f[2] * n[0] + f[3] * n[1];
    double after = x * x + y * y + n[2] * n[2];
    double scale = after > 0.0 ? sqrt(before / after) : 1.0;
    n[0] = x * scale;
    n[1] = y * scale;
    n[2] *= scale;
}

void make_turn_rows(const make_turn *t, const make_rows *rows, uint32_t y, uint32_t count, float *rgba) {
    uint32_t width = rows->ready ? rows->ready->picture.width : rows->info->width;
    uint32_t height = rows->ready ? rows->ready->picture.height : rows->info->height;
    double factor = rows->format->is_float ? 1.0 : 2.0, offset = rows->format->is_float ? 0.0 : -1.0;
    for (size_t i = 0; rows->channels >= 2 && i < (size_t)width * count; i++) {
        double f[4], n[3];
        float *texel = rgba + 4 * i;
        double x = ((double)(i % width) + 0.5) / width, down = (y + (double)(i / width) + 0.5) / height;
        const double *m = t->to_patch;
        double w = m[6] * x + m[7] * down + m[8];
        if (factors_at(t, (m[0] * x + m[1] * down + m[2]) / w, (m[3] * x + m[4] * down + m[5]) / w, f))
            continue;
        for (int c = 0; c < 3; c++)
            n[c] = (double)texel[c] * factor + offset;
        turn_normal(f, rows->channels, n);
        for (int c = 0; c < 3; c++)
            texel[c] = (float)((n[c] - offset) / factor);
    }
}

const make_turn *make_turn_for(const make_texture *texture, uint32_t index, uint32_t layer, const make_placed *all,
                               const double *frame, make_turn *room) {
    const make_patch *patch = &texture->patches[index];
    const make_parent *root = &all[0].self, *self = &all[index].self;
    turn_sizes sizes = {root->width, root->height, self->width, self->height};
    if (index == 0 || texture->semantics[layer] != ZT_SEMANTIC_NORMAL || patch->normals == NORMALS_KEEP)
        return NULL;
    if (!begin_turn(&sizes, self->root_matrix, patch->normals == NORMALS_Y_DOWN, room))
        return NULL;
    return frame && make_matrix_invert(frame, room->to_patch) ? NULL : room;
}
