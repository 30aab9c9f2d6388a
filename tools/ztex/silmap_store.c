/* SPDX-License-Identifier: Apache-2.0 */
/* A silmap into the writer, frame by frame: the fit, then samples and minified image of each layer; at last the
 * cells. */
#include "silmap.h"

#include <stdlib.h>
#include <string.h>

#include "make_author.h"

#define FRAMES (1 << 16) /* the format's limit on layers of cells */

/* How the texels of a layer are kept. */
typedef struct coding {
    const zt_format_info *format;
    zt_alpha alpha;
    uint32_t transfer, primaries;
    int alpha_channel; /* of the picture, or -1 */
} coding;

typedef struct storing {
    make_store *store;
    const make_texture *texture;
    silmap_trial trial;
    uint32_t frames;             /* 1: no animation */
    zt_layer_kind kind;          /* of several */
    int keep_alpha[MAKE_LAYERS]; /* one of its frames is not opaque */
    coding codings[MAKE_LAYERS];
    uint32_t samples[MAKE_LAYERS], minified[MAKE_LAYERS]; /* images of the writer */
    uint8_t *cells;                                       /* of all frames that have been fitted */
    int differ;                                           /* these cells do */
    uint64_t thin_cells;
} storing;

/* What a frame is made of, and its cells. */
typedef struct fitted {
    silmap_source source;
    author_silmap_result cells;
} fitted;

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

static int choose_coding(storing *s, uint32_t layer, const silmap_source *source) {
    coding *c = &s->codings[layer];
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
    c->transfer = colour && !c->format->is_float ? ZT_TRANSFER_SRGB : ZT_TRANSFER_LINEAR;
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
static int add_image(const storing *s, uint32_t layer, const author_picture *picture, uint32_t levels,
                     uint32_t *image) {
    const coding *c = &s->codings[layer];
    const make_options *o = &s->texture->images[layer]->options;
    zt_diag diag = {.offset = UINT64_MAX};
    zt_image_desc desc = {.format = c->format->format,
                          .width = picture->width,
                          .height = picture->height,
                          .layers = s->frames,
                          .layer_kind = s->kind,
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
    return result == ZT_OK ? CMD_OK : fail_writer(s, result, &diag);
}

/* Frames come in their order. */
static int put_layer(storing *s, uint32_t layer, uint32_t frame, const author_picture *samples,
                     const author_picture *minified) {
    const coding *c = &s->codings[layer];
    const make_options *o = &s->texture->images[layer]->options;
    int has_minified = !s->texture->silmap->no_minified, status = CMD_OK;
    if (frame == 0) {
        s->minified[layer] = ZT_NONE;
        status = add_image(s, layer, samples, 1, &s->samples[layer]);
    }
    if (status == CMD_OK && frame == 0 && has_minified)
        status = add_image(s, layer, minified, o->levels > 0 ? (uint32_t)o->levels : 0, &s->minified[layer]);
    if (status == CMD_OK)
        status = put_rows(s, c, samples, s->samples[layer]);
    if (status == CMD_OK && has_minified)
        status = put_rows(s, c, minified, s->minified[layer]);
    return status;
}

/* ---- frames ------------------------------------------------------------------------------------------------- */

static int count_frames(storing *s) {
    const make_texture *texture = s->texture;
    s->frames = 1;
    for (uint32_t i = 0; i < texture->layer_count; i++) {
        const make_image *image = texture->images[i];
        if (image->volume || image->layer_kind == ZT_LAYERS_CUBE || image->all_subimages || image->file_count > FRAMES)
            return make_complain(s->store->scene, image->pointer,
                                 "a silmap is made of a picture, or of up to %d 'files' that are frames", FRAMES);
        if (image->file_count > 1 && s->frames > 1 && image->file_count != s->frames)
            return make_complain(s->store->scene, image->pointer,
                                 "%u frames, another layer has %u: a layer has as many as the others, or one",
                                 (unsigned)image->file_count, (unsigned)s->frames);
        if (image->file_count == 1)
            continue;
        s->frames = (uint32_t)image->file_count;
        s->kind = (zt_layer_kind)image->layer_kind;
    }
    if (texture->images[0]->file_count > 1 && texture->silmap->quality > 0)
        return make_complain(s->store->scene, texture->pointer, "frames share one grid: say how many 'cells' it has");
    return CMD_OK;
}

static int has_alpha(const author_picture *picture) {
    return picture->channels == 2 || picture->channels == 4;
}

/* any_alpha: either may have it or not. */
static int is_alike(const author_picture *a, const author_picture *b, int any_alpha) {
    uint32_t own = any_alpha && has_alpha(a), other = any_alpha && has_alpha(b);
    return a->width == b->width && a->height == b->height && a->channels - own == b->channels - other;
}

/* Before the long work: whether the pictures of a layer go together. cells: of the grid; set by the first layer. */
static int look_at_frames(storing *s, uint32_t layer, uint32_t cells[2]) {
    const make_image *image = s->texture->images[layer];
    author_picture first = {0};
    int colours = (layer > 0 || s->texture->silmap->mask == SILMAP_COLOURS) &&
                  make_is_colour(s->texture->semantics[layer]);
    int status = CMD_OK;
    for (uint32_t frame = 0; status == CMD_OK && frame < image->file_count; frame++) {
        silmap_pick pick = {layer, frame, 0, layer ? cells[0] : 0, layer ? cells[1] : 0};
        silmap_source source;
        status = silmap_source_load(s->store, s->texture, &pick, &source);
        if (status != CMD_OK)
            break;
        const author_picture *picture = &source.picture;
        s->keep_alpha[layer] |= colours && has_alpha(picture);
        if (frame == 0) {
            first = (author_picture){picture->width, picture->height, picture->channels, NULL};
            cells[0] = source.cells_x;
            cells[1] = source.cells_y;
        }
        if (!is_alike(&first, picture, colours))
            status = make_complain(s->store->scene, image->pointer,
                                   "%s would be %u x %u texels of %u channels, the first frame is %u x %u of %u: "
                                   "frames are of one size and kind",
                                   image->files[frame].path, (unsigned)picture->width, (unsigned)picture->height,
                                   (unsigned)picture->channels, (unsigned)first.width, (unsigned)first.height,
                                   (unsigned)first.channels);
        silmap_source_release(&source);
    }
    return status;
}

static int check_frames(storing *s) {
    uint32_t cells[2] = {0, 0};
    int status = count_frames(s);
    for (uint32_t i = 0; status == CMD_OK && s->frames > 1 && i < s->texture->layer_count; i++)
        if (i == 0 || s->texture->images[i]->file_count > 1)
            status = look_at_frames(s, i, cells);
    if (status == CMD_OK && s->frames > 1 && (uint64_t)cells[0] * cells[1] * s->frames > UINT32_MAX)
        return complain(s, "there are too many cells in all frames together");
    return status;
}

static int keep_cells(storing *s, uint32_t frame, const author_silmap_result *cells) {
    size_t count = (size_t)cells->cells_x * cells->cells_y;
    uint8_t *all = realloc(s->cells, (frame + 1) * count);
    if (!all)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    s->cells = all;
    memcpy(all + frame * count, cells->cells, count);
    s->differ |= memcmp(all, cells->cells, count) != 0;
    s->thin_cells += cells->thin_cells;
    return CMD_OK;
}

/* ---- layers ------------------------------------------------------------------------------------------------- */

static int fit(storing *s, const silmap_source *source, author_silmap_result *out) {
    const make_silmap *silmap = s->texture->silmap;
    author_silmap_input input = {.picture = &source->picture,
                                 .paths = source->paths,
                                 .path_count = source->path_count,
                                 .shapes = source->shapes,
                                 .shape_count = source->shape_count,
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

/* Once more where hinting would have it; *source and *out are then the better ones. */
static int try_hint(storing *s, silmap_source *source, author_silmap_result *out) {
    silmap_source moved;
    author_silmap_result other = {0};
    silmap_trial *trial = &s->trial;
    int status = silmap_source_hint(s->store, s->texture, source, &moved);
    *trial = (silmap_trial){.wanted = 1, .psnr = {out->psnr}, .disagreement = {out->disagreement}};
    if (status != CMD_OK || !moved.picture.texels)
        return status;
    status = fit(s, &moved, &other);
    if (status == CMD_OK) {
        trial->moved = 1;
        trial->kept = author_silmap_is_better(&other, out);
        trial->psnr[1] = other.psnr;
        trial->disagreement[1] = other.disagreement;
    }
    author_silmap_release(trial->kept ? out : &other);
    silmap_source_release(trial->kept ? source : &moved);
    if (trial->kept) {
        *out = other;
        *source = moved;
    }
    return status;
}

static int put_other_layer(storing *s, uint32_t layer, uint32_t frame, const fitted *f) {
    silmap_pick pick = {layer, frame, s->keep_alpha[layer], f->cells.cells_x, f->cells.cells_y};
    silmap_source source;
    author_picture samples = {0}, minified = {0};
    author_run run = {0};
    int status = silmap_source_load(s->store, s->texture, &pick, &source);
    if (status != CMD_OK)
        return status;
    if (frame == 0)
        status = choose_coding(s, layer, &source);
    if (status == CMD_OK)
        status = make_author_status(
            silmap_layer_fit(&run, &source.picture, &f->source.place, &f->cells, &samples, &minified), &run);
    if (status == CMD_OK)
        status = put_layer(s, layer, frame, &samples, &minified);
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
                             .cell_layers = s->differ ? s->frames : 1,
                             .filter = texture->silmap->filter,
                             .cells = s->cells,
                             .samples = s->samples,
                             .minified = texture->silmap->no_minified ? NULL : s->minified};
    zt_result result = zt_writer_add_silmap(s->store->writer, &desc, &silmap, &diag, NULL);
    return result == ZT_OK ? CMD_OK : fail_writer(s, result, &diag);
}

static void tell(const storing *s, const author_silmap_place *place, const author_silmap_result *fit) {
    const silmap_trial *trial = &s->trial;
    if (trial->kept)
        cmd_verbose(s->store->args, "%s: hinted, it lies from (%.6f, %.6f) to (%.6f, %.6f) of the texture",
                    s->texture->name, place->x, place->y, place->x + place->width, place->y + place->height);
    else if (trial->moved)
        cmd_verbose(s->store->args,
                    "%s: it stays where it is drawn: hinted it would have %.1f dB and %.3f %% of wrong area, so it has "
                    "%.1f dB and %.3f %%",
                    s->texture->name, trial->psnr[1], 100 * trial->disagreement[1], trial->psnr[0],
                    100 * trial->disagreement[0]);
    else if (trial->wanted)
        cmd_verbose(s->store->args, "%s: it stays where it is drawn: hinting finds no better place", s->texture->name);
    cmd_verbose(s->store->args, "%s: %u x %u cells, %llu cut; %.1f dB, a bilinear texture of the same grid %.1f dB",
                s->texture->name, (unsigned)fit->cells_x, (unsigned)fit->cells_y, (unsigned long long)fit->cut_cells,
                fit->psnr, fit->box_psnr);
}

static void tell_thin(const storing *s, const author_silmap_result *cells) {
    char all[32] = "";
    if (s->texture->images[0]->file_count > 1)
        snprintf(all, sizeof all, " x %u", (unsigned)s->frames);
    if (s->thin_cells > 0)
        cmd_note(s->store->args, "%s: %llu of %u x %u%s cells have features thinner than a cell, which cannot be held",
                 s->texture->name, (unsigned long long)s->thin_cells, (unsigned)cells->cells_x,
                 (unsigned)cells->cells_y, all);
}

static void release(fitted *f) {
    author_silmap_release(&f->cells);
    silmap_source_release(&f->source);
}

static int fit_frame(storing *s, uint32_t frame, fitted *f) {
    silmap_pick pick = {.frame = frame, .keep_alpha = s->keep_alpha[0]};
    int status = silmap_source_load(s->store, s->texture, &pick, &f->source);
    uint32_t channels = f->source.picture.channels;
    if (status == CMD_OK && frame == 0)
        status = choose_coding(s, 0, &f->source);
    if (status == CMD_OK)
        status = fit(s, &f->source, &f->cells);
    if (status == CMD_OK && s->texture->silmap->hint)
        status = try_hint(s, &f->source, &f->cells);
    /* What was cut off may have been all that was transparent. */
    if (status == CMD_OK && f->source.picture.channels != channels)
        status = choose_coding(s, 0, &f->source);
    if (status == CMD_OK)
        tell(s, &f->source.place, &f->cells);
    return status == CMD_OK ? keep_cells(s, frame, &f->cells) : status;
}

/* f: of the frame before; a first layer of one picture keeps it. */
static int put_frame(storing *s, uint32_t frame, fitted *f) {
    int status = CMD_OK;
    if (frame < s->texture->images[0]->file_count) {
        release(f);
        status = fit_frame(s, frame, f);
    }
    if (status == CMD_OK)
        status = put_layer(s, 0, frame, &f->cells.samples, &f->cells.minified);
    for (uint32_t i = 1; status == CMD_OK && i < s->texture->layer_count; i++)
        status = put_other_layer(s, i, frame, f);
    return status;
}

int make_store_silmap(make_store *store, const make_texture *texture, uint32_t *width, uint32_t *height) {
    storing s = {.store = store, .texture = texture};
    fitted f = {.cells = {0}};
    int status = check_frames(&s);
    for (uint32_t frame = 0; status == CMD_OK && frame < s.frames; frame++)
        status = put_frame(&s, frame, &f);
    if (status == CMD_OK) {
        tell_thin(&s, &f.cells);
        status = put_texture(&s, &f.cells);
    }
    *width = f.cells.cells_x;
    *height = f.cells.cells_y;
    if (status == CMD_OK && texture->silmap->made) {
        const author_picture *picture = &f.source.picture;
        *texture->silmap->made = (silmap_made){.result = f.cells,
                                               .width = picture->width,
                                               .height = picture->height,
                                               .place = f.source.place,
                                               .trial = s.trial,
                                               .exact = f.source.path_count > 0};
        memcpy(texture->silmap->made->not_flat, f.source.not_flat, sizeof f.source.not_flat);
        f.cells = (author_silmap_result){0};
    }
    release(&f);
    free(s.cells);
    return status;
}
