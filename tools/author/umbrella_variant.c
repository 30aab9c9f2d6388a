/* SPDX-License-Identifier: Apache-2.0 */
/* Colour variants: by how much a similar element differs from the base, near each vertex; or tints. */
#include <math.h>
#include <stdlib.h>

#include "umbrella_private.h"

#define INWARD 0.75      /* colours are taken so far from the centre to a vertex */
#define SPOT 0.25        /* over this part of that distance */
#define CENTRE_SPOT 0.35 /* of the mean distance */

/* A picture with the outline of what it shows. */
typedef struct element {
    const author_picture *picture, *coverage;
    const author_outline *outline;
    author_xy centre;
} element;

/* Around the centre (index 0) or near the vertex in direction d. */
static int spot_mean(const element *e, size_t index, author_xy d, double mean_radius, double mean[3]) {
    if (index == 0)
        return umb_local_mean(e->picture, e->coverage, e->centre, CENTRE_SPOT * mean_radius, mean);
    double far = umb_farthest(e->outline, e->centre, d), length = far * sqrt(d.x * d.x + d.y * d.y);
    author_xy place = {e->centre.x + INWARD * far * d.x, e->centre.y + INWARD * far * d.y};
    return umb_local_mean(e->picture, e->coverage, place, SPOT * length, mean);
}

static double mean_radius_of(const element *e) {
    double sum = 0;
    for (size_t i = 0; i < e->outline->count; i++) {
        author_xy d = umb_less(e->outline->points[i], e->centre);
        sum += sqrt(d.x * d.x + d.y * d.y);
    }
    return sum / (double)e->outline->count;
}

static void set_colour(zt_umbrella_colour *to, const double offset[3]) {
    *to = (zt_umbrella_colour){umb_offset_code(offset[0]), umb_offset_code(offset[1]), umb_offset_code(offset[2]), 0};
}

static void compare(const element *base, const element *other, zt_umbrella_colour *colours) {
    double own_radius = mean_radius_of(base), radius = mean_radius_of(other), own[3], its[3], offset[3];
    for (size_t i = 0; i <= base->outline->count; i++) {
        author_xy d = i ? umb_less(base->outline->points[i - 1], base->centre) : (author_xy){0, 0};
        int both = spot_mean(base, i, d, own_radius, own) && spot_mean(other, i, d, radius, its);
        for (int c = 0; c < 3; c++)
            offset[c] = both ? its[c] - own[c] : 0;
        set_colour(&colours[i], offset);
    }
}

static author_result by_picture(author_run *run, const author_base_input *input, const author_variant *variant,
                                const element *base, zt_umbrella_colour *colours) {
    author_picture coverage;
    author_outline outline = {0};
    element other = {.picture = variant->picture, .coverage = &coverage, .outline = &outline};
    author_result result = umb_coverage(run, variant->picture, input, &coverage);
    if (result == AUTHOR_OK)
        result = author_umbrella_trace(run, &coverage, input->threshold > 0 ? input->threshold : 0.1, &outline);
    if (result == AUTHOR_OK) {
        other.centre = author_outline_centroid(&outline);
        compare(base, &other, colours);
    }
    author_outline_release(&outline);
    author_picture_release(&coverage);
    return result;
}

static void by_tint(const author_variant *variant, const float mean[3], size_t count, author_random *random,
                    zt_umbrella_colour *colours) {
    double offset[3];
    for (size_t i = 0; i <= count; i++) {
        double spread = variant->spread * umb_signed(random);
        for (int c = 0; c < 3; c++) {
            double colour = (double)(i ? variant->rim : variant->centre)[c];
            offset[c] = (variant->offsets ? colour : colour - (double)mean[c]) + spread;
        }
        set_colour(&colours[i], offset);
    }
}

author_result umb_variants(author_run *run, const author_base_input *input, const author_picture *coverage,
                           const author_outline *outline, author_xy centre, author_base *base) {
    size_t count = outline->count;
    element self = {input->picture, coverage, outline, centre};
    author_random random;
    base->colours = author_alloc(run, (count + 1) * input->variant_count + 1, sizeof *base->colours);
    base->record.variant_count = (uint8_t)input->variant_count;
    author_random_seed(&random, input->seed, input->stream + 1);
    author_result result = base->colours ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (uint32_t v = 0; result == AUTHOR_OK && v < input->variant_count; v++) {
        const author_variant *variant = &input->variants[v];
        zt_umbrella_colour *colours = base->colours + v * (count + 1);
        if (variant->picture && !input->picture)
            return author_fail(run, AUTHOR_BAD_INPUT, "a base that shows a texture takes tints, no reference pictures");
        if (variant->picture)
            result = by_picture(run, input, variant, &self, colours);
        else
            by_tint(variant, base->mean, count, &random, colours);
    }
    return result;
}
