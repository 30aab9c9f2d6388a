/* SPDX-License-Identifier: Apache-2.0 */
/* A silmap into the writer: the fit, then samples and minified image of each layer, then the cells. */
#include "silmap.h"

#include <stdlib.h>
#include <string.h>

#include "make_author.h"

typedef struct storing {
    make_store *store;
    const make_texture *texture;
    uint32_t samples[MAKE_LAYERS], minified[MAKE_LAYERS];
} storing;

/* How the texels of a layer are kept. */
typedef struct coding {
    const zt_format_info *format;
    zt_alpha alpha;
    uint32_t transfer, primaries;
    int alpha_channel; /* of the picture, or -1 */
} coding;

/* ---- formats ------------------------------------------------------------------------------------------------ */

static int complain(const storing *s, const char *text) {
    return make_complain(s->store->scene, s->texture->pointer, "%s", text);
}

static int fail_writer(const storing *s, zt_result result, const zt_diag *diag) {
    const make_scene *scene = s->store->scene;
    char name[512];
    snprintf(name, sizeof name, "%s%s%s", scene->name ? scene->name : "make silmap", scene->name ? ": " : "",
             scene->name ? s->texture->pointer : "");
    return cmd_fail_result(name, result, diag);
}

static int choose_coding(const storing *s, uint32_t layer, const silmap_source *source, coding *c) {
    const make_options *o = &s->texture->images[layer]->options;
    int colour = !source->plain, channels = (int)source->picture.channels;
    int has_alpha = colour && (channels == 2 || channels == 4);
    /* Formats with alpha have four channels. */
    int wanted = has_alpha ? 4 : channels;
    if (has_alpha && o->alpha == ZT_ALPHA_NONE)
        wanted = channels - 1;
    uint32_t number = o->format ? o->format : make_usual_format(source->type, wanted, colour);
    *c = (coding){.format = zt_find_format(number), .alpha_channel = has_alpha ? channels - 1 : -1};
    if (!c->format || !c->format->is_plain)
        return complain(s, "this format is stored only: ztex does not compress texels into blocks");
    if (c->format->is_srgb && !colour)
        return complain(s, "an SRGB format is for colours, not for values: take the UNORM format");
    c->transfer = colour && !c->format->is_float ? 13 : 8;
    c->primaries = colour && o->primaries != MAKE_UNSET ? (uint32_t)o->primaries : 0;
    if (c->format->has_alpha && colour && o->alpha != ZT_ALPHA_NONE && (has_alpha || o->alpha != MAKE_UNSET))
        c->alpha = o->alpha == ZT_ALPHA_PREMULTIPLIED ? ZT_ALPHA_PREMULTIPLIED : ZT_ALPHA_STRAIGHT;
    if (has_alpha && o->alpha == MAKE_UNSET && c->alpha == ZT_ALPHA_NONE)
        cmd_warn(s->store->args, "%s: %s has no room for the alpha", s->texture->images[layer]->files[0].path,
                 c->format->name);
    return CMD_OK;
}

/* ---- images ------------------------------------------------------------------------------------------------- */

static void code_row(const coding *c, const author_picture *picture, uint32_t y, float *rgba) {
    uint32_t channels = picture->channels, colours = channels - (c->alpha_channel >= 0);
    const float *from = picture->texels + (size_t)y * picture->width * channels;
    for (uint32_t x = 0; x < picture->width; x++, from += channels, rgba += 4) {
        float alpha = c->alpha_channel >= 0 ? from[c->alpha_channel] : 1.0f;
        for (uint32_t k = 0; k < 4; k++) {
            /* Grey is red, green and blue where these are wanted. */
            uint32_t channel = k < colours ? k : colours == 1 && k < 3 ? 0 : channels;
            float value = channel < channels ? from[channel] : k == 3 ? 1.0f : 0.0f;
            rgba[k] = zt_transfer_encode(c->transfer, c->alpha == ZT_ALPHA_PREMULTIPLIED ? value * alpha : value);
        }
        if (c->alpha_channel >= 0)
            rgba[3] = alpha;
    }
}

static int put_rows(const storing *s, const coding *c, const author_picture *picture, uint32_t image) {
    float *rgba = malloc((size_t)picture->width * 4 * sizeof *rgba);
    unsigned char *row = malloc((size_t)picture->width * c->format->block_bytes);
    int status = rgba && row ? CMD_OK : cmd_fail(CMD_INTERNAL, "out of memory");
    for (uint32_t y = 0; status == CMD_OK && y < picture->height; y++) {
        zt_diag diag = {.offset = UINT64_MAX};
        code_row(c, picture, y, rgba);
        zt_result result = zt_pack_texels(c->format->format, rgba, picture->width, row);
        if (result == ZT_OK)
            result = zt_writer_put_rows(s->store->writer, image, row, 1, 0, &diag);
        if (result != ZT_OK)
            status = fail_writer(s, result, &diag);
    }
    free(rgba);
    free(row);
    return status;
}

/* levels 0: all */
static int put_image(const storing *s, uint32_t layer, const coding *c, const author_picture *picture, uint32_t levels,
                     uint32_t *image) {
    const make_options *o = &s->texture->images[layer]->options;
    zt_diag diag = {.offset = UINT64_MAX};
    zt_image_desc desc = {.format = c->format->format,
                          .width = picture->width,
                          .height = picture->height,
                          .levels = levels,
                          .tile_edge = o->tile_edge > 0 ? (uint32_t)o->tile_edge : 0,
                          .alpha_mode = c->alpha,
                          .primaries = (uint8_t)c->primaries,
                          .transfer = (uint8_t)c->transfer,
                          .mip_filter = o->mip_filter > 0 ? (uint8_t)o->mip_filter : 0,
                          .wrap_u = s->texture->wrap[0],
                          .wrap_v = s->texture->wrap[1],
                          .wrap_w = s->texture->wrap[2],
                          .is_normal = s->texture->semantics[layer] == ZT_SEMANTIC_NORMAL};
    zt_result result = zt_writer_add_image(s->store->writer, &desc, &diag, image);
    return result == ZT_OK ? put_rows(s, c, picture, *image) : fail_writer(s, result, &diag);
}

static int put_layer(storing *s, uint32_t layer, const coding *c, const author_picture *samples,
                     const author_picture *minified) {
    const make_options *o = &s->texture->images[layer]->options;
    s->minified[layer] = ZT_NONE;
    int status = put_image(s, layer, c, samples, 1, &s->samples[layer]);
    if (status == CMD_OK && !s->texture->silmap->no_minified)
        status = put_image(s, layer, c, minified, o->levels > 0 ? (uint32_t)o->levels : 0, &s->minified[layer]);
    return status;
}

/* ---- layers ------------------------------------------------------------------------------------------------- */

static int fit(storing *s, const silmap_source *source, author_silmap_result *out) {
    const make_silmap *silmap = s->texture->silmap;
    author_silmap_input input = {.picture = &source->picture,
                                 .paths = source->paths,
                                 .path_count = source->path_count,
                                 .paths_only = silmap->edges_only,
                                 .repeat_x = s->texture->wrap[0] == ZT_WRAP_REPEAT,
                                 .repeat_y = s->texture->wrap[1] == ZT_WRAP_REPEAT};
    author_silmap_options options = {.cells_x = source->cells_x,
                                     .cells_y = source->cells_y,
                                     .quality = silmap->quality,
                                     .filter = silmap->filter,
                                     .plain = source->plain};
    make_stages stages;
    author_run run = make_author_run(s->store->args, &stages);
    author_result result = author_silmap_fit(&run, &input, &options, out);
    make_stages_end(&stages);
    if (result == AUTHOR_BAD_INPUT)
        return make_complain(s->store->scene, s->texture->pointer, "%s: %s", s->texture->images[0]->files[0].path,
                             run.error);
    return make_author_status(result, &run);
}

static int put_other_layer(storing *s, uint32_t layer, const author_silmap_result *cells) {
    silmap_source source;
    author_picture samples = {0}, minified = {0};
    author_run run = {0};
    coding c;
    int status = silmap_layer_load(s->store, s->texture, layer, cells, &source);
    if (status != CMD_OK)
        return status;
    status = choose_coding(s, layer, &source, &c);
    if (status == CMD_OK)
        status = make_author_status(silmap_layer_fit(&run, &source.picture, cells, &samples, &minified), &run);
    if (status == CMD_OK)
        status = put_layer(s, layer, &c, &samples, &minified);
    author_picture_release(&samples);
    author_picture_release(&minified);
    silmap_source_release(&source);
    return status;
}

static int put_texture(const storing *s, const author_silmap_result *cells) {
    const make_texture *texture = s->texture;
    zt_layer_desc layers[MAKE_LAYERS];
    zt_diag diag = {.offset = UINT64_MAX};
    zt_texture_desc desc = make_describe(texture, NULL, layers);
    zt_silmap_desc silmap = {.cells_x = cells->cells_x,
                             .cells_y = cells->cells_y,
                             .filter = texture->silmap->filter,
                             .cells = cells->cells,
                             .samples = s->samples,
                             .minified = texture->silmap->no_minified ? NULL : s->minified};
    zt_result result = zt_writer_add_silmap(s->store->writer, &desc, &silmap, &diag, NULL);
    return result == ZT_OK ? CMD_OK : fail_writer(s, result, &diag);
}

static void tell(const storing *s, const author_silmap_result *fit) {
    cmd_verbose(s->store->args, "%s: %u x %u cells, %llu cut; %.1f dB, a bilinear texture of the same grid %.1f dB",
                s->texture->name, (unsigned)fit->cells_x, (unsigned)fit->cells_y, (unsigned long long)fit->cut_cells,
                fit->psnr, fit->box_psnr);
    if (fit->thin_cells > 0)
        cmd_note(s->store->args, "%s: %llu of %u x %u cells have features thinner than a cell, which cannot be held",
                 s->texture->name, (unsigned long long)fit->thin_cells, (unsigned)fit->cells_x, (unsigned)fit->cells_y);
}

int make_store_silmap(make_store *store, const make_texture *texture, uint32_t *width, uint32_t *height) {
    storing s = {.store = store, .texture = texture};
    silmap_source source;
    author_silmap_result cells = {0};
    coding c;
    int status = silmap_source_load(store, texture, &source);
    if (status != CMD_OK)
        return status;
    status = choose_coding(&s, 0, &source, &c);
    if (status == CMD_OK)
        status = fit(&s, &source, &cells);
    if (status == CMD_OK) {
        tell(&s, &cells);
        status = put_layer(&s, 0, &c, &cells.samples, &cells.minified);
    }
    for (uint32_t i = 1; status == CMD_OK && i < texture->layer_count; i++)
        status = put_other_layer(&s, i, &cells);
    if (status == CMD_OK)
        status = put_texture(&s, &cells);
    *width = cells.cells_x;
    *height = cells.cells_y;
    if (status == CMD_OK && texture->silmap->made) {
        *texture->silmap->made = (silmap_made){cells, source.picture.width, source.picture.height};
        cells = (author_silmap_result){0};
    }
    author_silmap_release(&cells);
    silmap_source_release(&source);
    return status;
}
