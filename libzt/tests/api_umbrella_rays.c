/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: a ray through a prism of umbrellas hits what spec/umbrella.md sections 5 and 6 say: a slow reference agrees
 * that cuts the ray at every side of a cell. And what a picture shows of it: where heights have been tapered away it is
 * the lookup in 2-D, a ray straight down meets the umbrella that lies on top, a dome's top is as high as the file says,
 * outlines are not those of the ground, and no number of a ray does harm.
 */
#include "umbrella_reference.h"

enum { RAYS = 300, MOST_CUTS = 4096 };

/* ---- the reference ---- */

typedef struct vec3 {
    double x, y, z;
} vec3;

typedef struct found {
    double s, t;
    vec3 normal;
    double rgba[4];
    uint32_t entry;
    vec ground;
} found;

/* Heights of an umbrella, in cells. */
typedef struct dome {
    zt_umbrella_ellipsoid kind;
    double e, k, lift, radius;
} dome;

static dome dome_of(const reference *r, const zt_umbrella *u) {
    const zt_umbrella_base *b = &r->info.bases[u->base];
    bool as_base = u->ellipsoid == ZT_ELLIPSOID_OF_BASE;
    double h = (double)r->info.prism_height;
    dome d = {.kind = (zt_umbrella_ellipsoid)(as_base ? b->ellipsoid : u->ellipsoid),
              .e = (as_base ? b->height : u->height) / 65535.0 * h,
              .k = ((as_base ? b->curvature : u->curvature) + 1) / 65536.0,
              .lift = u->lift / 65535.0 * h};
    star s = star_of(&r->info, r->info.levels[0].bits, u);
    double scale = u->form == ZT_UMBRELLA_PARAMETRIC ? hypot(u->a, u->b) / 65536 : 1;
    for (uint32_t i = 0; i < s.count; i++)
        d.radius = fmax(d.radius, scale * hypot(s.d[i].x, s.d[i].y));
    free(s.d);
    if (d.e == 0)
        d.kind = ZT_ELLIPSOID_FLAT;
    return d;
}

static vec3 point_on(vec3 a, vec3 b, double s) {
    vec3 p = {a.x + s * (b.x - a.x), a.y + s * (b.y - a.y), a.z + s * (b.z - a.z)};
    return p;
}

/* Where the segment from a to b (relative to the umbrella's centre and lift) meets the surface. */
static int meetings(const dome *d, vec3 a, vec3 b, double out[2]) {
    if (d->kind == ZT_ELLIPSOID_FLAT) {
        out[0] = a.z / (a.z - b.z);
        return a.z != b.z;
    }
    double c = d->e / d->k, z0 = d->e - c, wide = d->radius / sqrt(d->k * (2 - d->k));
    /* f(s) = (x^2 + y^2) / A^2 + ((z - z0) / c)^2 - 1 is a parabola through these three. */
    double f[3];
    for (int i = 0; i < 3; i++) {
        vec3 p = point_on(a, b, i / 2.0);
        double z = d->kind == ZT_ELLIPSOID_CONCAVE ? d->e - p.z : p.z;
        f[i] = (p.x * p.x + p.y * p.y) / (wide * wide) + (z - z0) * (z - z0) / (c * c) - 1;
    }
    double p2 = 2 * f[0] - 4 * f[1] + 2 * f[2], p1 = -3 * f[0] + 4 * f[1] - f[2], square = p1 * p1 - 4 * p2 * f[0];
    if (square < 0)
        return 0;
    out[0] = (-p1 - sqrt(square)) / (2 * p2);
    out[1] = (-p1 + sqrt(square)) / (2 * p2);
    return 2;
}

/* What stays the same in a cell. */
typedef struct cell_piece {
    vec3 a, b;
    double tau_a, tau_b, t_a, t_b, rho_a, rho_b;
} cell_piece;

static bool is_hit(const reference *r, uint32_t number, const dome *d, const cell_piece *c, vec3 p, double s,
                   double rgba[4]) {
    vec q = {p.x, p.y};
    double length = hypot(p.x, p.y), tau = c->tau_a + s * (c->tau_b - c->tau_a);
    double rho = c->rho_a + s * (c->rho_b - c->rho_a);
    pixel none = {{0, 0}, {0, 0}}, square = {{rho, 0}, {0, rho}};
    if (d->kind != ZT_ELLIPSOID_FLAT) {
        double z = d->kind == ZT_ELLIPSOID_CONCAVE ? d->e - p.z : p.z, depth = d->e / d->k;
        if (z < 0)
            return false;
        double share = acos(clamped_to((z - d->e + depth) / depth, -1, 1)) / acos(1 - d->k);
        double wanted = (1 - tau) * length + tau * d->radius * share;
        q = (vec){p.x / length * wanted, p.y / length * wanted};
    }
    return reference_umbrella(r, r->info.levels[0].bits, number, q, &none, &square, rgba) * rgba[3] >= 0.5;
}

static vec3 normal_of(const dome *d, vec3 p, vec3 way) {
    vec3 n = {0, 0, 1};
    if (d->kind != ZT_ELLIPSOID_FLAT) {
        bool bowl = d->kind == ZT_ELLIPSOID_CONCAVE;
        double c = d->e / d->k, wide = d->radius / sqrt(d->k * (2 - d->k)), z = bowl ? d->e - p.z : p.z;
        n = (vec3){p.x / (wide * wide), p.y / (wide * wide), (bowl ? -1 : 1) * (z - (d->e - c)) / (c * c)};
    }
    double length = sqrt(n.x * n.x + n.y * n.y + n.z * n.z);
    if (n.x * way.x + n.y * way.y + n.z * way.z > 0)
        length = -length;
    return (vec3){n.x / length, n.y / length, n.z / length};
}

/* Step 3: the segment is brought into the cell of the unit square. */
static bool nearest(const reference *r, const cell_piece *c, uint32_t x, uint32_t y, found *out) {
    const zt_umbrella_level *l = &r->info.levels[0];
    vec home = {x, y};
    const uint32_t *list;
    uint32_t count = reference_list(r, l, home, &list);
    *out = (found){.s = HUGE_VAL};
    while (count-- > 0) {
        uint32_t number = list[count] & ZT_UMBRELLA_ENTRY;
        vec a = less_centre(r, l, list[count], (vec){c->a.x, c->a.y});
        vec b = less_centre(r, l, list[count], (vec){c->b.x, c->b.y});
        dome d = dome_of(r, &r->info.umbrellas[number]);
        vec3 from = {a.x, a.y, c->a.z - d.lift}, to = {b.x, b.y, c->b.z - d.lift};
        double s[2], rgba[4];
        int n = meetings(&d, from, to, s);
        for (int i = 0; i < n; i++) {
            vec3 p = point_on(from, to, s[i]);
            if (!(s[i] >= 0 && s[i] <= 1 && s[i] < out->s) || !is_hit(r, number, &d, c, p, s[i], rgba))
                continue;
            out->s = s[i];
            out->t = c->t_a + s[i] * (c->t_b - c->t_a);
            out->entry = number;
            out->normal = normal_of(&d, p, (vec3){to.x - from.x, to.y - from.y, to.z - from.z});
            out->ground = (vec){c->a.x + s[i] * (c->b.x - c->a.x), c->a.y + s[i] * (c->b.y - c->a.y)};
            for (int k = 0; k < 4; k++)
                out->rgba[k] = rgba[k] / rgba[3];
        }
    }
    return out->s <= 1;
}

/* A cell anywhere in one direction: false: there is none. sign and origin: a place v is at sign x (v - origin). */
static bool home_cell(double at, uint32_t cells, zt_wrap how, uint32_t *home, double *sign, double *origin) {
    bool ends = how == ZT_WRAP_CLAMP || how == ZT_WRAP_BORDER;
    double cell = ends && at == cells ? cells - 1.0 : floor(at);
    double round = floor(cell / cells), within = cell - round * cells;
    *sign = 1;
    *origin = round * cells;
    *home = (uint32_t)within;
    if (ends)
        return round == 0;
    if (how == ZT_WRAP_MIRROR && fmod(fabs(round), 2) == 1) {
        *sign = -1;
        *origin = (round + 1) * cells;
        *home = cells - 1 - (uint32_t)within;
    }
    return true;
}

static int add_cuts(double from, double to, double *cuts, int count) {
    for (double c = ceil(fmin(from, to)); c <= fmax(from, to) && from != to; c++) {
        double t = (c - from) / (to - from);
        if (t > 0 && t < 1 && count < MOST_CUTS)
            cuts[count++] = t;
    }
    return count;
}

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double taper(const reference *r, double rho) {
    double a = (double)r->info.taper_start, b = (double)r->info.taper_end;
    double x = clamped_to((rho - a) / (b - a), 0, 1);
    return r->info.prism_height > 0 ? 1 - x * x * (3 - 2 * x) : 0;
}

static void ground(const reference *r, const zt_ray *ray, bool flat, zt_hit *out) {
    const zt_umbrella_level *l = &r->info.levels[0];
    zt_point p = {.u = ray->u1,
                  .v = ray->v1,
                  .du_dx = ray->footprint1 / r->info.grid_x,
                  .dv_dy = ray->footprint1 / r->info.grid_y};
    pixel edge = {{ray->footprint1, 0}, {0, ray->footprint1}};
    vec s = {p.u, p.v};
    double rgba[4] = {0, 0, 0, 0};
    if (ray->z1 != 0)
        return;
    if (flat) {
        out->kind = ZT_HIT_FLAT;
        reference_lookup(r, &p, rgba);
    } else if (wrap_to(&s.x, r->wrap_u) && wrap_to(&s.y, r->wrap_v)) {
        double light = reference_light(r, l, (vec){s.x * l->width, s.y * l->height}, &edge, -1);
        out->kind = ZT_HIT_BACKGROUND;
        reference_background(r, &p, rgba);
        for (int c = 0; c < 3; c++)
            rgba[c] *= light;
    }
    for (int c = 0; c < 4; c++)
        out->rgba[c] = (float)rgba[c];
}

static void hit_of(const reference *r, const found *f, const cell_piece *c, const double sign[2], zt_hit *out) {
    double rho = c->rho_a + f->s * (c->rho_b - c->rho_a);
    pixel edge = {{rho, 0}, {0, rho}};
    double light = reference_light(r, &r->info.levels[0], f->ground, &edge, (long)f->entry);
    for (int k = 0; k < 4; k++)
        out->rgba[k] = (float)(f->rgba[k] * (k < 3 ? light : 1));
    out->normal[0] = (float)(sign[0] * f->normal.x);
    out->normal[1] = (float)(sign[1] * f->normal.y);
    out->normal[2] = (float)f->normal.z;
    out->t = (float)f->t;
    out->kind = ZT_HIT_UMBRELLA;
    out->umbrella = f->entry;
}

static zt_hit reference_ray(const reference *r, const zt_ray *ray) {
    zt_hit out = {.normal = {0, 0, 1}, .t = 1, .umbrella = ZT_NONE};
    static double cuts[MOST_CUTS + 2];
    vec3 p0 = {ray->u0 * r->info.grid_x, ray->v0 * r->info.grid_y, ray->z0};
    vec3 p1 = {ray->u1 * r->info.grid_x, ray->v1 * r->info.grid_y, ray->z1};
    int count = add_cuts(p0.y, p1.y, cuts, add_cuts(p0.x, p1.x, cuts, 0));
    cuts[count++] = 0;
    cuts[count++] = 1;
    qsort(cuts, (size_t)count, sizeof *cuts, ascending);
    for (int i = 0; i + 1 < count; i++) {
        vec3 middle = point_on(p0, p1, (cuts[i] + cuts[i + 1]) / 2);
        uint32_t x, y;
        double sign[2], origin[2];
        bool there = home_cell(middle.x, r->info.grid_x, r->wrap_u, &x, &sign[0], &origin[0]);
        there = home_cell(middle.y, r->info.grid_y, r->wrap_v, &y, &sign[1], &origin[1]) && there;
        if (!there || cuts[i] == cuts[i + 1])
            continue;
        cell_piece c = {.t_a = cuts[i], .t_b = cuts[i + 1]};
        vec3 a = point_on(p0, p1, c.t_a), b = point_on(p0, p1, c.t_b);
        c.rho_a = ray->footprint0 + c.t_a * (ray->footprint1 - ray->footprint0);
        c.rho_b = ray->footprint0 + c.t_b * (ray->footprint1 - ray->footprint0);
        c.tau_a = taper(r, c.rho_a);
        c.tau_b = taper(r, c.rho_b);
        if (c.tau_a <= 1 / 64.0 || c.tau_b <= 1 / 64.0) {
            ground(r, ray, true, &out);
            return out;
        }
        c.a = (vec3){sign[0] * (a.x - origin[0]), sign[1] * (a.y - origin[1]), a.z / c.tau_a};
        c.b = (vec3){sign[0] * (b.x - origin[0]), sign[1] * (b.y - origin[1]), b.z / c.tau_b};
        found f;
        if (nearest(r, &c, x, y, &f)) {
            hit_of(r, &f, &c, sign, &out);
            return out;
        }
    }
    ground(r, ray, false, &out);
    return out;
}

/* ---- agreement ---- */

static zt_ray random_ray(const stage_setup *t, const zt_umbrella_info *n, uint64_t *seed) {
    double h = (double)n->prism_height, reach = test_uniform(seed, 0.2, 4);
    zt_ray ray = {.u0 = test_uniform(seed, -0.6, 1.6), .v0 = test_uniform(seed, -0.6, 1.6), .z0 = h};
    double angle = test_uniform(seed, 0, 6.283185307179586), x = cos(angle), y = sin(angle);
    uint32_t quarter = test_below(seed, 4);
    switch (test_below(seed, 6)) {
    case 0:
        x = quarter % 2 ? 0 : (double)quarter - 1; /* along an axis, and perhaps along the sides of cells */
        y = quarter % 2 ? (double)quarter - 2 : 0;
        ray.u0 = (double)test_below(seed, t->grid_x + 1) / t->grid_x;
        break;
    case 1:
        reach = 0; /* straight down */
        break;
    case 2:
        ray.z0 = test_uniform(seed, 0, h); /* from inside, upwards */
        break;
    default:
        break;
    }
    ray.u1 = ray.u0 + reach * x / t->grid_x;
    ray.v1 = ray.v0 + reach * y / t->grid_y;
    ray.z1 = ray.z0 < h ? h : test_below(seed, 5) == 0 ? test_uniform(seed, 0, h) : 0;
    ray.footprint0 = test_uniform(seed, 0, 0.03);
    ray.footprint1 = ray.footprint0 + (test_below(seed, 2) ? test_uniform(seed, 0, 0.12) : 0);
    return ray;
}

static bool same_hit(const zt_hit *a, const zt_hit *b) {
    bool same = a->kind == b->kind && a->umbrella == b->umbrella && fabs((double)a->t - (double)b->t) < 1e-6;
    for (int c = 0; c < 4; c++)
        same = same && fabs((double)a->rgba[c] - (double)b->rgba[c]) < 4e-6;
    for (int c = 0; c < 3; c++)
        same = same && fabs((double)a->normal[c] - (double)b->normal[c]) < 1e-5;
    return same;
}

static int kinds[4];

static void compare(const stage_setup *setup, const zt_sampler_options *options, uint64_t seed) {
    static zt_ray rays[RAYS];
    static zt_hit got[RAYS];
    stage s = stage_make(setup, seed);
    zt_file *file = stage_open(&s);
    zt_sampler *sampler = stage_sampler(file, STAGE_UMBRELLAS, options);
    zt_sampler_options nearest_options = *options;
    nearest_options.filter = ZT_FILTER_NEAREST;
    zt_sampler *other = stage_sampler(file, STAGE_UMBRELLAS, &nearest_options);
    reference r = reference_open(file, setup, options, false);
    zt_diag diag;
    for (int i = 0; i < RAYS; i++)
        rays[i] = random_ray(setup, &r.info, &seed);
    must(zt_sample_rays(sampler, rays, RAYS, got, &diag), &diag);
    for (int i = 0; i < RAYS; i++) {
        zt_hit want = reference_ray(&r, &rays[i]), once;
        CHECK(same_hit(&got[i], &want));
        must(zt_sample_rays(sampler, &rays[i], 1, &once, &diag), &diag);
        CHECK(memcmp(&once, &got[i], sizeof once) == 0);
        /* The filter is one of lookups in 2-D. */
        must(zt_sample_rays(other, &rays[i], 1, &once, &diag), &diag);
        CHECK(memcmp(&once, &got[i], sizeof once) == 0);
        kinds[got[i].kind]++;
    }
    reference_close(&r);
    zt_sampler_close(other);
    zt_sampler_close(sampler);
    zt_close(file);
    stage_free(&s);
}

static void check_agreement(void) {
    static const uint32_t grids[][2] = {{5, 7}, {1, 1}, {8, 3}, {2, 9}};
    static const zt_wrap wraps[][2] = {{ZT_WRAP_REPEAT, ZT_WRAP_REPEAT},
                                       {ZT_WRAP_CLAMP, ZT_WRAP_REPEAT},
                                       {ZT_WRAP_MIRROR, ZT_WRAP_BORDER},
                                       {ZT_WRAP_REPEAT, ZT_WRAP_CLAMP},
                                       {ZT_WRAP_BORDER, ZT_WRAP_MIRROR}};
    static const uint32_t corners[] = {3, 5, 9, 24};
    for (uint32_t n = 0; n < 60; n++) {
        stage_setup t = {.grid_x = grids[n % 4][0],
                         .grid_y = grids[n % 4][1],
                         .levels = 1,
                         .umbrellas = 1 + n % 30,
                         .corners = corners[n / 2 % 4],
                         .wrap_u = wraps[n / 4 % 5][0],
                         .wrap_v = wraps[n / 4 % 5][1],
                         .mode = (zt_umbrella_colour_mode)(n / 3 % 2),
                         .below = (zt_background_kind)(n / 7 % 3),
                         .solid = n % 11 != 0,
                         .opaque = n % 3 != 1,
                         .textures = n % 8 == 3};
        zt_sampler_options o = {0};
        if (n % 4 == 2) {
            o.shadow = 0.6;
            o.light_x = 0.4;
            o.light_y = -0.3;
        }
        compare(&t, &o, 0x5EED + n);
    }
    for (int k = 0; k < 4; k++)
        CHECK(kinds[k] > 500);
}

/* ---- what a picture shows ---- */

static const stage_setup hills = {
    .grid_x = 6, .grid_y = 5, .levels = 1, .umbrellas = 30, .corners = 12, .solid = true, .opaque = true};

/* A texture of one umbrella over nothing. */
static stage one_dome(zt_umbrella_ellipsoid kind, uint16_t height, uint16_t curvature, uint16_t lift) {
    enum { CORNERS = 64 };
    static zt_umbrella_offset corners[CORNERS];
    static zt_umbrella_colour colours[1 + CORNERS];
    static uint32_t starts[16 + 1], entries[16];
    static zt_umbrella_level level = {.width = 4, .height = 4, .umbrella_count = 1, .bits = 16};
    zt_umbrella u = {.x = 2 << 16, .y = 2 << 16, .form = ZT_UMBRELLA_COLOURED, .vertex_count = CORNERS};
    zt_layer_desc layer = {ZT_SEMANTIC_BASE_COLOUR, 0};
    zt_texture_desc desc = {.wrap_u = ZT_WRAP_CLAMP, .wrap_v = ZT_WRAP_CLAMP, .layers = &layer, .layer_count = 1};
    stage s = {.setup = {.grid_x = 4, .grid_y = 4}};
    zt_sink sink = memory_sink_of(&s.bytes);
    zt_writer *w;
    zt_diag diag;
    uint64_t seed = 1;
    u.ellipsoid = (uint8_t)kind;
    u.height = height;
    u.curvature = curvature;
    u.lift = lift;
    for (uint32_t i = 0; i < CORNERS; i++)
        corners[i] = stage_corner(i, CORNERS, 65536, 0);
    for (uint32_t i = 0; i < 16; i++)
        starts[i + 1] = i + 1;
    zt_umbrella_info info = {.grid_x = 4,
                             .grid_y = 4,
                             .level_count = 1,
                             .umbrella_count = 1,
                             .explicit_vertex_count = CORNERS,
                             .explicit_colour_count = 1 + CORNERS,
                             .cell_count = 16,
                             .entry_count = 16,
                             .background_source = ZT_NONE,
                             .prism_height = 0.5F,
                             .taper_start = 0.05F,
                             .taper_end = 0.1F,
                             .levels = &level,
                             .umbrellas = &u,
                             .explicit_vertices = corners,
                             .explicit_colours = colours,
                             .list_starts = starts,
                             .entries = entries};
    for (uint32_t i = 0; i < 16; i++)
        entries[i] = 4U << ZT_UMBRELLA_SHIFT; /* not shifted */
    must(zt_writer_open_sink(&sink, NULL, &diag, &w), &diag);
    stage_image(w, 4, true, &seed);
    must(zt_writer_add_umbrellas(w, &desc, &info, &diag, NULL), &diag);
    must(zt_writer_finish(w, &diag), &diag);
    zt_writer_close(w);
    return s;
}

static zt_hit ray_at(const zt_sampler *sampler, const zt_ray *ray) {
    zt_hit hit;
    zt_diag diag;
    must(zt_sample_rays(sampler, ray, 1, &hit, &diag), &diag);
    return hit;
}

/* The top of a dome and the bottom of a bowl, from above: as high, or low, as the file says, whatever the curvature. */
static void check_apex(void) {
    for (int n = 0; n < 8; n++) {
        bool bowl = n & 1;
        uint16_t height = 30000, lift = (uint16_t)(n & 2 ? 20000 : 0), curvature = (uint16_t)(n & 4 ? 65535 : 900);
        stage s = one_dome(bowl ? ZT_ELLIPSOID_CONCAVE : ZT_ELLIPSOID_CONVEX, height, curvature, lift);
        zt_file *file = stage_open(&s);
        zt_sampler *sampler = stage_sampler(file, 0, NULL);
        zt_ray down = {.u0 = 0.5, .v0 = 0.5, .z0 = 0.5, .u1 = 0.5, .v1 = 0.5};
        zt_hit hit = ray_at(sampler, &down);
        double z = 0.5 - 0.5 * (double)hit.t, want = 0.5 / 65535 * (lift + (bowl ? 0 : height));
        CHECK(hit.kind == ZT_HIT_UMBRELLA && fabs(z - want) < 1e-6);
        CHECK(hit.normal[0] == 0 && hit.normal[1] == 0 && hit.normal[2] == 1);
        /* From below the normal points down. */
        zt_ray up = {.u0 = 0.5, .v0 = 0.5, .z0 = 0, .u1 = 0.5, .v1 = 0.5, .z1 = 0.5};
        hit = ray_at(sampler, &up);
        CHECK(hit.kind == ZT_HIT_UMBRELLA && (hit.t == 0 || hit.normal[2] == -1));
        zt_sampler_close(sampler);
        zt_close(file);
        stage_free(&s);
    }
}

/* A ray that comes in flatly above a dome leaves through the other side of the prism: nothing is there, though the
 * ground is covered. A little lower it hits the dome, the lower the sooner. */
static void check_silhouette(void) {
    stage s = one_dome(ZT_ELLIPSOID_CONVEX, 40000, 30000, 0);
    zt_file *file = stage_open(&s);
    zt_sampler *sampler = stage_sampler(file, 0, NULL);
    double top = 0.5 * 40000 / 65535, before = 2;
    for (int i = 0; i <= 400; i++) {
        double z = top * (1.2 - i / 400.0);
        zt_ray ray = {.u0 = 0.1, .v0 = 0.5, .z0 = z, .u1 = 0.9, .v1 = 0.5, .z1 = z};
        zt_hit hit = ray_at(sampler, &ray);
        if (z > top + 1e-9)
            CHECK(hit.kind == ZT_HIT_NOTHING && hit.rgba[3] == 0);
        if (z < top - 1e-9) {
            CHECK(hit.kind == ZT_HIT_UMBRELLA && (double)hit.t < before && hit.normal[0] < 0);
            before = (double)hit.t;
        }
    }
    zt_sampler_close(sampler);
    zt_close(file);
    stage_free(&s);
}

/* The taper is of the place along the ray, so that a side of a cell cannot be seen: where rays come ever closer to one
 * from both sides, so do their hits. */
static void check_no_cracks(void) {
    stage s = one_dome(ZT_ELLIPSOID_CONVEX, 40000, 30000, 0);
    zt_file *file = stage_open(&s);
    zt_sampler *sampler = stage_sampler(file, 0, NULL);
    uint64_t seed = 3;
    for (int i = 0; i < 3000; i++) {
        double near = test_uniform(&seed, 1e-9, 1e-8);
        zt_ray a = {.u0 = 0.05, .v0 = 0.5 + test_uniform(&seed, -0.1, 0.1), .z0 = 0.5};
        a.u1 = 0.5 + test_uniform(&seed, -0.02, 0.02);
        a.v1 = 0.5;
        a.footprint0 = 0.04;
        a.footprint1 = test_uniform(&seed, 0.05, 0.08);
        zt_ray b = a;
        a.v1 -= near;
        b.v1 += near;
        zt_hit first = ray_at(sampler, &a), second = ray_at(sampler, &b);
        CHECK(first.kind == ZT_HIT_UMBRELLA && second.kind == ZT_HIT_UMBRELLA);
        CHECK(fabs((double)first.t - (double)second.t) < 1e-5);
    }
    zt_sampler_close(sampler);
    zt_close(file);
    stage_free(&s);
}

/* Among flat umbrellas without holes a ray straight down meets the topmost one that covers the point, so that its
 * colour is that of the lookup in 2-D. */
static void check_straight_down(void) {
    stage_setup t = hills;
    t.solid = false;
    t.prism = true;
    stage s = stage_make(&t, 11);
    zt_file *file = stage_open(&s);
    zt_sampler *sampler = stage_sampler(file, STAGE_UMBRELLAS, NULL);
    uint64_t seed = 5;
    int hits = 0;
    for (int i = 0; i < 2000; i++) {
        zt_ray ray = {.u0 = test_uniform(&seed, -1, 2), .v0 = test_uniform(&seed, -1, 2), .z0 = 0.7};
        zt_point p = {.u = ray.u0, .v = ray.v0};
        float rgba[4];
        zt_diag diag;
        ray.u1 = ray.u0;
        ray.v1 = ray.v0;
        zt_hit hit = ray_at(sampler, &ray);
        must(zt_sample(sampler, &p, 1, rgba, &diag), &diag);
        CHECK(hit.kind == ZT_HIT_UMBRELLA || hit.kind == ZT_HIT_BACKGROUND);
        CHECK(hit.t == 1 && hit.normal[2] == 1);
        for (int c = 0; c < 4; c++)
            CHECK(fabs((double)rgba[c] - (double)hit.rgba[c]) < 1e-6);
        hits += hit.kind == ZT_HIT_UMBRELLA;
    }
    CHECK(hits > 500 && hits < 2000);
    zt_sampler_close(sampler);
    zt_close(file);
    stage_free(&s);
}

/* Where the taper is complete every ray that ends on the ground gives the lookup in 2-D there, with shadows. */
static void check_tapered(void) {
    stage s = stage_make(&hills, 12);
    zt_file *file = stage_open(&s);
    zt_sampler_options o = {.light_x = 0.3, .light_y = 0.2, .shadow = 0.5};
    zt_sampler *sampler = stage_sampler(file, STAGE_UMBRELLAS, &o);
    uint64_t seed = 6;
    for (int i = 0; i < 2000; i++) {
        zt_ray ray = {.u0 = test_uniform(&seed, -1, 2), .v0 = test_uniform(&seed, -1, 2), .z0 = 0.7};
        ray.u1 = ray.u0 + test_uniform(&seed, -1, 1);
        ray.v1 = ray.v0 + test_uniform(&seed, -1, 1);
        ray.footprint0 = ray.footprint1 = test_uniform(&seed, 0.1, 0.5);
        zt_point p = {.u = ray.u1, .v = ray.v1, .du_dx = ray.footprint1 / 6, .dv_dy = ray.footprint1 / 5};
        float rgba[4];
        zt_diag diag;
        zt_hit hit = ray_at(sampler, &ray);
        must(zt_sample(sampler, &p, 1, rgba, &diag), &diag);
        CHECK(hit.kind == ZT_HIT_FLAT && memcmp(rgba, hit.rgba, sizeof rgba) == 0);
        ray.z1 = 1e-30;
        hit = ray_at(sampler, &ray);
        CHECK(hit.kind == ZT_HIT_NOTHING && hit.rgba[3] == 0);
    }
    zt_sampler_close(sampler);
    zt_close(file);
    stage_free(&s);
}

/* A ray's numbers may be any; what is not finite, and what is too far away to see a cell, hits nothing. */
static void check_hostile(void) {
    static const double wild[] = {
        0,    -0.0,  1,     -1,     0.5,         1e-320,           -1e-320,          1e-30, 1e3, -1e6, 1e9,
        1e15, -1e19, 1e300, -1e308, (double)NAN, (double)INFINITY, -(double)INFINITY};
    enum { WILD = sizeof wild / sizeof wild[0] };
    stage s = stage_make(&hills, 13);
    zt_file *file = stage_open(&s);
    zt_sampler *sampler = stage_sampler(file, STAGE_UMBRELLAS, NULL);
    uint64_t seed = 7;
    for (int i = 0; i < 300; i++) {
        double v[8];
        bool finite = true;
        for (int k = 0; k < 8; k++) {
            v[k] = test_below(&seed, 3) == 0 ? wild[test_below(&seed, WILD)] : test_uniform(&seed, -2, 2);
            finite = finite && isfinite(v[k]);
        }
        zt_ray ray = {v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7]};
        zt_hit hit = ray_at(sampler, &ray);
        bool far = fabs(v[0]) > 1e12 || fabs(v[1]) > 1e12 || fabs(v[3]) > 1e13 || fabs(v[4]) > 1e13;
        CHECK((finite && !far) || hit.kind == ZT_HIT_NOTHING);
        CHECK(hit.t >= 0 && hit.t <= 1);
        for (int c = 0; c < 4; c++)
            CHECK(hit.rgba[c] >= 0 && hit.rgba[c] <= 1);
    }
    zt_sampler_close(sampler);
    zt_close(file);
    stage_free(&s);
}

int main(void) {
    check_agreement();
    check_apex();
    check_silhouette();
    check_no_cracks();
    check_straight_down();
    check_tapered();
    check_hostile();
    return test_end();
}
