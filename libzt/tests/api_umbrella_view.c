/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: what pictures of umbrellas show. A vertex has its own colour, and colours do not jump where sectors or
 * cells meet, where the texture repeats, or while it shrinks; shadows lie below umbrellas only; umbrellas show other
 * textures and are shown by them, within the limits; and no coordinate does harm.
 */
#include "umbrella_reference.h"

enum { STEPS = 2000 };

static void look_up(const zt_sampler *sampler, const zt_point *p, float rgba[4]) {
    zt_diag diag;
    must(zt_sample(sampler, p, 1, rgba, &diag), &diag);
}

static double difference(const float a[4], const float b[4]) {
    double most = 0;
    for (int c = 0; c < 4; c++)
        most = fmax(most, fabs((double)a[c] - (double)b[c]));
    return most;
}

static const stage_setup plain = {
    .grid_x = 4, .grid_y = 4, .levels = 2, .umbrellas = 24, .corners = 9, .below = ZT_BACKGROUND_IMAGE};

/* ---- colours ---- */

/* One umbrella of form 2, in both modes: at each vertex, and at the centre, the colour that is stored there; and the
 * way from one sector to the next is smooth. */
static void check_vertices(zt_umbrella_colour_mode mode) {
    stage_setup t = plain;
    t.umbrellas = t.levels = 1;
    t.forms = 4;
    t.mode = mode;
    stage s = stage_make(&t, 21);
    zt_file *file = stage_open(&s);
    zt_sampler *sampler = stage_sampler(file, STAGE_UMBRELLAS, NULL);
    double x = s.umbrellas[0].x / 65536.0, y = s.umbrellas[0].y / 65536.0;
    for (uint32_t i = 0; i <= t.corners; i++) {
        double dx = i ? s.offsets[i - 1].x / 4096.0 : 0, dy = i ? s.offsets[i - 1].y / 4096.0 : 0;
        zt_point p = {.u = (x + dx * (1 - 1e-9)) / 4, .v = (y + dy * (1 - 1e-9)) / 4};
        float rgba[4], want[4] = {0, 0, 0, 1};
        for (int c = 0; c < 3; c++)
            want[c] = (float)channel_of(&s.colours[i], c, false);
        look_up(sampler, &p, rgba);
        CHECK(difference(rgba, want) < 1e-5);
        for (int k = 1; k < 20 && i > 0; k++) { /* the ray to the vertex, from both sides */
            zt_point side = {.u = (x + dx * k / 20 - 1e-7 * dy) / 4, .v = (y + dy * k / 20 + 1e-7 * dx) / 4};
            look_up(sampler, &side, want);
            side.u = (x + dx * k / 20 + 1e-7 * dy) / 4;
            side.v = (y + dy * k / 20 - 1e-7 * dx) / 4;
            look_up(sampler, &side, rgba);
            CHECK(difference(rgba, want) < 1e-5);
        }
    }
    zt_sampler_close(sampler);
    zt_close(file);
    stage_free(&s);
}

/* ---- no seams ---- */

/* Both sides of the sides of cells, of every level, and of the texture's own, which repeats; and a pixel that grows
 * over all levels: the steps are small, and so are the changes. */
static void check_smooth(void) {
    stage s = stage_make(&plain, 22);
    zt_file *file = stage_open(&s);
    zt_sampler *sampler = stage_sampler(file, STAGE_UMBRELLAS, NULL);
    float before[4], rgba[4];
    uint64_t seed = 1;
    for (int i = 0; i < STEPS; i++) {
        double side = test_below(&seed, 5) / 4.0, along = test_uniform(&seed, 0, 1), rho = test_uniform(&seed, 0, 0.2);
        bool upright = i % 2;
        zt_point p = {.u = side - 1e-9, .v = along, .du_dx = rho, .dv_dy = rho};
        zt_point q = {.u = side + 1e-9, .v = along, .du_dx = rho, .dv_dy = rho};
        if (upright) {
            p.v = p.u, p.u = along;
            q.v = q.u, q.u = along;
        }
        look_up(sampler, &p, before);
        look_up(sampler, &q, rgba);
        CHECK(difference(before, rgba) < 1e-5);
        q.u += upright ? 3 : -1;
        q.v -= 2;
        look_up(sampler, &q, rgba);
        CHECK(difference(before, rgba) < 1e-5);
    }
    for (int place = 0; place < 20; place++) {
        double u = test_uniform(&seed, 0, 1), v = test_uniform(&seed, 0, 1);
        for (int i = 0; i <= STEPS; i++) { /* from 1/64 of a cell to 2 cells */
            double rho = ldexp(1, -6) * pow(128, (double)i / STEPS) / 4;
            zt_point p = {.u = u, .v = v, .du_dx = rho, .dv_dy = rho};
            look_up(sampler, &p, rgba);
            CHECK(i == 0 || difference(before, rgba) < 0.02);
            memcpy(before, rgba, sizeof before);
        }
        for (int c = 0; c < 4; c++)
            CHECK(rgba[c] == s.info.mean[c]);
    }
    zt_sampler_close(sampler);
    zt_close(file);
    stage_free(&s);
}

/* ---- shadows ---- */

/* One umbrella: the ground is darker exactly where the umbrella is on the way to the light, and the umbrella itself
 * nowhere. */
static void check_shadows(void) {
    stage_setup t = plain;
    t.umbrellas = t.levels = 1;
    t.forms = 4;
    stage s = stage_make(&t, 23);
    zt_file *file = stage_open(&s);
    zt_sampler_options o = {.light_x = 0.35, .light_y = -0.2, .shadow = 0.5};
    zt_sampler *lit = stage_sampler(file, STAGE_UMBRELLAS, NULL), *dark = stage_sampler(file, STAGE_UMBRELLAS, &o);
    reference r = reference_open(file, &t, &o, false);
    pixel none = {{0, 0}, {0, 0}};
    uint64_t seed = 1;
    int darker = 0, own = 0;
    for (int i = 0; i < STEPS; i++) {
        zt_point p = {.u = test_uniform(&seed, 0, 1), .v = test_uniform(&seed, 0, 1)};
        const zt_umbrella *u = &s.umbrellas[0];
        double covered_here = 0, covered_there = 0;
        for (int k = 0; k < 9; k++) { /* it repeats */
            vec q = {4 * p.u - u->x / 65536.0 + 4 * (k % 3 - 1), 4 * p.v - u->y / 65536.0 + 4 * (k / 3 - 1)};
            vec there = {q.x + o.light_x, q.y + o.light_y};
            covered_here += reference_umbrella(&r, 12, 0, q, &none, &none, NULL);
            covered_there += reference_umbrella(&r, 12, 0, there, &none, &none, NULL);
        }
        double factor = covered_here == 0 && covered_there > 0 ? 0.5 : 1;
        float a[4], b[4];
        look_up(lit, &p, a);
        look_up(dark, &p, b);
        for (int c = 0; c < 4; c++)
            CHECK(fabs((double)b[c] - (double)a[c] * (c < 3 ? factor : 1)) < 1e-6);
        darker += factor < 1;
        own += covered_here > 0 && covered_there > 0;
    }
    CHECK(darker > 20 && own > 20);
    reference_close(&r);
    zt_sampler_close(dark);
    zt_sampler_close(lit);
    zt_close(file);
    stage_free(&s);
}

/* ---- textures that show textures ---- */

enum { PATCH = STAGE_UMBRELLAS + 1, NESTED };

/* Behind the stage: a zipmap with a patch that shows the umbrellas, and umbrellas whose bases and background show the
 * zipmap. */
static stage make_nested(uint64_t seed) {
    stage_setup t = plain;
    t.below = ZT_BACKGROUND_TEXTURE;
    stage s = {.setup = t};
    zt_sink sink = memory_sink_of(&s.bytes);
    zt_writer *w;
    zt_layer_desc layer = {ZT_SEMANTIC_BASE_COLOUR, 0};
    zt_texture_desc desc = {.wrap_u = t.wrap_u, .wrap_v = t.wrap_v, .layers = &layer, .layer_count = 1};
    uint32_t sources[2] = {0, STAGE_UMBRELLAS};
    zt_patch_desc patches[2] = {
        {.sources = &sources[0], .mask = ZT_NONE, .matrix = {1, 0, 0, 0, 1, 0, 0, 0, 1}},
        {.shows_texture = 1, .sources = &sources[1], .mask = ZT_NONE, .matrix = {2, 0, -0.5, 0, 2, -0.5, 0, 0, 1}}};
    zt_texture_desc clamped = desc;
    zt_diag diag;
    clamped.wrap_u = clamped.wrap_v = ZT_WRAP_CLAMP;
    must(zt_writer_open_sink(&sink, NULL, &diag, &w), &diag);
    stage_write(&s, w, &seed);
    must(zt_writer_add_zipmap(w, &clamped, patches, 2, &diag, NULL), &diag);
    for (uint32_t i = 0; i < STAGE_BASES; i++) {
        s.bases[i].shows_texture = 1;
        s.bases[i].source = PATCH;
    }
    s.info.background_source = PATCH;
    must(zt_writer_add_umbrellas(w, &desc, &s.info, &diag, NULL), &diag);
    must(zt_writer_finish(w, &diag), &diag);
    zt_writer_close(w);
    return s;
}

/* Inside of the patch it is the umbrellas as far as they cover, clamped and without shadows, and the root behind. */
static void check_patch(const zt_file *file, const stage_setup *t) {
    zt_sampler_options lit = {.light_x = 0.3, .light_y = 0.1, .shadow = 1}, none = {0};
    zt_sampler *patch = stage_sampler(file, PATCH, &lit), *root = stage_sampler(file, 0, NULL);
    reference r = reference_open(file, t, &none, true);
    uint64_t seed = 2;
    for (int i = 0; i < 400; i++) {
        zt_point p = {.u = test_uniform(&seed, 0.25, 0.75), .v = test_uniform(&seed, 0.25, 0.75)};
        p.du_dx = p.dv_dy = test_uniform(&seed, 0, 0.1);
        zt_point inner = {.u = 2 * p.u - 0.5, .v = 2 * p.v - 0.5, .du_dx = 2 * p.du_dx, .dv_dy = 2 * p.dv_dy};
        float got[4], below[4];
        double want[4];
        look_up(patch, &p, got);
        look_up(root, &p, below);
        reference_lookup(&r, &inner, want);
        for (int c = 0; c < 4; c++)
            CHECK(fabs((double)got[c] - (want[c] + (1 - want[3]) * (double)below[c])) < 4e-6);
    }
    reference_close(&r);
    zt_sampler_close(root);
    zt_sampler_close(patch);
}

/* The umbrellas again, whose pictures are now all of that. */
static void check_bases(const zt_file *file, const stage_setup *t) {
    zt_sampler_options none = {0};
    zt_sampler *nested = stage_sampler(file, NESTED, NULL), *patch = stage_sampler(file, PATCH, NULL);
    reference r = reference_open(file, t, &none, false);
    zt_sampler *own[STAGE_BASES];
    uint64_t seed = 3;
    CHECK(zt_get_umbrellas(file, NESTED, &r.info) == ZT_OK);
    for (int i = 0; i < STAGE_BASES; i++) {
        own[i] = r.pictures[i];
        r.pictures[i] = patch;
    }
    for (int i = 0; i < 400; i++) {
        zt_point p = {.u = test_uniform(&seed, -1, 2), .v = test_uniform(&seed, -1, 2)};
        p.du_dx = p.dv_dy = test_uniform(&seed, 0, 0.03);
        float got[4];
        double want[4], below[4], rest[4];
        look_up(nested, &p, got);
        /* What is behind is the zipmap, not the image that the reference takes: known by what a black ground leaves
         * out. */
        zt_point at = {.u = p.u - floor(p.u), .v = p.v - floor(p.v), .du_dx = p.du_dx, .dv_dy = p.dv_dy};
        look(patch, &at, below);
        r.info.background_kind = ZT_BACKGROUND_COLOUR;
        for (int c = 0; c < 4; c++)
            r.info.background[c] = 0;
        reference_lookup(&r, &p, want);
        for (int c = 0; c < 4; c++)
            r.info.background[c] = 1;
        reference_lookup(&r, &p, rest);
        for (int c = 0; c < 4; c++)
            CHECK(fabs((double)got[c] - (want[c] + ((double)rest[c] - want[c]) * below[c])) < 8e-6);
    }
    for (int i = 0; i < STAGE_BASES; i++)
        r.pictures[i] = own[i];
    reference_close(&r);
    zt_sampler_close(patch);
    zt_sampler_close(nested);
}

/* NESTED shows PATCH shows UMBRELLAS shows a picture: three deep. */
static void check_limits(const stage *s) {
    zt_point p = {.u = 0.4, .v = 0.4};
    for (uint32_t depth = 1; depth <= 3; depth++) {
        zt_limits limits = {.texture_depth = depth};
        zt_open_options options = {.limits = &limits};
        zt_file *file;
        zt_sampler *sampler;
        zt_diag diag;
        must(zt_open_memory(s->bytes.data, s->bytes.size, &options, &diag, &file), &diag);
        zt_result result = zt_sampler_open(file, NESTED, NULL, &diag, &sampler);
        CHECK(result == (depth < 3 ? ZT_LIMIT : ZT_OK) && (result == ZT_OK || diag.rule == 1011));
        zt_sampler_close(sampler);
        zt_close(file);
    }
    zt_limits limits = {.shown_textures = 1};
    zt_open_options options = {.limits = &limits};
    zt_file *file;
    zt_diag diag;
    float rgba[4];
    int refused = 0;
    must(zt_open_memory(s->bytes.data, s->bytes.size, &options, &diag, &file), &diag);
    zt_sampler *sampler = stage_sampler(file, NESTED, NULL);
    for (int i = 0; i < 20; i++) {
        p.u = i / 20.0;
        zt_result result = zt_sample(sampler, &p, 1, rgba, &diag);
        CHECK(result == ZT_OK || (result == ZT_LIMIT && diag.rule == 1012));
        refused += result == ZT_LIMIT;
    }
    CHECK(refused > 0);
    zt_sampler_close(sampler);
    zt_close(file);
}

static void check_composition(void) {
    stage s = make_nested(31);
    zt_file *file = stage_open(&s);
    check_patch(file, &s.setup);
    check_bases(file, &s.setup);
    check_limits(&s);
    zt_close(file);
    stage_free(&s);
}

/* ---- arguments, and any number ---- */

static void check_arguments(void) {
    stage s = stage_make(&plain, 41);
    zt_file *file = stage_open(&s);
    static const zt_sampler_options wrong[] = {{.shadow = -0.1},
                                               {.shadow = 1.1},
                                               {.shadow = (double)NAN},
                                               {.light_x = (double)NAN},
                                               {.light_y = (double)INFINITY}};
    zt_ray ray = {0};
    zt_hit hit;
    zt_sampler *sampler;
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        CHECK(zt_sampler_open(file, STAGE_UMBRELLAS, &wrong[i], NULL, &sampler) == ZT_BAD_ARGUMENT);
    sampler = stage_sampler(file, 0, NULL);
    CHECK(zt_sample_rays(sampler, &ray, 1, &hit, NULL) == ZT_BAD_ARGUMENT);
    zt_sampler_close(sampler);
    sampler = stage_sampler(file, STAGE_UMBRELLAS, NULL);
    CHECK(zt_sample_rays(sampler, NULL, 1, &hit, NULL) == ZT_BAD_ARGUMENT);
    CHECK(zt_sample_rays(sampler, &ray, 1, NULL, NULL) == ZT_BAD_ARGUMENT);
    CHECK(zt_sample_rays(NULL, &ray, 1, &hit, NULL) == ZT_BAD_ARGUMENT);
    CHECK(zt_sample_rays(sampler, NULL, 0, NULL, NULL) == ZT_OK);
    zt_sampler_close(sampler);
    zt_close(file);
    stage_free(&s);
}

static void check_any_number(zt_wrap wrap_u, zt_wrap wrap_v) {
    static const double wild[] = {
        0,     -0.0,   1,           1e-320,           -1e-320,          1e-20, -1e-17, 1e9, -1e15,
        1e300, -1e308, (double)NAN, (double)INFINITY, -(double)INFINITY};
    enum { WILD = sizeof wild / sizeof wild[0] };
    stage_setup t = plain;
    t.wrap_u = wrap_u;
    t.wrap_v = wrap_v;
    stage s = stage_make(&t, 51);
    zt_file *file = stage_open(&s);
    zt_sampler_options o = {.light_x = 1e300, .light_y = -0.2, .shadow = 1};
    zt_sampler *sampler = stage_sampler(file, STAGE_UMBRELLAS, &o);
    uint64_t seed = 4;
    for (int i = 0; i < STEPS; i++) {
        double v[6];
        bool finite = true;
        for (int k = 0; k < 6; k++) {
            v[k] = test_below(&seed, 3) == 0 ? wild[test_below(&seed, WILD)] : test_uniform(&seed, -2, 2);
            finite = finite && isfinite(v[k]);
        }
        zt_point p = {.u = v[0], .v = v[1], .du_dx = v[2], .dv_dx = v[3], .du_dy = v[4], .dv_dy = v[5]};
        float rgba[4];
        look_up(sampler, &p, rgba);
        for (int c = 0; c < 4; c++) {
            CHECK(rgba[c] >= 0 && rgba[c] <= 1);
            CHECK(finite || rgba[c] == 0);
        }
    }
    zt_sampler_close(sampler);
    zt_close(file);
    stage_free(&s);
}

int main(void) {
    check_vertices(ZT_UMBRELLA_BARYCENTRIC);
    check_vertices(ZT_UMBRELLA_INVERSE_DISTANCE);
    check_smooth();
    check_shadows();
    check_composition();
    check_arguments();
    check_any_number(ZT_WRAP_REPEAT, ZT_WRAP_MIRROR);
    check_any_number(ZT_WRAP_CLAMP, ZT_WRAP_BORDER);
    return test_end();
}
