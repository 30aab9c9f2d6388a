/* SPDX-License-Identifier: Apache-2.0 */
/* Between the files that make umbrella textures. */
#ifndef ZTEX_UMBRELLA_PRIVATE_H
#define ZTEX_UMBRELLA_PRIVATE_H

#include "author_umbrella.h"

static inline double umb_cross(author_xy a, author_xy b) {
    return a.x * b.y - a.y * b.x;
}

static inline author_xy umb_less(author_xy a, author_xy b) {
    return (author_xy){a.x - b.x, a.y - b.y};
}

static inline author_xy umb_mix(author_xy a, author_xy b, double t) {
    return (author_xy){a.x + t * (b.x - a.x), a.y + t * (b.y - a.y)};
}

/* umbrella_number.c: what libm does not do alike on all machines. */
void umb_turn(double turns, double *cosine, double *sine);
double umb_arc(double cosine); /* 0 to 1: the angle whose cosine it is, in turns: 1/4 to 0 */
double umb_range(author_random *random, author_range range);
double umb_signed(author_random *random); /* -1 to 1 */
int64_t umb_round(double value);
uint8_t umb_offset_code(double offset); /* a colour offset as the file has it */
double umb_offset(uint8_t code);
uint8_t umb_colour_code(double value); /* a colour of form 2 */

/* umbrella_shape.c: how far the ray from the centre through direction d gets before it leaves the outline for good, in
 * lengths of d. */
double umb_farthest(const author_outline *outline, author_xy centre, author_xy d);

/* umbrella_cut.c: pictures of bases. */
/* Texels x0 .. x0 + width etc. of the picture, of which parts may lie outside, averaged over factor x factor, as 4
 * channels; colours go on where alpha is 0. coverage NULL: the picture's alpha, or 1. */
typedef struct umb_cut {
    int64_t x0, y0;
    uint32_t width, height, factor; /* width and height after the reduction */
} umb_cut;
author_result umb_cut_out(author_run *run, const author_picture *picture, const author_picture *coverage,
                          const umb_cut *cut, author_picture *out);
/* The colour around a place (texels), weighted by a raised cosine and by alpha; 0 if there is nothing. */
int umb_local_mean(const author_picture *picture, const author_picture *coverage, author_xy place, double radius,
                   double mean[3]);
/* umbrella_variant.c: the colours of all variants. vertices are those of the base, in texels of its picture. */
author_result umb_variants(author_run *run, const author_base_input *input, const author_picture *coverage,
                           const author_outline *outline, author_xy centre, author_base *base);
/* umbrella_base.c: alpha or key. */
author_result umb_coverage(author_run *run, const author_picture *picture, const author_base_input *input,
                           author_picture *coverage);

/* umbrella_polygon.c: umbrellas as they lie in their level. */
/* Vertices of an umbrella relative to its centre, in cells of its level; out has room for AUTHOR_VERTICES. Returns
 * their number. */
size_t umb_polygon(const zt_umbrella_info *info, const zt_umbrella *umbrella, uint32_t bits, author_xy *out);
/* The file's integers: star-shaped as in rule 8307? d are vertices less centre. Returns the first bad one, or count. */
size_t umb_bad_offset(const zt_umbrella_offset *d, size_t count);
double umb_radius(const author_xy *polygon, size_t count);
/* Is the point inside of a star-shaped polygon around the origin? */
int umb_covers(const author_xy *polygon, size_t count, author_xy p);

/* umbrella_arrange.c: the view shows what the arrays hold. */
void umb_show(author_umbrellas *umbrellas);

/* umbrella_phases.c: */
/* shown: what stands for this float of wanted. */
void umb_add_error(author_phase_errors *errors, const author_picture *wanted, size_t texel, double shown);
double umb_decibel(double squares, size_t count); /* infinite without errors */

/* umbrella_lists.c: the lists of one level, whose umbrellas begin at info->levels[level].first_umbrella. starts has
 * room for cells + 1, and counts from 0; *entries is malloc'd. */
author_result umb_lists(author_run *run, const zt_umbrella_info *info, uint32_t level, const int repeat[2],
                        uint32_t *starts, uint32_t **entries, uint32_t *longest);

#endif
