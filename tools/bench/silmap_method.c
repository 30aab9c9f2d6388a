/* SPDX-License-Identifier: Apache-2.0 */
/* The contestants: each is written as a .ztex file, opened again and looked up through libzt's sampler. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <zt/zt_write.h>

#include "silmap_bench.h"

enum { R8_UNORM = 9, RGB8_UNORM = 23, RGB8_SRGB = 29 };

const char *const method_names[METHOD_KINDS] = {"bilinear", "sdf", "msdf", "silmap", "uncut"};

static void must(zt_result result, const zt_diag *diag) {
    if (result != ZT_OK)
        bench_fail(zt_result_text(result), diag->text);
}

/* ---- texels --------------------------------------------------------------------------------------------- */

/* Linear light to the bytes of a format. */
static uint8_t *code(uint32_t format, uint32_t channels, const float *linear, size_t count) {
    uint8_t *bytes = bench_alloc(count * channels, 1);
    for (size_t i = 0; i < count * channels; i++) {
        float value = format == RGB8_SRGB ? zt_transfer_encode(ZT_TRANSFER_SRGB, linear[i]) : linear[i];
        bytes[i] = (uint8_t)(fminf(fmaxf(value, 0), 1) * 255 + 0.5F);
    }
    return bytes;
}

/* A texture as it is made usually: each texel the mean over its square. */
static uint8_t *mean_texels(const truth *t, uint32_t format, uint32_t grid) {
    size_t texels = (size_t)grid * grid;
    float *linear = bench_alloc(texels * t->channels, sizeof *linear);
    truth_render(t, &(window){0, 0, 1, grid}, linear);
    uint8_t *bytes = code(format, t->channels, linear, texels);
    free(linear);
    return bytes;
}

/* ---- files ---------------------------------------------------------------------------------------------- */

static zt_result take_bytes(void *user, const void *data, size_t size) {
    method *m = user;
    m->bytes = realloc(m->bytes, m->file_size + size);
    if (!m->bytes)
        return ZT_NO_MEMORY;
    memcpy(m->bytes + m->file_size, data, size);
    m->file_size += size;
    return ZT_OK;
}

static uint32_t add_image(zt_writer *writer, uint32_t format, uint32_t edge, const uint8_t *texels) {
    zt_image_desc desc = {.format = format, .width = edge, .height = edge, .levels = 1};
    zt_diag diag = {0};
    uint32_t image;
    must(zt_writer_add_image(writer, &desc, &diag, &image), &diag);
    must(zt_writer_put_rows(writer, image, texels, edge, 0, &diag), &diag);
    return image;
}

static void add_silmap(zt_writer *writer, const author_silmap_result *silmap, uint32_t image) {
    zt_layer_desc layer = {ZT_SEMANTIC_BASE_COLOUR, 0};
    zt_texture_desc texture = {.wrap_u = ZT_WRAP_CLAMP, .wrap_v = ZT_WRAP_CLAMP, .layers = &layer, .layer_count = 1};
    zt_silmap_desc desc = {
        .cells_x = silmap->cells_x, .cells_y = silmap->cells_y, .cells = silmap->cells, .samples = &image};
    zt_diag diag = {0};
    must(zt_writer_add_silmap(writer, &texture, &desc, &diag, NULL), &diag);
}

static void write_file(method *m, int effort, uint32_t format, const uint8_t *texels,
                       const author_silmap_result *silmap) {
    zt_sink sink = {m, take_bytes};
    zt_writer_options options = {.effort = effort};
    zt_writer *writer;
    zt_diag diag = {0};
    must(zt_writer_open_sink(&sink, &options, &diag, &writer), &diag);
    uint32_t edge = silmap ? silmap->samples.width : m->grid;
    uint32_t image = add_image(writer, format, edge, texels);
    if (silmap)
        add_silmap(writer, silmap, image);
    else
        must(zt_writer_add_texture(writer,
                                   &(zt_texture_desc){.wrap_u = ZT_WRAP_CLAMP, .wrap_v = ZT_WRAP_CLAMP, .image = image},
                                   &diag, NULL),
             &diag);
    must(zt_writer_finish(writer, &diag), &diag);
    zt_writer_close(writer);
}

static void open_file(method *m) {
    zt_diag diag = {0};
    zt_chunk_info chunk;
    must(zt_open_memory(m->bytes, m->file_size, NULL, &diag, &m->file), &diag);
    must(zt_sampler_open(m->file, 0, NULL, &diag, &m->sampler), &diag);
    for (uint32_t i = 0; zt_get_chunk(m->file, i, &chunk) == ZT_OK; i++)
        if (memcmp(chunk.type, "SLMP", 4) == 0)
            m->cells_size = (size_t)chunk.stored_size;
}

method method_make(method_kind kind, const truth *t, uint32_t grid, int effort, const author_silmap_result *silmap) {
    method m = {.kind = kind, .grid = grid, .channels = kind == METHOD_SDF ? 1 : kind == METHOD_MSDF ? 3 : t->channels};
    int cells = kind == METHOD_SILMAP || kind == METHOD_UNCUT;
    uint32_t format = m.channels == 1 ? R8_UNORM : kind == METHOD_MSDF ? RGB8_UNORM : RGB8_SRGB;
    size_t texels = cells ? (size_t)silmap->samples.width * silmap->samples.height : (size_t)grid * grid;
    uint8_t *bytes;
    if (cells)
        bytes = code(format, m.channels, silmap->samples.texels, texels);
    else if (kind == METHOD_BILINEAR)
        bytes = mean_texels(t, format, grid);
    else {
        bytes = bench_alloc(texels, m.channels);
        (kind == METHOD_SDF ? sdf_make : msdf_make)(&t->outline, grid, bytes);
    }
    m.memory = texels * m.channels + (kind == METHOD_SILMAP ? (size_t)grid * grid : 0);
    write_file(&m, effort, format, bytes, cells ? silmap : NULL);
    open_file(&m);
    free(bytes);
    return m;
}

void method_release(method *m) {
    zt_sampler_close(m->sampler);
    zt_close(m->file);
    free(m->bytes);
    *m = (method){0};
}

/* ---- lookups -------------------------------------------------------------------------------------------- */

static double cpu_seconds(void) {
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static void look_up(method *m, const zt_point *points, size_t count, float *rgba) {
    zt_diag diag = {0};
    double begin = cpu_seconds();
    must(zt_sample(m->sampler, points, count, rgba, &diag), &diag);
    m->seconds += cpu_seconds() - begin;
    m->lookups += (double)count;
}

static float median(const float *v) {
    return fmaxf(fminf(v[0], v[1]), fminf(fmaxf(v[0], v[1]), v[2]));
}

/* Distance to the outline in texels of the field, more inside. */
static float field_distance(const method *m, const float *rgba) {
    if (m->kind == METHOD_MSDF)
        return (float)(2 * MSDF_RANGE) * (median(rgba) - 0.5F);
    return (float)(2 * SDF_RANGE) * (rgba[0] - 0.5F);
}

void method_render(method *m, const window *w, float *out) {
    double pixel = w->size / (double)w->pixels;
    int is_field = m->kind == METHOD_SDF || m->kind == METHOD_MSDF;
    float pixels_of_texel = (float)(1 / (pixel * m->grid));
    uint32_t channels = is_field ? 1 : m->channels;
    zt_point *points = bench_alloc(w->pixels, sizeof *points);
    float *rgba = bench_alloc(w->pixels, 4 * sizeof *rgba);
    for (size_t y = 0; y < w->pixels; y++) {
        for (size_t x = 0; x < w->pixels; x++) {
            points[x] = (zt_point){.u = w->x + ((double)x + 0.5) * pixel, .v = w->y + ((double)y + 0.5) * pixel};
            points[x].du_dx = points[x].dv_dy = pixel;
        }
        look_up(m, points, w->pixels, rgba);
        for (size_t x = 0; x < w->pixels; x++, out += channels) {
            if (is_field)
                out[0] = fminf(fmaxf(field_distance(m, rgba + 4 * x) * pixels_of_texel + 0.5F, 0), 1);
            else
                memcpy(out, rgba + 4 * x, channels * sizeof *out);
        }
    }
    free(points);
    free(rgba);
}

void method_row(method *m, double y, double x0, double dx, size_t count, uint8_t *inside) {
    zt_point *points = bench_alloc(count, sizeof *points);
    float *rgba = bench_alloc(count, 4 * sizeof *rgba);
    for (size_t i = 0; i < count; i++)
        points[i] = (zt_point){.u = x0 + (double)i * dx, .v = y};
    look_up(m, points, count, rgba);
    for (size_t i = 0; i < count; i++)
        inside[i] = (m->kind == METHOD_MSDF ? median(rgba + 4 * i) : rgba[4 * i]) > 0.5F;
    free(points);
    free(rgba);
}
