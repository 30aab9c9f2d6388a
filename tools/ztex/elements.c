/* SPDX-License-Identifier: Apache-2.0 */
#include "elements.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define VERTICES_LOOKED_AT (UINT32_C(1) << 26)
#define UNKNOWN_GREY 0.2f /* linear light, of pictures that cannot be unpacked */

/* ---- one umbrella ------------------------------------------------------------------------------------------- */

float element_offset(uint8_t stored) {
    int q = stored < 128 ? stored : stored - 256;
    q = q < -127 ? -127 : q;
    return (float)(q * abs(q)) / (127.0f * 127.0f);
}

static void take_offsets(const zt_umbrella_colour *from, uint32_t count, float weight, element *out) {
    for (uint32_t i = 0; i < count; i++) {
        out->colours[i][0] += weight * element_offset(from[i].r);
        out->colours[i][1] += weight * element_offset(from[i].g);
        out->colours[i][2] += weight * element_offset(from[i].b);
    }
}

/* The picture's place of a vertex less the centre, in widths of the picture. */
static void from_centre(const zt_umbrella_base *base, zt_umbrella_texel at, double out[2]) {
    out[0] = ((double)at.x - base->centre.x) / 65535;
    out[1] = ((double)at.y - base->centre.y) / 65535 * base->aspect / 65536;
}

static void place_base(const zt_umbrella_info *info, element *out) {
    const zt_umbrella *u = out->record;
    const zt_umbrella_base *base = out->base;
    double a = u->a / 65536.0, b = u->b / 65536.0, morph = u->morph / 255.0;
    out->count = base->vertex_count;
    for (uint32_t i = 0; i < out->count; i++) {
        double d[2], e[2] = {0, 0};
        from_centre(base, info->base_vertices[base->first_vertex + i], d);
        if (base->first_morph != ZT_NONE)
            from_centre(base, info->morph_vertices[base->first_morph + i], e);
        for (int c = 0; c < 2 && base->first_morph != ZT_NONE; c++)
            d[c] += morph * (e[c] - d[c]);
        d[0] = u->mirrored ? -d[0] : d[0];
        out->points[i][0] = a * d[0] - b * d[1];
        out->points[i][1] = b * d[0] + a * d[1];
    }
    if (base->variant_count == 0)
        return;
    const zt_umbrella_colour *variants = info->variant_colours + base->first_colour;
    float weight = u->variant_weight / 255.0f;
    take_offsets(variants + (size_t)u->variant_0 * (1 + out->count), 1 + out->count, 1.0f - weight, out);
    take_offsets(variants + (size_t)u->variant_1 * (1 + out->count), 1 + out->count, weight, out);
}

static void place_own(const zt_umbrella_info *info, uint32_t bits, element *out) {
    const zt_umbrella *u = out->record;
    const zt_umbrella_colour *colours = info->explicit_colours + u->first_colour;
    out->count = u->vertex_count;
    for (uint32_t i = 0; i < out->count; i++) {
        const zt_umbrella_offset *at = &info->explicit_vertices[u->first_vertex + i];
        out->points[i][0] = ldexp(at->x, -(int)bits);
        out->points[i][1] = ldexp(at->y, -(int)bits);
    }
    if (out->base) {
        take_offsets(colours, 1 + out->count, 1.0f, out);
        return;
    }
    for (uint32_t i = 0; i <= out->count; i++) {
        float rgb[3] = {colours[i].r / 255.0f, colours[i].g / 255.0f, colours[i].b / 255.0f};
        for (int c = 0; c < 3; c++)
            out->colours[i][c] = rgb[c] * rgb[c];
    }
}

static void show_picture(const zt_umbrella_info *info, element *out) {
    const zt_umbrella_base *base = out->base;
    for (uint32_t i = 0; i <= out->count; i++) {
        zt_umbrella_texel at = i ? info->base_vertices[base->first_vertex + i - 1] : base->centre;
        out->picture[i][0] = at.x / 65535.0;
        out->picture[i][1] = at.y / 65535.0;
        for (int c = 0; c < 3; c++)
            out->colours[i][c] *= out->record->strength / 255.0f;
    }
}

static void raise_surface(const zt_umbrella_info *info, element *out) {
    const zt_umbrella *u = out->record;
    int own = u->ellipsoid != ZT_ELLIPSOID_OF_BASE || !out->base;
    unsigned kind = own ? u->ellipsoid : out->base->ellipsoid;
    unsigned height = own ? u->height : out->base->height, curvature = own ? u->curvature : out->base->curvature;
    double unit = (double)info->prism_height / 65535;
    out->lift = u->lift * unit;
    out->height = kind == ZT_ELLIPSOID_FLAT ? 0 : height * unit;
    out->curvature = (curvature + 1) / 65536.0;
    out->concave = kind == ZT_ELLIPSOID_CONCAVE;
}

void element_of(const zt_umbrella_info *info, uint32_t level, uint32_t index, element *out) {
    const zt_umbrella_level *l = &info->levels[level];
    const zt_umbrella *u = &info->umbrellas[l->first_umbrella + index];
    out->record = u;
    out->base = u->form == ZT_UMBRELLA_COLOURED ? NULL : &info->bases[u->base];
    out->x = u->x / 65536.0;
    out->y = u->y / 65536.0;
    memset(out->colours, 0, (1 + (size_t)element_vertices(info, u)) * sizeof *out->colours);
    if (u->form == ZT_UMBRELLA_PARAMETRIC)
        place_base(info, out);
    else
        place_own(info, l->bits, out);
    if (out->base)
        show_picture(info, out);
    raise_surface(info, out);
}

void element_box(const element *e, double box[4]) {
    for (int c = 0; c < 2; c++) {
        box[c] = INFINITY;
        box[2 + c] = -INFINITY;
        for (uint32_t i = 0; i < e->count; i++) {
            double at = (c ? e->y : e->x) + e->points[i][c];
            box[c] = fmin(box[c], at);
            box[2 + c] = fmax(box[2 + c], at);
        }
    }
}

/* ---- pictures ----------------------------------------------------------------------------------------------- */

int element_picture(const zt_file *file, const zt_umbrella_base *base, uint32_t *width, uint32_t *height) {
    zt_layer_info layer = {.image = base->source};
    zt_image_info image;
    if (base->shows_texture && zt_get_layer(file, base->source, 0, &layer) != ZT_OK)
        return -1;
    if (layer.image == ZT_NONE || zt_get_image(file, layer.image, &image) != ZT_OK)
        return -1;
    *width = image.width;
    *height = image.height;
    return 0;
}

static void note_scale(double range[3], double scale, uint32_t count) {
    range[0] = count ? fmin(range[0], scale) : scale;
    range[1] += scale;
    range[2] = fmax(range[2], scale);
}

uint32_t element_vertices(const zt_umbrella_info *info, const zt_umbrella *u) {
    return u->form == ZT_UMBRELLA_PARAMETRIC ? info->bases[u->base].vertex_count : u->vertex_count;
}

uint64_t element_all_vertices(const zt_umbrella_info *info, uint32_t level) {
    const zt_umbrella_level *l = &info->levels[level];
    uint64_t total = 0;
    for (uint32_t i = 0; i < l->umbrella_count; i++)
        total += element_vertices(info, &info->umbrellas[l->first_umbrella + i]);
    return total;
}

void element_scale_of(const zt_file *file, const zt_umbrella_info *info, element_scale *out) {
    element *e = malloc(sizeof *e);
    uint32_t count = 0, width, height, number = info->levels[0].umbrella_count;
    /* A small file can have very many vertices: of such ones a part tells enough. */
    uint32_t step = 1 + (uint32_t)(element_all_vertices(info, 0) / VERTICES_LOOKED_AT);
    *out = (element_scale){{0}, {0}};
    for (uint32_t i = 0; e && i<number; i += number - i> step ? step : number - i) {
        double box[4];
        element_of(info, 0, i, e);
        if (!e->base || element_picture(file, e->base, &width, &height) != 0)
            continue;
        element_box(e, box);
        note_scale(out->across, width / (box[2] - box[0]), count);
        note_scale(out->down, height / (box[3] - box[1]), count);
        count++;
    }
    out->across[1] /= count ? count : 1;
    out->down[1] /= count ? count : 1;
    free(e);
}

/* The smallest level of an image, averaged. */
static zt_result image_mean(const zt_file *file, uint32_t number, float rgba[4], zt_diag *diag) {
    zt_image_info image;
    zt_level_info level;
    zt_result result = zt_get_image(file, number, &image);
    if (result != ZT_OK)
        return result;
    zt_get_level(file, number, image.levels - 1, &level);
    size_t count = (size_t)level.width * level.height, size = (size_t)level.slice_size;
    unsigned char *bytes = malloc(size);
    float *texels = malloc(count * 4 * sizeof *texels);
    result = bytes && texels ? zt_decode_level(file, number, image.levels - 1, 0, bytes, size, 0, NULL, diag)
                             : ZT_NO_MEMORY;
    if (result == ZT_OK)
        result = zt_unpack_texels(image.format, bytes, count, texels);
    for (size_t i = 0; result == ZT_OK && i < count; i++) {
        float *t = texels + 4 * i, alpha = image.alpha_mode == ZT_ALPHA_NONE ? 1.0f : t[3];
        if (zt_find_format(image.format)->channels == 1)
            t[1] = t[2] = t[0];
        float times = image.alpha_mode == ZT_ALPHA_STRAIGHT ? alpha : 1.0f;
        for (int c = 0; c < 3; c++)
            rgba[c] += zt_transfer_decode(image.transfer, t[c]) * times / (float)count;
        rgba[3] += alpha / (float)count;
    }
    free(bytes);
    free(texels);
    return result;
}

static zt_result texture_mean(const zt_file *file, uint32_t texture, float rgba[4], zt_diag *diag) {
    zt_sampler_options how = {.size = sizeof how};
    zt_point all = {.u = 0.5, .v = 0.5, .du_dx = 1, .dv_dy = 1};
    zt_sampler *sampler = NULL;
    zt_result result = zt_sampler_open(file, texture, &how, diag, &sampler);
    if (result == ZT_OK)
        result = zt_sample(sampler, &all, 1, rgba, diag);
    zt_sampler_close(sampler);
    return result;
}

zt_result element_mean(const zt_file *file, const zt_umbrella_base *base, float rgb[3], zt_diag *diag) {
    float rgba[4] = {0};
    zt_result result = base->shows_texture ? texture_mean(file, base->source, rgba, diag)
                                           : image_mean(file, base->source, rgba, diag);
    for (int c = 0; c < 3; c++)
        rgb[c] = rgba[3] > 0.0f ? rgba[c] / rgba[3] : 0.0f;
    if (result != ZT_UNSUPPORTED)
        return result;
    for (int c = 0; c < 3; c++)
        rgb[c] = UNKNOWN_GREY;
    return ZT_OK;
}
