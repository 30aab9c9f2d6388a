/* SPDX-License-Identifier: Apache-2.0 */
/* Angles, ranges and codes out of + - * / and square roots, which are the same on every machine. */
#include <math.h>

#include "umbrella_private.h"

static const double tau = 6.283185307179586;

/* Both series for an angle of at most an eighth of a turn; what is left out is below 2^-53. */
static void small_turn(double angle, double *cosine, double *sine) {
    double square = angle * angle, c = 1, s = 1;
    for (int i = 18; i > 0; i -= 2) {
        c = 1 - c * square / (i * (i - 1));
        s = 1 - s * square / (i * (i + 1));
    }
    *cosine = c;
    *sine = s * angle;
}

void umb_turn(double turns, double *cosine, double *sine) {
    double t = turns - floor(turns), quarter = floor(t * 4 + 0.5), c, s;
    small_turn((t - quarter / 4) * tau, &c, &s);
    int q = (int)quarter & 3;
    *cosine = q == 0 ? c : q == 1 ? -s : q == 2 ? -c : s;
    *sine = q == 0 ? s : q == 1 ? c : q == 2 ? -s : -c;
}

double umb_arc(double cosine) {
    double low = 0, high = 0.25;
    for (int i = 0; i < 52; i++) {
        double middle = (low + high) / 2, c, s;
        umb_turn(middle, &c, &s);
        if (c > cosine)
            low = middle;
        else
            high = middle;
    }
    return (low + high) / 2;
}

double umb_range(author_random *random, author_range range) {
    return range.low + (range.high - range.low) * author_random_unit(random);
}

double umb_signed(author_random *random) {
    return 2 * author_random_unit(random) - 1;
}

int64_t umb_round(double value) {
    return (int64_t)floor(value + 0.5);
}

uint8_t umb_offset_code(double offset) {
    double size = sqrt(fabs(offset)) * 127;
    int code = (int)umb_round(size > 127 ? 127 : size);
    return (uint8_t)(int8_t)(offset < 0 ? -code : code);
}

double umb_offset(uint8_t code) {
    int q = (int8_t)code < -127 ? -127 : (int8_t)code;
    return (double)(q * (q < 0 ? -q : q)) / (127.0 * 127.0);
}

uint8_t umb_colour_code(double value) {
    return (uint8_t)(value <= 0 ? 0 : value >= 1 ? 255 : umb_round(sqrt(value) * 255));
}
