/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: a lookup in umbrellas is what spec/umbrella.md sections 3 and 4 say, for every form, colour mode, wrap
 * mode, filter, background and light: a slow reference that asks every sector agrees.
 */
#include "umbrella_reference.h"

enum { POINTS = 250 };

static zt_point random_point(const stage_setup *t, uint64_t *seed) {
    zt_point p = {.u = test_uniform(seed, -1.3, 2.3), .v = test_uniform(seed, -1.3, 2.3)};
    if (test_below(seed, 5) == 0) /* on a side, or a corner */
        p.u = (double)test_below(seed, t->grid_x + 1) / t->grid_x;
    if (test_below(seed, 5) == 0)
        p.v = (double)test_below(seed, t->grid_y + 1) / t->grid_y;
    double scale = ldexp(1, 1 - (int)test_below(seed, 12));
    if (test_below(seed, 5) == 0)
        return p;
    p.du_dx = scale * test_uniform(seed, -1, 1) / t->grid_x;
    p.dv_dx = scale * test_uniform(seed, -1, 1) / t->grid_y;
    p.du_dy = scale * test_uniform(seed, -1, 1) / t->grid_x;
    p.dv_dy = scale * test_uniform(seed, -1, 1) / t->grid_y;
    return p;
}

static void compare(const stage_setup *setup, const zt_sampler_options *options, uint64_t seed) {
    static zt_point points[POINTS];
    static float got[4 * POINTS];
    stage s = stage_make(setup, seed);
    zt_file *file = stage_open(&s);
    zt_sampler *sampler = stage_sampler(file, STAGE_UMBRELLAS, options);
    reference r = reference_open(file, setup, options, false);
    zt_diag diag;
    for (int i = 0; i < POINTS; i++)
        points[i] = random_point(setup, &seed);
    must(zt_sample(sampler, points, POINTS, got, &diag), &diag);
    for (int i = 0; i < POINTS; i++) {
        double want[4];
        float once[4];
        reference_lookup(&r, &points[i], want);
        for (int c = 0; c < 4; c++)
            CHECK(fabs((double)got[4 * i + c] - want[c]) < 2e-6);
        /* Many points at once are as many calls. */
        must(zt_sample(sampler, &points[i], 1, once, &diag), &diag);
        CHECK(memcmp(once, got + 4 * i, sizeof once) == 0);
    }
    reference_close(&r);
    zt_sampler_close(sampler);
    zt_close(file);
    stage_free(&s);
}

int main(void) {
    static const uint32_t grids[][2] = {{5, 7}, {1, 1}, {8, 3}, {2, 9}};
    static const zt_wrap wraps[][2] = {{ZT_WRAP_REPEAT, ZT_WRAP_REPEAT},
                                       {ZT_WRAP_CLAMP, ZT_WRAP_REPEAT},
                                       {ZT_WRAP_MIRROR, ZT_WRAP_BORDER},
                                       {ZT_WRAP_REPEAT, ZT_WRAP_CLAMP},
                                       {ZT_WRAP_BORDER, ZT_WRAP_MIRROR}};
    static const uint32_t corners[] = {3, 4, 7, 12, 31, 80};
    for (uint32_t n = 0; n < 150; n++) {
        const uint32_t *grid = grids[n % 4];
        stage_setup t = {.grid_x = grid[0],
                         .grid_y = grid[1],
                         .levels = grid[0] == 1 ? 1 : 1 + n % 3,
                         .umbrellas = 1 + n % 40,
                         .corners = corners[n / 2 % 6],
                         .wrap_u = wraps[n / 5 % 5][0],
                         .wrap_v = wraps[n / 5 % 5][1],
                         .mode = (zt_umbrella_colour_mode)(n / 3 % 2),
                         .below = (zt_background_kind)(n / 7 % 3),
                         .opaque = n % 8 == 1,
                         .textures = n % 8 == 3};
        zt_sampler_options o = {.filter = (zt_filter)(n % 5 == 3 ? 1 : n % 5 == 4 ? 2 : 0)};
        if (n % 4 == 2) {
            o.shadow = n % 8 == 2 ? 1 : 0.6;
            o.light_x = 0.4;
            o.light_y = -0.3;
        }
        if (o.filter == ZT_FILTER_TRILINEAR && n % 6 == 0)
            o.max_anisotropy = 4;
        compare(&t, &o, 0x5EED + n);
    }
    return test_end();
}
