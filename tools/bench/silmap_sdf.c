/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A distance field as it is used for glyphs and signs (Green, SIGGRAPH 2007): each texel has the distance of its centre
 * to the outline, less outside and more inside, in 8 bits over some texels to each side. Here the distances are exact.
 */
#include <math.h>
#include <stdlib.h>

#include "silmap_bench.h"

typedef struct field {
    const shape *s;
    double *distance;
} field;

uint8_t sdf_code(double distance, double range) {
    double value = floor(127.5 + 127.5 * distance / range + 0.5);
    return value <= 0 ? 0 : value >= 255 ? 255 : (uint8_t)value;
}

static void take_nearer(void *context, size_t i, size_t texel, double x, double y) {
    const field *f = context;
    const piece *p = &f->s->pieces[i];
    double dx = p->x1 - p->x0, dy = p->y1 - p->y0, length = dx * dx + dy * dy;
    double t = length > 0 ? ((x - p->x0) * dx + (y - p->y0) * dy) / length : 0;
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    double d = hypot(x - p->x0 - t * dx, y - p->y0 - t * dy);
    if (d < f->distance[texel])
        f->distance[texel] = d;
}

void sdf_make(const shape *s, size_t grid, uint8_t *out) {
    double n = (double)grid, range = SDF_RANGE / n;
    field f = {s, bench_alloc(grid * grid, sizeof(double))};
    uint8_t *inside = bench_alloc(grid, 1);
    for (size_t i = 0; i < grid * grid; i++)
        f.distance[i] = range;
    shape_visit(s, grid, range, take_nearer, &f);
    for (size_t y = 0; y < grid; y++) {
        shape_row(s, ((double)y + 0.5) / n, 0.5 / n, 1 / n, grid, inside);
        for (size_t x = 0; x < grid; x++) {
            double d = f.distance[y * grid + x];
            out[y * grid + x] = sdf_code(inside[x] ? d : -d, range);
        }
    }
    free(f.distance);
    free(inside);
}
