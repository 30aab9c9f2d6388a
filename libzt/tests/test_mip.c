/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Mip levels: what a viewer sees of most texels most of the time. The streaming filter gives what filtering the whole
 * level at once gives; constants stay exact, averages are of light, transparent colour does not leak, normals stay
 * normal, borders stay zero.
 */
#include <math.h>
#include <stdbool.h>

#include "base_bytes.h"
#include "file_kernel.h"
#include "test.h"
#include "write_sink.h"

static zt_file *write_levels(const zt_image_desc *desc, const void *texels, memory_sink *s) {
    zt_sink sink = memory_sink_of(s);
    zt_writer_options options = {.effort = 1};
    zt_writer *w;
    zt_file *file;
    zt_diag diag = {0};
    uint32_t image, rows = desc->height * (desc->depth ? desc->depth : 1) * (desc->layers ? desc->layers : 1);
    CHECK(zt_writer_open_sink(&sink, &options, NULL, &w) == ZT_OK);
    CHECK(zt_writer_add_image(w, desc, &diag, &image) == ZT_OK);
    CHECK(zt_writer_put_rows(w, image, texels, rows, 0, &diag) == ZT_OK);
    zt_texture_desc t = {.image = image};
    CHECK(zt_writer_add_texture(w, &t, &diag, NULL) == ZT_OK);
    CHECK(zt_writer_finish(w, &diag) == ZT_OK);
    zt_writer_close(w);
    CHECK(zt_open_memory(s->data, s->size, NULL, &diag, &file) == ZT_OK);
    if (!file) {
        fprintf(stderr, "%s\n", diag.text);
        exit(1);
    }
    return file;
}

/* All slices of layer 0 of a level, allocated. */
static void *read_level(const zt_file *file, uint32_t level, zt_level_info *info) {
    CHECK(zt_get_level(file, 0, level, info) == ZT_OK);
    uint8_t *p = malloc(info->layer_size);
    CHECK(zt_decode_level(file, 0, level, 0, p, info->layer_size, 0, NULL, NULL) == ZT_OK);
    return p;
}

/* Texels are little-endian: the machine's floats to texels, or back. */
static void exchange_floats(float *v, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint32_t bits;
        memcpy(&bits, v + i, sizeof bits);
        zt__store32((uint8_t *)(v + i), bits);
    }
}

static uint32_t level_count(const zt_file *file) {
    zt_image_info info;
    zt_get_image(file, 0, &info);
    return info.levels;
}

static void end(zt_file *file, memory_sink *s) {
    zt_close(file);
    free(s->data);
}

/* ---- the reference ---- */

typedef struct volume {
    uint32_t n[3];
    float *v;
} volume;

/* Output texel i of the line of texels `step` apart. */
static float reference_texel(const zt__axis *a, const float *line, size_t step, uint32_t i) {
    float w[ZT__MAX_TAPS];
    double sum = 0;
    zt__axis_weights(a, i, w);
    for (uint32_t t = 0; t < a->taps; t++) {
        int64_t j = zt__axis_wrap(a, zt__axis_first(a, i) + t);
        sum += j < 0 ? 0.0 : (double)w[t] * (double)line[(size_t)j * step];
    }
    return (float)sum;
}

/* Filters along one axis: 0 is x. */
static volume reference_axis(const volume *in, int axis, uint8_t filter, uint8_t wrap) {
    zt__axis a;
    zt__axis_init(&a, in->n[axis], filter, wrap);
    volume out = *in;
    out.n[axis] = a.n2;
    size_t count = (size_t)out.n[0] * out.n[1] * out.n[2];
    size_t step = axis == 0 ? 1 : axis == 1 ? in->n[0] : (size_t)in->n[0] * in->n[1];
    out.v = malloc(sizeof(float) * count);
    for (size_t k = 0; k < count; k++) {
        size_t p[3] = {k % out.n[0], k / out.n[0] % out.n[1], k / out.n[0] / out.n[1]};
        uint32_t i = (uint32_t)p[axis];
        p[axis] = 0;
        out.v[k] = reference_texel(&a, in->v + (p[2] * in->n[1] + p[1]) * in->n[0] + p[0], step, i);
    }
    return out;
}

static volume reference_level(const volume *in, uint8_t filter, uint8_t wrap) {
    volume x = reference_axis(in, 0, filter, wrap), y = reference_axis(&x, 1, filter, wrap);
    volume z = reference_axis(&y, 2, filter, wrap);
    free(x.v);
    free(y.v);
    return z;
}

static void check_against_reference(uint32_t w, uint32_t h, uint32_t d, uint8_t filter, uint8_t wrap, uint64_t seed) {
    volume now = {{w, h, d}, calloc((size_t)w * h * d, sizeof(float))};
    for (size_t i = 0; i < (size_t)w * h * d; i++)
        now.v[i] = (float)test_uniform(&seed, -1, 1);
    zt_image_desc desc = {.format = 100,
                          .width = w,
                          .height = h,
                          .depth = d,
                          .mip_filter = filter,
                          .wrap_u = wrap,
                          .wrap_v = wrap,
                          .wrap_w = wrap,
                          .tile_edge = 16};
    memory_sink s;
    exchange_floats(now.v, (size_t)w * h * d);
    zt_file *file = write_levels(&desc, now.v, &s);
    exchange_floats(now.v, (size_t)w * h * d);
    double worst = 0;
    for (uint32_t level = 1; level < level_count(file); level++) {
        zt_level_info info;
        float *got = read_level(file, level, &info);
        exchange_floats(got, info.layer_size / 4);
        volume next = reference_level(&now, filter, wrap);
        CHECK(next.n[0] == info.width && next.n[1] == info.height && next.n[2] == info.depth);
        for (size_t i = 0; i < info.layer_size / 4; i++) { /* not fmax(): gcc 12 for aarch64 fails on it */
            double error = fabs((double)got[i] - (double)next.v[i]);
            worst = error > worst ? error : worst;
        }
        free(got);
        free(now.v);
        now = next;
    }
    CHECK(worst < 3e-6);
    if (worst >= 3e-6)
        fprintf(stderr, "%u x %u x %u filter %u wrap %u: %g\n", w, h, d, filter, wrap, worst);
    free(now.v);
    end(file, &s);
}

static void test_reference(void) {
    static const uint32_t sizes[][3] = {{64, 64, 1}, {1, 1, 1},    {2, 2, 1},    {3, 5, 1},    {1, 77, 1},
                                        {77, 1, 1},  {101, 67, 1}, {33, 200, 1}, {16, 16, 16}, {13, 22, 9},
                                        {5, 3, 31},  {1, 1, 17},   {2, 40, 3},   {7, 300, 2}};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++)
        for (uint8_t filter = 0; filter < 4; filter++)
            for (uint8_t wrap = 0; wrap < 4; wrap++)
                check_against_reference(sizes[i][0], sizes[i][1], sizes[i][2], filter, wrap,
                                        1 + i * 16 + filter * 4U + wrap);
}

/* ---- properties ---- */

static void check_constant(const zt_format_info *f, uint8_t filter, uint8_t wrap, uint32_t w, uint32_t h) {
    static const float colour[4] = {0.25f, 0.5f, 0.75f, 1.0f};
    uint8_t texel[16];
    uint64_t seed = 40 + filter;
    memory_sink s;
    CHECK(zt_pack_texels(f->format, colour, 1, texel) == ZT_OK);
    for (uint32_t i = 0; !f->is_float && i < f->block_bytes; i++)
        texel[i] = (uint8_t)(1 + test_below(&seed, 255));
    uint8_t *texels = malloc((size_t)w * h * f->block_bytes);
    for (size_t i = 0; i < (size_t)w * h; i++)
        memcpy(texels + i * f->block_bytes, texel, f->block_bytes);
    zt_image_desc desc = {.format = f->format,
                          .width = w,
                          .height = h,
                          .mip_filter = filter,
                          .wrap_u = wrap,
                          .wrap_v = wrap,
                          .alpha_mode = f->has_alpha ? ZT_ALPHA_STRAIGHT : ZT_ALPHA_NONE};
    zt_file *file = write_levels(&desc, texels, &s);
    for (uint32_t level = 0; level < level_count(file); level++) {
        zt_level_info info;
        uint8_t *got = read_level(file, level, &info);
        for (size_t i = 0; i < info.layer_size; i += f->block_bytes)
            CHECK(memcmp(got + i, texel, f->block_bytes) == 0);
        free(got);
    }
    end(file, &s);
    free(texels);
}

static void test_constant(void) {
    const zt_format_info *f;
    for (uint32_t i = 0; (f = zt_get_format(i)) != NULL && f->is_plain; i++)
        for (uint8_t filter = 0; filter < 4; filter++)
            for (uint8_t wrap = 0; wrap < 3; wrap++) {
                check_constant(f, filter, wrap, 37, 23);
                check_constant(f, filter, wrap, 64, 32);
            }
}

/* Half of the light is code 188 in sRGB and 128 in linear formats. */
static void check_checker(uint32_t format, uint8_t code) {
    uint8_t texels[64 * 64];
    memory_sink s;
    for (int i = 0; i < 64 * 64; i++)
        texels[i] = (i % 64 + i / 64) % 2 ? 255 : 0;
    for (uint8_t filter = 0; filter < 4; filter++) {
        zt_image_desc desc = {.format = format, .width = 64, .height = 64, .mip_filter = filter};
        zt_file *file = write_levels(&desc, texels, &s);
        zt_level_info info;
        uint8_t *got = read_level(file, 1, &info);
        for (int i = 0; i < 32 * 32; i++)
            CHECK(got[i] + 1 >= code && got[i] <= code + 1);
        free(got);
        end(file, &s);
    }
}

static void test_no_fringe(void) {
    static uint8_t texels[96 * 96 * 4];
    memory_sink s;
    for (int i = 0; i < 96 * 96; i++) {
        int x = i % 96 - 48, y = i / 96 - 48;
        bool in = x * x + y * y < 900;
        const uint8_t red[4] = {255, 0, 0, 255}, green[4] = {0, 255, 0, 0};
        memcpy(texels + 4 * i, in ? red : green, 4);
    }
    for (uint8_t filter = 0; filter < 4; filter++) {
        zt_image_desc desc = {
            .format = 43, .width = 96, .height = 96, .mip_filter = filter, .alpha_mode = ZT_ALPHA_STRAIGHT};
        zt_file *file = write_levels(&desc, texels, &s);
        for (uint32_t level = 1; level < level_count(file); level++) {
            zt_level_info info;
            uint8_t *got = read_level(file, level, &info);
            for (size_t i = 0; i < info.layer_size; i += 4)
                CHECK(got[i + 1] == 0 && got[i + 2] == 0 && (got[i + 3] == 0 || got[i] == 255));
            free(got);
        }
        end(file, &s);
    }
}

static double length_of(const zt_format_info *f, const uint8_t *texel) {
    float n[4];
    double square = 0;
    CHECK(zt_unpack_texels(f->format, texel, 1, n) == ZT_OK);
    for (int c = 0; c < 3; c++) {
        double v = f->is_float ? (double)n[c] : 2.0 * (double)n[c] - 1.0;
        square += v * v;
    }
    return sqrt(square);
}

static void check_normals(const zt_format_info *f) {
    enum { W = 50, H = 41 };
    static float rgba[W * H * 4];
    static uint8_t texels[W * H * 16];
    uint64_t seed = 9;
    memory_sink s;
    float scale = f->is_float ? 1.0f : 0.5f, shift = f->is_float ? 0.0f : 0.5f;
    for (size_t i = 0; i < W * H; i++) {
        double x = test_uniform(&seed, -0.7, 0.7), y = test_uniform(&seed, -0.7, 0.7), z = sqrt(1 - x * x - y * y);
        const float n[4] = {(float)x * scale + shift, (float)y * scale + shift, (float)z * scale + shift, 1};
        memcpy(rgba + 4 * i, n, sizeof n);
    }
    CHECK(zt_pack_texels(f->format, rgba, W * H, texels) == ZT_OK);
    zt_image_desc desc = {.format = f->format, .width = W, .height = H, .is_normal = 1};
    zt_file *file = write_levels(&desc, texels, &s);
    for (uint32_t level = 1; level < level_count(file); level++) {
        zt_level_info info;
        uint8_t *got = read_level(file, level, &info);
        for (size_t i = 0; i < info.layer_size; i += f->block_bytes)
            CHECK(fabs(length_of(f, got + i) - 1) < (f->channel_bits == 8 ? 0.008 : 1e-4));
        free(got);
    }
    end(file, &s);
}

/* With two channels the third is what the stored ones leave: a flat surface stays flat, a tilted one tilted. */
static void test_two_channels(void) {
    static float texels[2 * 32 * 32];
    memory_sink s;
    for (size_t i = 0; i < 32 * 32; i++)
        texels[2 * i] = i % 2 ? 0.6f : -0.6f;
    exchange_floats(texels, sizeof texels / sizeof *texels);
    zt_image_desc desc = {.format = 103, .width = 32, .height = 32, .is_normal = 1, .mip_filter = ZT_MIP_BOX};
    zt_file *file = write_levels(&desc, texels, &s);
    zt_level_info info;
    float *got = read_level(file, 1, &info);
    exchange_floats(got, info.layer_size / 4);
    for (size_t i = 0; i < info.layer_size / 4; i++)
        CHECK(fabs((double)got[i]) < 1e-6);
    free(got);
    end(file, &s);
}

static void test_normals(void) {
    static const uint32_t formats[] = {23, 37, 84, 106, 109};
    for (size_t k = 0; k < 5; k++)
        check_normals(zt_find_format(formats[k]));
    test_two_channels();
}

static void check_border(uint32_t format, zt_alpha alpha, uint32_t w, uint32_t h, uint8_t wrap, bool given) {
    const zt_format_info *f = zt_find_format(format);
    uint8_t *texels = malloc((size_t)w * h * f->block_bytes);
    memory_sink s;
    memset(texels, 0x3B, (size_t)w * h * f->block_bytes);
    zt_image_desc desc = {.format = format,
                          .width = w,
                          .height = h,
                          .alpha_mode = alpha,
                          .zero_border = 1,
                          .tile_edge = 16,
                          .wrap_u = wrap,
                          .wrap_v = wrap,
                          .given_levels = given,
                          .levels = given ? 1 : 0};
    zt_file *file = write_levels(&desc, texels, &s);
    for (uint32_t level = 0; level < level_count(file); level++) {
        zt_level_info info;
        uint8_t *got = read_level(file, level, &info);
        bool some = false;
        for (uint32_t i = 0; i < info.width * info.height; i++) {
            uint32_t x = i % info.width, y = i / info.width, cover = f->channels == 1 ? 0 : 3;
            float c[4];
            CHECK(zt_unpack_texels(format, got + (size_t)i * f->block_bytes, 1, c) == ZT_OK);
            if (x == 0 || y == 0 || x == info.width - 1 || y == info.height - 1)
                CHECK(c[cover] <= 0.0f && (alpha != ZT_ALPHA_PREMULTIPLIED || c[0] <= 0.0f));
            else
                some |= c[cover] > 0.0f;
        }
        CHECK(some || info.width < 5 || info.height < 5);
        free(got);
    }
    end(file, &s);
    free(texels);
}

static void test_border(void) {
    for (uint8_t wrap = 0; wrap < 4; wrap++) {
        check_border(43, ZT_ALPHA_STRAIGHT, 75, 201, wrap, false);
        check_border(97, ZT_ALPHA_PREMULTIPLIED, 201, 64, wrap, false);
        check_border(9, ZT_ALPHA_NONE, 40, 40, wrap, false);
        check_border(37, ZT_ALPHA_STRAIGHT, 33, 18, wrap, true);
    }
}

/* A ramp shows where a filter takes its texels from: shifted levels swim when a texture recedes. */
static void test_phase(void) {
    enum { W = 1013 };
    static float ramp[W];
    memory_sink s;
    for (int i = 0; i < W; i++)
        ramp[i] = (float)((i + 0.5) / W);
    exchange_floats(ramp, W);
    for (uint8_t filter = 0; filter < 4; filter++) {
        zt_image_desc desc = {.format = 100, .width = W, .height = 1, .mip_filter = filter, .wrap_u = ZT_WRAP_CLAMP};
        zt_file *file = write_levels(&desc, ramp, &s);
        for (uint32_t level = 1; level < 6; level++) {
            zt_level_info info;
            float *got = read_level(file, level, &info);
            exchange_floats(got, info.layer_size / 4);
            for (uint32_t x = 8; x + 8 < info.width; x++)
                CHECK(fabs((double)got[x] - (x + 0.5) / info.width) < 0.03 / info.width);
            free(got);
        }
        end(file, &s);
    }
}

/* A layer, a cube face or a frame knows nothing of the ones before it. */
static void test_layers(void) {
    enum { W = 53, H = 70, D = 5, SIZE = W * H * D };
    static const uint32_t depths[] = {1, D};
    static uint8_t texels[3 * SIZE];
    for (uint8_t k = 0; k < 8; k++) {
        uint32_t depth = depths[k % 2];
        size_t size = (size_t)W * H * depth;
        uint64_t seed = 6;
        memory_sink s;
        for (size_t i = 0; i < 3 * size; i++)
            texels[i] = i < size ? (uint8_t)test_random(&seed) : i < 2 * size ? 77 : texels[i - 2 * size];
        zt_image_desc desc = {.format = 9,
                              .width = W,
                              .height = H,
                              .depth = depth,
                              .layers = 3,
                              .tile_edge = 16,
                              .wrap_u = k / 2,
                              .wrap_v = k / 2,
                              .wrap_w = k / 2};
        zt_file *file = write_levels(&desc, texels, &s);
        for (uint32_t level = 0; level < level_count(file); level++) {
            zt_level_info info;
            uint8_t *first = read_level(file, level, &info), *last = malloc(info.layer_size);
            CHECK(zt_decode_level(file, 0, level, 2, last, info.layer_size, 0, NULL, NULL) == ZT_OK);
            CHECK(memcmp(first, last, info.layer_size) == 0);
            free(first);
            free(last);
        }
        end(file, &s);
    }
}

/* Whatever bits a float texture holds, its levels hold numbers: their bits would differ between machines otherwise. */
static void test_odd_floats(void) {
    static uint8_t texels[32 * 32 * 16];
    static const uint32_t formats[] = {76, 97, 100, 109, 123};
    for (size_t k = 0; k < 5; k++) {
        uint64_t seed = 77 + k;
        memory_sink s;
        for (size_t i = 0; i < sizeof texels; i++)
            texels[i] = (uint8_t)(test_random(&seed) >> 30);
        const zt_format_info *f = zt_find_format(formats[k]);
        zt_image_desc desc = {
            .format = formats[k], .width = 32, .height = 32, .alpha_mode = f->has_alpha ? ZT_ALPHA_STRAIGHT : 0};
        zt_file *file = write_levels(&desc, texels, &s);
        for (uint32_t level = 1; level < level_count(file); level++) {
            zt_level_info info;
            uint8_t *got = read_level(file, level, &info);
            for (size_t i = 0; i < info.layer_size; i += f->block_bytes) {
                float c[4];
                CHECK(zt_unpack_texels(f->format, got + i, 1, c) == ZT_OK);
                CHECK(isfinite(c[0]) && isfinite(c[1]) && isfinite(c[2]) && isfinite(c[3]));
            }
            free(got);
        }
        end(file, &s);
    }
}

int main(void) {
    test_reference();
    test_constant();
    check_checker(9, 128);
    check_checker(15, 188);
    test_no_fringe();
    test_normals();
    test_border();
    test_phase();
    test_layers();
    test_odd_floats();
    return test_end();
}
