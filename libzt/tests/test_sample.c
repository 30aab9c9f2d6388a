/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: lookups give what spec/ztex.md section 12 and spec/zipmap.md section 3 say. The same formulas stand here
 * once more, slow and in doubles, over every texel and every patch; samplers of random images and zipmaps must agree
 * with them, whatever the number of threads, and survive any coordinates.
 */
#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "base_bytes.h"
#include "test.h"
#include "write_sink.h"
#include "zt/zt.h"

enum { MAX_IMAGES = 64, MAX_PATCHES = 40, MAX_TEXTURES = 4 };

/* ---- a file and what is in it ----------------------------------------------------------------- */

typedef struct image {
    zt_image_desc desc;
    uint32_t levels, channels, bytes;
    uint8_t *level[21]; /* tight */
} image;

typedef struct texture {
    bool is_zipmap;
    uint8_t wraps[3];
    uint32_t layer_count, images[2];
    uint32_t patch_count;
    zt_patch_desc patches[MAX_PATCHES];
    uint32_t sources[MAX_PATCHES][2];
    double composed[MAX_PATCHES][9];
} texture;

typedef struct scene {
    zt_writer *writer;
    memory_sink bytes;
    uint32_t image_count, texture_count;
    image images[MAX_IMAGES];
    texture textures[MAX_TEXTURES];
    zt_file *file;
} scene;

static scene *scene_begin(void) {
    scene *s = calloc(1, sizeof *s);
    zt_sink sink = memory_sink_of(&s->bytes);
    zt_writer_options options = {.effort = 1};
    zt_diag diag = {0};
    must(zt_writer_open_sink(&sink, &options, &diag, &s->writer), &diag);
    return s;
}

static void scene_open(scene *s, const zt_limits *limits) {
    zt_diag diag = {0};
    zt_open_options options = {.limits = limits};
    if (s->writer) {
        must(zt_writer_finish(s->writer, &diag), &diag);
        zt_writer_close(s->writer);
        s->writer = NULL;
    }
    zt_close(s->file);
    must(zt_open_memory(s->bytes.data, s->bytes.size, &options, &diag, &s->file), &diag);
}

static void scene_end(scene *s) {
    zt_close(s->file);
    for (uint32_t i = 0; i < s->image_count; i++) {
        for (uint32_t k = 0; k < s->images[i].levels; k++)
            free(s->images[i].level[k]);
    }
    free(s->bytes.data);
    free(s);
}

static uint32_t at_level(uint32_t size, uint32_t k) {
    return size >> k > 0 ? size >> k : 1;
}

/* Random bytes are wild halves; those are made from small values. value below 0: random, else all texels have it. */
static void fill_texels(const image *m, uint8_t *dst, size_t texels, double value, uint64_t *seed) {
    for (size_t i = 0; i < texels; i++) {
        float rgba[4];
        for (int c = 0; c < 4; c++)
            rgba[c] = (float)(value < 0 ? test_uniform(seed, -0.05, 1.05) : value);
        zt_pack_texels(m->desc.format, rgba, 1, dst + i * m->bytes);
    }
}

/* All levels are given, and have nothing to do with each other: a lookup in the wrong one shows. */
static uint32_t add_image(scene *s, zt_image_desc desc, double value, uint64_t *seed) {
    zt_diag diag = {0};
    uint32_t index;
    image *m = &s->images[s->image_count];
    const zt_format_info *format = zt_find_format(desc.format);
    desc.depth = desc.depth ? desc.depth : 1;
    desc.layers = desc.layers ? desc.layers : 1;
    desc.given_levels = 1;
    desc.transfer = format->is_srgb ? 13 : desc.transfer ? desc.transfer : 8;
    uint32_t largest = desc.width > desc.height ? desc.width : desc.height;
    uint32_t all = 1;
    while ((largest > desc.depth ? largest : desc.depth) >> all != 0)
        all++;
    m->levels = desc.levels ? desc.levels : all;
    m->desc = desc;
    m->channels = format->channels;
    m->bytes = format->block_bytes;
    must(zt_writer_add_image(s->writer, &desc, &diag, &index), &diag);
    CHECK(index == s->image_count);
    for (uint32_t k = 0; k < m->levels; k++) {
        uint32_t w = at_level(desc.width, k), h = at_level(desc.height, k), d = at_level(desc.depth, k);
        size_t texels = (size_t)w * h * d * desc.layers;
        m->level[k] = malloc(texels * m->bytes);
        fill_texels(m, m->level[k], texels, value, seed);
        must(zt_writer_put_level_rows(s->writer, index, k, m->level[k], h * d * desc.layers, 0, &diag), &diag);
    }
    return s->image_count++;
}

static uint32_t add_texture(scene *s, const texture *t) {
    zt_diag diag = {0};
    uint32_t index;
    zt_layer_desc layers[2] = {{1, t->images[0]}, {2, t->images[1]}};
    zt_texture_desc desc = {NULL, t->wraps[0], t->wraps[1], t->wraps[2], layers, t->layer_count, 0};
    texture *own = &s->textures[s->texture_count];
    *own = *t;
    for (uint32_t i = 0; i < t->patch_count; i++)
        own->patches[i].sources = own->sources[i];
    if (t->is_zipmap)
        must(zt_writer_add_zipmap(s->writer, &desc, own->patches, t->patch_count, &diag, &index), &diag);
    else
        must(zt_writer_add_texture(s->writer, &desc, &diag, &index), &diag);
    CHECK(index == s->texture_count);
    return s->texture_count++;
}

/* ---- the slow formulas: images (ztex.md section 12) ------------------------------------------- */

typedef struct look {
    zt_filter filter;
    uint32_t anisotropy;
} look;

static double slow_linear(uint32_t transfer, double v) {
    if (transfer == 13)
        return v <= 0.04045 ? v / 12.92 : pow((v + 0.055) / 1.055, 2.4);
    return transfer == 4 ? pow(v, 2.2) : v;
}

static int64_t slow_wrap(int64_t i, int64_t n, uint8_t wrap) {
    int64_t m = (i % (2 * n) + 2 * n) % (2 * n);
    if (wrap == ZT_WRAP_REPEAT)
        return m % n;
    if (wrap == ZT_WRAP_MIRROR)
        return m < n ? m : 2 * n - 1 - m;
    if (wrap == ZT_WRAP_CLAMP)
        return i < 0 ? 0 : i >= n ? n - 1 : i;
    return i < 0 || i >= n ? -1 : i;
}

static void add_slow_texel(const image *m, uint32_t k, uint32_t layer, const int64_t index[3], const uint8_t *wraps,
                           double weight, double *sum) {
    int64_t w = at_level(m->desc.width, k), h = at_level(m->desc.height, k), d = at_level(m->desc.depth, k);
    int64_t x = slow_wrap(index[0], w, wraps[0]), y = slow_wrap(index[1], h, wraps[1]);
    int64_t z = d == 1 && m->desc.depth == 1 ? 0 : slow_wrap(index[2], d, wraps[2]);
    float c[4];
    if (x < 0 || y < 0 || z < 0)
        return;
    zt_unpack_texels(m->desc.format, m->level[k] + (size_t)(((layer * d + z) * h + y) * w + x) * m->bytes, 1, c);
    double alpha = (double)c[3];
    for (int i = 0; i < 3; i++)
        sum[i] += weight * slow_linear(m->desc.transfer, (double)c[i]) * (m->desc.alpha_mode == 1 ? alpha : 1);
    sum[3] += weight * alpha;
}

static void slow_level(const image *m, uint32_t k, uint32_t layer, const double at[3], const uint8_t *wraps,
                       bool nearest, double weight, double *sum) {
    double size[3] = {at_level(m->desc.width, k), at_level(m->desc.height, k), at_level(m->desc.depth, k)};
    double s[3], f[3];
    int64_t i[3];
    for (int a = 0; a < 3; a++) {
        s[a] = at[a] * size[a] - (nearest ? 0 : 0.5);
        i[a] = (int64_t)floor(s[a]);
        f[a] = s[a] - floor(s[a]);
    }
    if (nearest) {
        add_slow_texel(m, k, layer, i, wraps, weight, sum);
        return;
    }
    for (int corner = 0; corner < (m->desc.depth > 1 ? 8 : 4); corner++) {
        int64_t index[3];
        double part = weight;
        for (int a = 0; a < (m->desc.depth > 1 ? 3 : 2); a++) {
            int up = corner >> a & 1;
            index[a] = i[a] + up;
            part *= up ? f[a] : 1 - f[a];
        }
        add_slow_texel(m, k, layer, index, wraps, part, sum);
    }
}

/* lambda, not clamped; *probes and the longer derivative. */
static double slow_lambda(const image *m, look l, const zt_point *p, uint32_t *probes, double step[3]) {
    double d = m->desc.depth > 1 ? m->desc.depth : 0;
    double a = hypot(hypot(p->du_dx * m->desc.width, p->dv_dx * m->desc.height), p->dw_dx * d);
    double b = hypot(hypot(p->du_dy * m->desc.width, p->dv_dy * m->desc.height), p->dw_dy * d);
    bool x_longer = a >= b;
    double longer = x_longer ? a : b, shorter = x_longer ? b : a;
    step[0] = x_longer ? p->du_dx : p->du_dy;
    step[1] = x_longer ? p->dv_dx : p->dv_dy;
    step[2] = x_longer ? p->dw_dx : p->dw_dy;
    *probes = 1;
    if (longer == 0)
        return -INFINITY;
    if (l.anisotropy > 1)
        *probes = shorter == 0 ? l.anisotropy : (uint32_t)fmin(ceil(longer / shorter), l.anisotropy);
    return log2(longer / *probes);
}

static void slow_image(const image *m, look l, const uint8_t *wraps, const zt_point *p, double *out) {
    uint32_t n;
    double step[3];
    double lambda = fmin(fmax(slow_lambda(m, l, p, &n, step), 0), m->levels - 1);
    uint32_t layer = p->array_layer < m->desc.layers ? p->array_layer : m->desc.layers - 1;
    memset(out, 0, 4 * sizeof *out);
    for (uint32_t i = 0; i < n; i++) {
        double t = n > 1 ? (i + 0.5) / n - 0.5 : 0;
        double at[3] = {p->u + t * step[0], p->v + t * step[1], p->w + t * step[2]};
        if (l.filter != ZT_FILTER_TRILINEAR) {
            slow_level(m, (uint32_t)floor(lambda + 0.5), layer, at, wraps, l.filter == ZT_FILTER_NEAREST, 1, out);
            continue;
        }
        double k = floor(lambda);
        slow_level(m, (uint32_t)k, layer, at, wraps, false, (1 - lambda + k) / n, out);
        if (lambda > k)
            slow_level(m, (uint32_t)k + 1, layer, at, wraps, false, (lambda - k) / n, out);
    }
}

/* ---- the slow formulas: zipmaps (zipmap.md section 3) ------------------------------------------ */

static const uint8_t clamps[3] = {ZT_WRAP_CLAMP, ZT_WRAP_CLAMP, ZT_WRAP_CLAMP};

static void slow_texture(const scene *s, uint32_t index, look l, const uint8_t *wraps, const zt_point *p,
                         double out[2][4]);

static bool slow_project(const double *m, double u, double v, const zt_point *root, zt_point *p) {
    double w = m[6] * u + m[7] * v + m[8];
    double x = (m[0] * u + m[1] * v + m[2]) / w, y = (m[3] * u + m[4] * v + m[5]) / w;
    if (!(w > 0) || x < 0 || x > 1 || y < 0 || y > 1)
        return false;
    *p = *root;
    p->u = x;
    p->v = y;
    double j[4] = {(m[0] - x * m[6]) / w, (m[1] - x * m[7]) / w, (m[3] - y * m[6]) / w, (m[4] - y * m[7]) / w};
    p->du_dx = j[0] * root->du_dx + j[1] * root->dv_dx;
    p->dv_dx = j[2] * root->du_dx + j[3] * root->dv_dx;
    p->du_dy = j[0] * root->du_dy + j[1] * root->dv_dy;
    p->dv_dy = j[2] * root->du_dy + j[3] * root->dv_dy;
    return true;
}

static double slow_unit(double u, uint8_t wrap, bool *outside) {
    double m = u - 2 * floor(u / 2);
    if (wrap == ZT_WRAP_REPEAT)
        return u - floor(u);
    if (wrap == ZT_WRAP_MIRROR)
        return m > 1 ? 2 - m : m;
    if (wrap == ZT_WRAP_BORDER && (u < 0 || u > 1))
        *outside = true;
    return fmin(fmax(u, 0), 1);
}

/* Adds patch i, of which p is the point; *rest is T. */
static void slow_patch(const scene *s, const texture *t, uint32_t i, look l, const zt_point *p, double *rest,
                       double out[2][4]) {
    const zt_patch_desc *d = &t->patches[i];
    double colours[2][4] = {{0}}, mask[4] = {1, 0, 0, 1}, f = 1, step[3];
    uint32_t n;
    if (d->mask != ZT_NONE)
        slow_image(&s->images[d->mask], l, clamps, p, mask);
    if (d->shows_texture) {
        slow_texture(s, t->sources[i][0], l, clamps, p, colours);
    } else {
        const image *coverage = &s->images[d->mask != ZT_NONE ? d->mask : t->sources[i][0]];
        f = fmin(fmax(coverage->levels - slow_lambda(coverage, l, p, &n, step), 0), 1);
        for (uint32_t k = 0; k < t->layer_count; k++)
            slow_image(&s->images[t->sources[i][k]], l, clamps, p, colours[k]);
    }
    double a = f * mask[0];
    if (d->shows_texture || d->mask == ZT_NONE)
        a *= colours[0][3];
    for (int c = 0; c < 4; c++) {
        out[0][c] += *rest * f * mask[0] * colours[0][c];
        out[1][c] += *rest * a * colours[1][c];
    }
    *rest *= 1 - a;
}

static void slow_texture(const scene *s, uint32_t index, look l, const uint8_t *wraps, const zt_point *p,
                         double out[2][4]) {
    const texture *t = &s->textures[index];
    double rest = 1;
    memset(out, 0, 8 * sizeof(double));
    if (t->is_zipmap) {
        bool outside = false;
        double u = slow_unit(p->u, wraps[0], &outside), v = slow_unit(p->v, wraps[1], &outside);
        for (uint32_t i = t->patch_count - 1; i > 0 && !outside; i--) {
            zt_point q;
            if (slow_project(t->composed[i], u, v, p, &q))
                slow_patch(s, t, i, l, &q, &rest, out);
        }
    }
    for (uint32_t k = 0; k < t->layer_count; k++) {
        double root[4];
        slow_image(&s->images[t->is_zipmap ? t->sources[0][k] : t->images[k]], l, wraps, p, root);
        for (int c = 0; c < 4; c++)
            out[k][c] += rest * root[c];
    }
}

/* ---- comparing ----------------------------------------------------------------------------------- */

static zt_point random_point(uint64_t *seed) {
    double scale = pow(10, test_uniform(seed, -4, 1));
    double thin = test_below(seed, 2) ? 1 : pow(10, test_uniform(seed, -2, 0));
    double angle = test_uniform(seed, 0, 6.3);
    zt_point p = {
        .u = test_uniform(seed, -0.2, 1.2),
        .v = test_uniform(seed, -0.2, 1.2),
        .w = test_uniform(seed, -2, 3),
        .du_dx = scale * cos(angle),
        .dv_dx = scale * sin(angle),
        .dw_dx = scale * test_uniform(seed, -0.3, 0.3),
        .du_dy = -scale * thin * sin(angle),
        .dv_dy = scale * thin * cos(angle),
        .array_layer = test_below(seed, 5),
    };
    if (test_below(seed, 4) == 0) {
        p.u = test_uniform(seed, -4, 4);
        p.v = test_uniform(seed, -4, 4);
    }
    if (test_below(seed, 8) == 0)
        p.du_dx = p.dv_dx = p.dw_dx = p.du_dy = p.dv_dy = 0;
    return p;
}

/* The early end of a lookup drops at most 2^-16 of what lies behind. */
static void compare(const scene *s, uint32_t index, uint32_t layer, look l, uint32_t points, uint64_t *seed) {
    zt_sampler_options options = {.filter = l.filter, .max_anisotropy = l.anisotropy, .layer = layer};
    zt_sampler *sampler;
    zt_diag diag = {0};
    must(zt_sampler_open(s->file, index, &options, &diag, &sampler), &diag);
    for (uint32_t n = 0; n < points; n++) {
        zt_point p = random_point(seed);
        float got[4];
        double wanted[2][4], worst = 0;
        must(zt_sample(sampler, &p, 1, got, &diag), &diag);
        slow_texture(s, index, l, s->textures[index].wraps, &p, wanted);
        for (int c = 0; c < 4; c++)
            worst = fmax(worst, fabs((double)got[c] - wanted[layer][c]));
        CHECK(worst < 4e-5);
        if (!(worst < 4e-5) && test_failures < 5)
            fprintf(stderr, "texture %u layer %u at %g %g: %g instead of %g\n", index, layer, p.u, p.v, (double)got[0],
                    wanted[layer][0]);
    }
    zt_sampler_close(sampler);
}

static const look looks[] = {
    {ZT_FILTER_TRILINEAR, 0}, {ZT_FILTER_BILINEAR, 0},   {ZT_FILTER_NEAREST, 0},
    {ZT_FILTER_TRILINEAR, 4}, {ZT_FILTER_TRILINEAR, 16},
};

enum { LOOKS = sizeof looks / sizeof looks[0] };

static void check_images(void) {
    static const zt_image_desc descs[] = {
        {.format = 43, .width = 1, .height = 1},
        {.format = 43, .width = 5, .height = 3, .alpha_mode = 1},
        {.format = 37, .width = 33, .height = 17, .layers = 3, .alpha_mode = 2},
        {.format = 43, .width = 150, .height = 70, .tile_edge = 16, .layers = 2, .alpha_mode = 1},
        {.format = 29, .width = 100, .height = 131, .tile_edge = 32},
        {.format = 22, .width = 70, .height = 9, .tile_edge = 16, .levels = 2},
        {.format = 70, .width = 20, .height = 90, .tile_edge = 16, .transfer = 4},
        {.format = 97, .width = 67, .height = 12, .tile_edge = 16, .alpha_mode = 1},
        {.format = 9, .width = 20, .height = 9, .depth = 7},
        {.format = 37, .width = 70, .height = 20, .depth = 5, .tile_edge = 16, .layers = 2, .alpha_mode = 1},
        {.format = 109, .width = 12, .height = 80, .depth = 3, .tile_edge = 16, .alpha_mode = 2},
    };
    uint64_t seed = 1;
    for (size_t d = 0; d < sizeof descs / sizeof descs[0]; d++) {
        scene *s = scene_begin();
        texture t = {.layer_count = 1};
        t.images[0] = add_image(s, descs[d], -1, &seed);
        for (int k = 0; k < 4; k++) {
            for (int a = 0; a < 3; a++)
                t.wraps[a] = k == 0 ? ZT_WRAP_REPEAT : (uint8_t)test_below(&seed, 4);
            add_texture(s, &t);
        }
        scene_open(s, NULL);
        for (uint32_t k = 0; k < 4 * LOOKS; k++)
            compare(s, k % 4, 0, looks[k / 4], 150, &seed);
        scene_end(s);
    }
}

/* ---- zipmaps ------------------------------------------------------------------------------------- */

static void multiply(const double *p, const double *q, double *out) {
    for (int i = 0; i < 9; i++)
        out[i] = p[i / 3 * 3] * q[i % 3] + p[i / 3 * 3 + 1] * q[3 + i % 3] + p[i / 3 * 3 + 2] * q[6 + i % 3];
}

/* A part of the parent of about half its edge, turned and tilted a little. */
static void random_matrix(double m[9], uint64_t *seed) {
    double edge = test_uniform(seed, 0.3, 0.7), angle = test_uniform(seed, -0.5, 0.5);
    double mirror = test_below(seed, 4) ? 1 : -1;
    double cx = test_uniform(seed, 0.2, 0.8), cy = test_uniform(seed, 0.2, 0.8);
    double c = cos(angle) / edge, s = sin(angle) / edge * mirror;
    double turn[9] = {c, s, -c * cx - s * cy, -s * mirror, c * mirror, s * mirror * cx - c * mirror * cy, 0, 0, 1};
    double tilt[9] = {1, 0, 0.5, 0, 1, 0.5, 0, 0, 1};
    double t = test_uniform(seed, -0.3, 0.3);
    double view[9] = {1, 0, 0, 0, 1, 0, t, t / 2, 1};
    double part[9];
    multiply(view, turn, part);
    multiply(tilt, part, m);
}

/* Patches with alpha, with masks, and showing the earlier textures below `shown`. */
static void fill_zipmap(scene *s, texture *t, uint32_t count, uint32_t shown, uint64_t *seed) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    t->is_zipmap = true;
    t->layer_count = 2;
    t->patch_count = count;
    memset(t->patches, 0, sizeof t->patches);
    for (uint32_t i = 0; i < count; i++) {
        zt_patch_desc *p = &t->patches[i];
        uint32_t size = 8 + test_below(seed, 90), kind = i == 0 ? 3 : test_below(seed, shown > 0 ? 4 : 2);
        zt_image_desc desc = {.format = 43, .width = size, .height = 8 + size / 2, .tile_edge = 16, .alpha_mode = 1};
        desc.levels = test_below(seed, 3) ? 0 : 1 + test_below(seed, 3);
        desc.layers = i == 0 || test_below(seed, 3) == 0 ? 3 : 1;
        desc.layer_kind = ZT_LAYERS_FRAMES;
        memcpy(p->matrix, identity, sizeof identity);
        memcpy(t->composed[i], identity, sizeof identity);
        p->mask = ZT_NONE;
        if (i > 0) {
            p->parent = test_below(seed, 2) ? test_below(seed, i) : 0;
            random_matrix(p->matrix, seed);
            multiply(p->matrix, t->composed[p->parent], t->composed[i]);
        }
        if (kind == 1 || (kind == 2 && shown > 1)) {
            zt_image_desc mask = {.format = i % 2 ? 9 : 15, .width = 40, .height = 30};
            p->mask = add_image(s, mask, -1, seed);
            desc.alpha_mode = 0;
            desc.format = 29;
        }
        p->shows_texture = i > 0 && kind >= 2;
        if (p->shows_texture) {
            t->sources[i][0] = t->sources[i][1] = test_below(seed, shown);
            continue;
        }
        t->sources[i][0] = add_image(s, desc, -1, seed);
        t->sources[i][1] = add_image(s, (zt_image_desc){.format = 37, .width = 30, .height = 30}, -1, seed);
    }
}

static void check_zipmaps(void) {
    for (uint64_t round = 1; round <= 4; round++) {
        uint64_t seed = round;
        scene *s = scene_begin();
        texture image_texture = {.layer_count = 2, .wraps = {0, 0, 0}};
        image_texture.images[0] = add_image(
            s, (zt_image_desc){.format = 43, .width = 30, .height = 20, .alpha_mode = 1}, -1, &seed);
        image_texture.images[1] = add_image(s, (zt_image_desc){.format = 37, .width = 30, .height = 20}, -1, &seed);
        add_texture(s, &image_texture);
        texture t = {.wraps = {ZT_WRAP_REPEAT, ZT_WRAP_MIRROR, 0}};
        fill_zipmap(s, &t, 6, 0, &seed);
        add_texture(s, &t);
        texture top = {.wraps = {(uint8_t)(round % 4), (uint8_t)(round / 2), 0}};
        fill_zipmap(s, &top, 14, 2, &seed);
        add_texture(s, &top);
        scene_open(s, NULL);
        for (uint32_t k = 0; k < LOOKS; k++) {
            for (uint32_t layer = 0; layer < 2; layer++) {
                compare(s, 1, layer, looks[k], 200, &seed);
                compare(s, 2, layer, looks[k], 200, &seed);
            }
        }
        scene_end(s);
    }
}

/* ---- single properties ----------------------------------------------------------------------------- */

static void sample_one(const zt_file *file, uint32_t index, const zt_sampler_options *options, const zt_point *p,
                       float out[4]) {
    zt_sampler *sampler;
    zt_diag diag = {0};
    must(zt_sampler_open(file, index, options, &diag, &sampler), &diag);
    must(zt_sample(sampler, p, 1, out, &diag), &diag);
    zt_sampler_close(sampler);
}

/* A constant image is constant wherever it is looked up, and nothing else outside a border. */
static void check_constant(void) {
    uint64_t seed = 31;
    scene *s = scene_begin();
    texture t = {.layer_count = 1};
    t.images[0] = add_image(s, (zt_image_desc){.format = 97, .width = 90, .height = 40, .tile_edge = 16}, 0.625, &seed);
    add_texture(s, &t);
    t.wraps[0] = t.wraps[1] = ZT_WRAP_BORDER;
    add_texture(s, &t);
    scene_open(s, NULL);
    for (uint32_t k = 0; k < LOOKS; k++) {
        zt_sampler_options options = {.filter = looks[k].filter, .max_anisotropy = looks[k].anisotropy};
        for (int n = 0; n < 100; n++) {
            zt_point p = random_point(&seed);
            float out[4];
            sample_one(s->file, 0, &options, &p, out);
            for (int c = 0; c < 4; c++)
                CHECK(fabsf(out[c] - 0.625f) < 1e-6f);
        }
    }
    zt_point away = {.u = 1.5, .v = 0.5}, inside = {.u = 0.5, .v = 0.5};
    float out[4];
    sample_one(s->file, 1, NULL, &away, out);
    CHECK(out[0] == 0 && out[3] == 0);
    sample_one(s->file, 1, NULL, &inside, out);
    CHECK(out[0] == 0.625f);
    scene_end(s);
}

/* An opaque patch ends the lookup: what lies behind is not even decoded; the root alone on demand. */
static void check_opaque(void) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    uint64_t seed = 41;
    scene *s = scene_begin();
    texture t = {.is_zipmap = true, .layer_count = 1, .patch_count = 3};
    zt_image_desc desc = {.format = 97, .width = 16, .height = 16, .alpha_mode = 2};
    for (uint32_t i = 0; i < 3; i++) {
        t.sources[i][0] = add_image(s, desc, i == 1 ? 1.0 : 0.25 + i, &seed);
        t.patches[i].mask = ZT_NONE;
        memcpy(t.patches[i].matrix, identity, sizeof identity);
    }
    t.patches[2].matrix[2] = -0.5; /* covers u >= 0.5 */
    add_texture(s, &t);
    scene_open(s, NULL);
    zt_sampler *sampler;
    zt_diag diag = {0};
    zt_sampler_info info;
    zt_point p = {.u = 0.25, .v = 0.5};
    float out[4];
    must(zt_sampler_open(s->file, 0, NULL, &diag, &sampler), &diag);
    must(zt_sample(sampler, &p, 1, out, &diag), &diag);
    zt_get_sampler(sampler, &info);
    CHECK(out[0] == 1.0f && out[3] == 1.0f);
    CHECK(info.tile_bytes == 341 * 8 && info.longest_list == 2);
    zt_sampler_close(sampler);
    sample_one(s->file, 0, &(zt_sampler_options){.first_patch_only = 1}, &p, out);
    CHECK(out[0] == 0.25f);
    scene_end(s);
}

/* Any doubles: no trap, no undefined conversion; not finite gives zeros. */
static void check_wild(const scene *s) {
    static const double wild[] = {0, -0.0, 1, 1e-320, 1e300, -1e300, 1e18, -4e9, 0.5, 1e154, NAN, INFINITY, -INFINITY};
    uint64_t seed = 51;
    for (uint32_t k = 0; k < LOOKS; k++) {
        zt_sampler_options options = {.filter = looks[k].filter, .max_anisotropy = looks[k].anisotropy};
        zt_sampler *sampler;
        zt_diag diag = {0};
        must(zt_sampler_open(s->file, s->texture_count - 1, &options, &diag, &sampler), &diag);
        for (int n = 0; n < 3000; n++) {
            double v[9];
            bool finite = true;
            for (int i = 0; i < 9; i++) {
                v[i] = wild[test_below(&seed, n % 2 ? 10 : 13)];
                finite = finite && (isfinite(v[i]) || i == 2 || i == 5 || i == 8); /* w is ignored here */
            }
            zt_point p = {v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8], UINT32_MAX};
            float out[4];
            must(zt_sample(sampler, &p, 1, out, &diag), &diag);
            for (int c = 0; c < 4; c++)
                CHECK(finite ? isfinite(out[c]) != 0 : out[c] == 0);
        }
        zt_sampler_close(sampler);
    }
}

/* ---- threads ------------------------------------------------------------------------------------------ */

enum { POINTS = 1500, THREADS = 4 };

typedef struct job {
    const zt_sampler *sampler;
    const zt_point *points;
    float *out;
    zt_result result;
} job;

static void *run_job(void *user) {
    job *j = user;
    j->result = zt_sample(j->sampler, j->points, POINTS, j->out, NULL);
    return NULL;
}

static void check_threads(const scene *s) {
    zt_point *points = malloc(POINTS * sizeof *points);
    float *out = malloc((size_t)THREADS * POINTS * 4 * sizeof *out);
    uint64_t seed = 61;
    for (int i = 0; i < POINTS; i++)
        points[i] = random_point(&seed);
    for (int round = 0; round < 5; round++) {
        zt_sampler *sampler;
        zt_diag diag = {0};
        job jobs[THREADS];
        pthread_t threads[THREADS];
        must(zt_sampler_open(s->file, s->texture_count - 1, NULL, &diag, &sampler), &diag);
        for (int i = 0; i < THREADS; i++) {
            jobs[i] = (job){sampler, points, out + (size_t)i * POINTS * 4, ZT_INTERNAL};
            CHECK(pthread_create(&threads[i], NULL, run_job, &jobs[i]) == 0);
        }
        for (int i = 0; i < THREADS; i++) {
            CHECK(pthread_join(threads[i], NULL) == 0);
            CHECK(jobs[i].result == ZT_OK);
            CHECK(memcmp(out, jobs[i].out, POINTS * 4 * sizeof *out) == 0);
        }
        zt_sampler_close(sampler);
    }
    free(points);
    free(out);
}

/* ---- refusals ------------------------------------------------------------------------------------------ */

/* Each zipmap shows the one before it. */
static void check_depth(void) {
    uint64_t seed = 71;
    scene *s = scene_begin();
    uint32_t root = add_image(s, (zt_image_desc){.format = 43, .width = 4, .height = 4}, 0.5, &seed);
    for (uint32_t k = 0; k < MAX_TEXTURES; k++) {
        texture t = {.is_zipmap = true, .layer_count = 1, .patch_count = k == 0 ? 1 : 2};
        t.sources[0][0] = root;
        t.sources[1][0] = k - 1;
        t.patches[1].shows_texture = 1;
        for (int i = 0; i < 2; i++) {
            t.patches[i].mask = ZT_NONE;
            t.patches[i].matrix[0] = t.patches[i].matrix[4] = t.patches[i].matrix[8] = 1;
        }
        add_texture(s, &t);
    }
    for (uint32_t limit = 1; limit <= MAX_TEXTURES; limit++) {
        zt_limits limits = {.texture_depth = limit};
        zt_sampler *sampler;
        zt_diag diag = {0};
        scene_open(s, &limits);
        zt_result result = zt_sampler_open(s->file, MAX_TEXTURES - 1, NULL, &diag, &sampler);
        CHECK(result == (limit < MAX_TEXTURES - 1 ? ZT_LIMIT : ZT_OK));
        CHECK(result == ZT_OK || (diag.rule == 1011 && sampler == NULL));
        zt_sampler_close(sampler);
        zt_sampler_options alone = {.first_patch_only = 1};
        CHECK(zt_sampler_open(s->file, MAX_TEXTURES - 1, &alone, &diag, &sampler) == ZT_OK);
        zt_sampler_close(sampler);
    }
    scene_end(s);
}

static void check_refusals(void) {
    uint64_t seed = 81;
    scene *s = scene_begin();
    texture t = {.layer_count = 1};
    zt_diag diag = {0};
    uint32_t block;
    uint8_t bytes[8] = {0};
    t.images[0] = add_image(s, (zt_image_desc){.format = 109, .width = 512, .height = 512, .levels = 1}, 0.5, &seed);
    add_texture(s, &t);
    zt_image_desc desc = {.format = 131, .width = 4, .height = 4, .levels = 1, .given_levels = 1};
    must(zt_writer_add_image(s->writer, &desc, &diag, &block), &diag);
    must(zt_writer_put_level_rows(s->writer, block, 0, bytes, 1, 0, &diag), &diag);
    t.images[0] = block;
    add_texture(s, &t);
    zt_limits limits = {.memory = 3000000}; /* two tiles of 1 MiB and no third */
    scene_open(s, &limits);
    zt_sampler *sampler;
    zt_point p[3] = {{.u = 0.1, .v = 0.1}, {.u = 0.9, .v = 0.1}, {.u = 0.9, .v = 0.9}};
    float out[12];
    CHECK(zt_sampler_open(s->file, 1, NULL, &diag, &sampler) == ZT_UNSUPPORTED && sampler == NULL);
    CHECK(zt_sampler_open(s->file, 2, NULL, &diag, &sampler) == ZT_BAD_ARGUMENT);
    CHECK(zt_sampler_open(s->file, 0, &(zt_sampler_options){.layer = 1}, &diag, &sampler) == ZT_BAD_ARGUMENT);
    CHECK(zt_sampler_open(s->file, 0, &(zt_sampler_options){.max_anisotropy = 17}, &diag, &sampler) == ZT_BAD_ARGUMENT);
    CHECK(zt_sampler_open(s->file, 0, NULL, &diag, &sampler) == ZT_OK);
    CHECK(zt_sample(sampler, p, 1, out, &diag) == ZT_OK);
    CHECK(zt_sample(sampler, p, 3, out, &diag) == ZT_LIMIT);
    CHECK(zt_sample(sampler, p, 0, NULL, &diag) == ZT_OK);
    CHECK(zt_sample(sampler, NULL, 1, out, &diag) == ZT_BAD_ARGUMENT);
    zt_sampler_close(sampler);
    scene_end(s);
}

/* A sampler of one layer does not mind that another layer's images cannot be sampled, nor the mask's patch. */
static void check_other_layer(void) {
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    uint64_t seed = 91;
    uint8_t bytes[8] = {0};
    uint32_t block;
    float out[4];
    scene *s = scene_begin();
    zt_diag diag = {0};
    zt_image_desc desc = {.format = 131, .width = 4, .height = 4, .levels = 1, .given_levels = 1};
    must(zt_writer_add_image(s->writer, &desc, &diag, &block), &diag);
    must(zt_writer_put_level_rows(s->writer, block, 0, bytes, 1, 0, &diag), &diag);
    s->image_count++;
    uint32_t plain = add_image(s, (zt_image_desc){.format = 97, .width = 4, .height = 4}, 0.5, &seed);
    uint32_t mask = add_image(s, (zt_image_desc){.format = 9, .width = 4, .height = 4}, 1.0, &seed);
    texture t = {.is_zipmap = true, .layer_count = 2, .patch_count = 2};
    for (int i = 0; i < 2; i++) {
        t.sources[i][0] = block;
        t.sources[i][1] = plain;
        t.patches[i].mask = i == 0 ? ZT_NONE : mask;
        memcpy(t.patches[i].matrix, identity, sizeof identity);
    }
    add_texture(s, &t);
    scene_open(s, NULL);
    zt_point p = {.u = 0.5, .v = 0.5};
    sample_one(s->file, 0, &(zt_sampler_options){.layer = 1}, &p, out);
    CHECK(out[0] == 0.5f);
    zt_sampler *sampler;
    CHECK(zt_sampler_open(s->file, 0, NULL, &diag, &sampler) == ZT_UNSUPPORTED);
    scene_end(s);
}

static void check_shared_sampler(void) {
    uint64_t seed = 5;
    scene *s = scene_begin();
    texture t = {.wraps = {ZT_WRAP_REPEAT, ZT_WRAP_MIRROR, 0}};
    fill_zipmap(s, &t, 20, 0, &seed);
    add_texture(s, &t);
    scene_open(s, NULL);
    check_wild(s);
    check_threads(s);
    scene_end(s);
}

int main(void) {
    check_images();
    check_zipmaps();
    check_constant();
    check_opaque();
    check_depth();
    check_refusals();
    check_other_layer();
    check_shared_sampler();
    return test_end();
}
