/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Patches whose pictures are worked on between file and texture: colours that follow what lies beneath, the gradient
 * density mask, affine frames, pruning. The work is the authoring library's; here is who needs whose pictures, and
 * until when.
 *
 * Patches come in drawing order. The colours of one follow the *adjusted* colours of its ancestors, so those are kept,
 * in 16 bits a channel, until the last patch that looks at them has been stored. Pruning needs the coverage of all
 * later patches: it waits for the end.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "make.h"
#include "make_author.h"

#define MOST_GROUNDS 8     /* ancestors that are looked at */
#define CROP_MARGIN 4      /* texels of an ancestor around what a patch covers of it */
#define COVERAGE_FORMAT 70 /* R16_UNORM */
#define FLAT 1e-12         /* perspective that is nothing but rounding */

/* A picture that waits, packed. */
typedef struct kept {
    uint32_t width, height, channels, format;
    size_t texel;
    unsigned char *bytes;
} kept;

typedef struct treated {
    int works;       /* something is done to its pictures */
    uint32_t wanted; /* index of the last patch that looks at its colours; 0: none */
    int covers;      /* an earlier patch is pruned: its coverage is kept */
    kept *layers;    /* of the texture's layers, those whose colours are wanted, as they were placed */
    kept *finished;  /* all layers of a patch that is yet to be pruned and stored */
    kept coverage;
    int baked, flat; /* flat: it was affine already */
    author_baking baking;
} treated;

struct make_treatment {
    make_store *store;
    const make_texture *texture;
    author_run run;
    treated *patches;
    const make_placed *placed; /* up to the patch at hand */
    make_ready *now;           /* layers of the patch at hand */
    img_type types[MAKE_LAYERS];
    int any_pruned;
};

static int interrupted(void *user, const char *stage, double done) {
    (void)user;
    (void)stage;
    (void)done;
    return cmd_interrupted();
}

/* The message with the place in the scene. */
static int status_of(const make_treatment *t, const make_patch *patch, author_result result) {
    if (result == AUTHOR_BAD_INPUT)
        return make_complain(t->store->scene, patch->pointer, "%s", t->run.error);
    return make_author_status(result, &t->run);
}

static int no_memory(void) {
    return cmd_fail(CMD_INTERNAL, "out of memory");
}

/* ---- pictures that wait ---------------------------------------------------------------------------------- */

static void drop(kept *k) {
    free(k->bytes);
    *k = (kept){0};
}

static int keep(const author_picture *picture, uint32_t format, kept *out) {
    uint32_t width = picture->width, channels = picture->channels;
    *out = (kept){width, picture->height, channels, format, zt_find_format(format)->block_bytes, NULL};
    float *row = calloc(width, 4 * sizeof *row);
    out->bytes = malloc((size_t)width * out->height * out->texel);
    for (uint32_t y = 0; row && out->bytes && y < out->height; y++) {
        const float *from = picture->texels + (size_t)y * width * channels;
        for (size_t x = 0; x < width; x++)
            memcpy(row + 4 * x, from + x * channels, channels * sizeof *row);
        zt_pack_texels(format, row, width, out->bytes + (size_t)y * width * out->texel);
    }
    int made = row && out->bytes;
    free(row);
    if (!made)
        drop(out);
    return made ? CMD_OK : no_memory();
}

/* A rectangle of it. */
static int take_out(make_treatment *t, const kept *k, const uint32_t box[4], author_picture *out) {
    uint32_t width = box[2] - box[0], height = box[3] - box[1];
    if (author_picture_create(&t->run, width, height, k->channels, out) != AUTHOR_OK)
        return no_memory();
    float *row = malloc((size_t)width * 4 * sizeof *row);
    for (uint32_t y = 0; row && y < height; y++) {
        size_t from = (size_t)(box[1] + y) * k->width + box[0];
        float *to = out->texels + (size_t)y * width * k->channels;
        zt_unpack_texels(k->format, k->bytes + from * k->texel, width, row);
        for (size_t x = 0; x < width; x++)
            memcpy(to + x * k->channels, row + 4 * x, k->channels * sizeof *row);
    }
    free(row);
    return row ? CMD_OK : no_memory();
}

/* Half floats hold 8-bit colours with room to spare; finer pictures that are yet to be stored stay as they are. */
static uint32_t keeping_format(uint32_t channels, int exact) {
    static const uint32_t halves[4] = {76, 83, 90, 97}, floats[4] = {100, 103, 106, 109};
    return exact ? floats[channels - 1] : halves[channels - 1];
}

static void drop_all(const make_treatment *t, kept **layers) {
    for (uint32_t i = 0; *layers && i < t->texture->layer_count; i++)
        drop(&(*layers)[i]);
    free(*layers);
    *layers = NULL;
}

/* ---- who needs whom --------------------------------------------------------------------------------------- */

static int has_picture(const make_texture *texture, uint32_t index) {
    return texture->patches[index].texture == ZT_NONE;
}

static int works_on(const make_patch *patch) {
    return patch->colour != COLOUR_NONE || patch->auto_mask || patch->bake_affine || patch->prune;
}

static int is_colour_layer(const make_texture *texture, uint32_t layer) {
    return make_is_colour(texture->semantics[layer]);
}

static int check_patch(const make_treatment *t, uint32_t index) {
    const make_texture *texture = t->texture;
    const make_patch *patch = &texture->patches[index];
    int colours = 0;
    for (uint32_t i = 0; i < texture->layer_count; i++) {
        const make_image *image = patch->images[i];
        colours += is_colour_layer(texture, i);
        if (image->file_count > 1 || image->all_subimages || image->volume || image->layer_kind)
            return make_complain(
                t->store->scene, image->pointer,
                "frames, cubes and volumes cannot be worked on: 'colour', 'mask': \"auto\", 'prune' and "
                "'bake_affine' are for single pictures, of this patch and of those around it");
    }
    if (patch->mask && (patch->mask->file_count > 1 || patch->mask->all_subimages))
        return make_complain(t->store->scene, patch->mask->pointer,
                             "a patch that is worked on has one picture, and so has its mask");
    if (patch->colour != COLOUR_NONE && colours == 0)
        return make_complain(t->store->scene, patch->pointer,
                             "'colour' is for layers of colours, and this texture has none");
    return CMD_OK;
}

/* Its ancestors with pictures, the nearest first. */
static uint32_t find_grounds(const make_texture *texture, uint32_t index, uint32_t out[MOST_GROUNDS]) {
    uint32_t count = 0;
    while (index != 0 && count < MOST_GROUNDS) {
        index = texture->patches[index].parent;
        if (has_picture(texture, index))
            out[count++] = index;
    }
    return count;
}

static void find_needs(make_treatment *t) {
    const make_texture *texture = t->texture;
    uint32_t grounds[MOST_GROUNDS];
    for (uint32_t i = 0; i < texture->patch_count; i++) {
        const make_patch *patch = &texture->patches[i];
        t->patches[i].covers = t->any_pruned && i > 0 && has_picture(texture, i);
        t->patches[i].works = has_picture(texture, i) && works_on(patch);
        t->any_pruned |= patch->prune;
        uint32_t count = patch->colour != COLOUR_NONE ? find_grounds(texture, i, grounds) : 0;
        for (uint32_t k = 0; k < count; k++)
            t->patches[grounds[k]].wanted = i;
    }
}

int make_treats(const make_treatment *t, uint32_t index) {
    return t && (t->patches[index].works || t->patches[index].wanted || t->patches[index].covers);
}

int make_treat_begin(make_store *store, const make_texture *texture, make_treatment **out) {
    int any = 0;
    *out = NULL;
    for (uint32_t i = 0; i < texture->patch_count && !any; i++)
        any = works_on(&texture->patches[i]);
    if (!any)
        return CMD_OK;
    make_treatment *t = calloc(1, sizeof *t);
    if (!t)
        return no_memory();
    *out = t;
    *t = (make_treatment){.store = store, .texture = texture};
    t->run = (author_run){.parallel = cmd_parallel(store->args), .progress = interrupted};
    t->patches = calloc(texture->patch_count, sizeof *t->patches);
    t->now = calloc(texture->layer_count, sizeof *t->now);
    if (!t->patches || !t->now)
        return no_memory();
    find_needs(t);
    int status = CMD_OK;
    for (uint32_t i = 0; i < texture->patch_count && status == CMD_OK; i++)
        if (make_treats(t, i))
            status = check_patch(t, i);
    return status;
}

static void release_now(make_treatment *t) {
    for (uint32_t i = 0; t->now && i < t->texture->layer_count; i++) {
        author_picture_release(&t->now[i].picture);
        author_picture_release(&t->now[i].coverage);
    }
}

void make_treat_end(make_treatment *t) {
    if (!t)
        return;
    release_now(t);
    for (uint32_t i = 0; t->patches && i < t->texture->patch_count; i++) {
        drop_all(t, &t->patches[i].layers);
        drop_all(t, &t->patches[i].finished);
        drop(&t->patches[i].coverage);
    }
    free(t->patches);
    free(t->now);
    free(t);
}

/* ---- loading ------------------------------------------------------------------------------------------------- */

/* Is the layer changed, or looked at by a later patch? */
static int needs_layer(const make_treatment *t, uint32_t index, uint32_t layer) {
    const make_patch *patch = &t->texture->patches[index];
    int colour = is_colour_layer(t->texture, layer);
    if (patch->bake_affine || patch->prune)
        return 1;
    if (layer == 0 && (patch->auto_mask || t->patches[index].covers))
        return 1;
    return colour && (patch->colour != COLOUR_NONE || t->patches[index].wanted);
}

/* The first layer's size is the patch's, also when only another one is worked on. */
int make_treat_load(make_treatment *t, uint32_t index, make_stored *size) {
    const make_patch *patch = &t->texture->patches[index];
    int status = CMD_OK;
    for (uint32_t i = 0; i < t->texture->layer_count && status == CMD_OK; i++) {
        img_info info;
        if (i > 0 && !needs_layer(t, index, i))
            continue;
        status = make_load_picture(t->store, patch->images[i], t->texture->semantics[i], &t->now[i].picture, &info);
        t->types[i] = info.type;
        if (status == CMD_OK && i == 0)
            *size = (make_stored){.width = info.width,
                                  .height = info.height,
                                  .depth = 1,
                                  .layers = 1,
                                  .full_width = info.full_width,
                                  .full_height = info.full_height};
    }
    return status;
}

/* ---- colours -------------------------------------------------------------------------------------------------- */

/* What of an ancestor's texels lies beneath the patch. 0 when nothing does. to_ancestor: the patch's coordinates to the
 * ancestor's. */
static int find_box(const double to_ancestor[9], const kept *k, uint32_t box[4]) {
    double low[2] = {0.0, 0.0}, high[2] = {k->width, k->height};
    for (int i = 0; i < 4; i++) {
        double x = i & 1, y = i >> 1, w = to_ancestor[6] * x + to_ancestor[7] * y + to_ancestor[8];
        double at[2] = {(to_ancestor[0] * x + to_ancestor[1] * y + to_ancestor[2]) / w * k->width,
                        (to_ancestor[3] * x + to_ancestor[4] * y + to_ancestor[5]) / w * k->height};
        if (!(w > 0.0)) { /* over its horizon: all of it may be beneath */
            low[0] = low[1] = 0.0;
            high[0] = k->width;
            high[1] = k->height;
            break;
        }
        for (int d = 0; d < 2; d++) {
            low[d] = i == 0 ? at[d] : fmin(low[d], at[d]);
            high[d] = i == 0 ? at[d] : fmax(high[d], at[d]);
        }
    }
    for (int d = 0; d < 2; d++) {
        double size = d ? k->height : k->width;
        double from = fmax(floor(low[d]) - CROP_MARGIN, 0.0), to = fmin(ceil(high[d]) + CROP_MARGIN, size);
        if (!(from < to))
            return 0;
        box[d] = (uint32_t)from;
        box[2 + d] = (uint32_t)to;
    }
    return 1;
}

static int take_ground(make_treatment *t, uint32_t index, uint32_t ancestor, uint32_t layer, author_picture *picture,
                       author_ground *ground, int *found) {
    const kept *k = &t->patches[ancestor].layers[layer];
    const double *place = t->placed[index].self.root_matrix, *below = t->placed[ancestor].self.root_matrix;
    double back[9], to_ancestor[9], to_patch[9];
    uint32_t box[4];
    *found = 0;
    if (make_matrix_invert(place, back))
        return CMD_OK;
    make_matrix_multiply(below, back, to_ancestor);
    if (make_matrix_invert(to_ancestor, to_patch) || !find_box(to_ancestor, k, box))
        return CMD_OK;
    const double crop[9] = {(box[2] - box[0]) / (double)k->width,
                            0,
                            box[0] / (double)k->width,
                            0,
                            (box[3] - box[1]) / (double)k->height,
                            box[1] / (double)k->height,
                            0,
                            0,
                            1};
    make_matrix_multiply(to_patch, crop, ground->matrix);
    ground->picture = picture;
    *found = 1;
    return take_out(t, k, box, picture);
}

static void tell_seam(const make_treatment *t, uint32_t index, const author_adjustment *a) {
    cmd_verbose(t->store->args,
                "patch %u: seam %.2f (worst %.2f) of 255 before, %.2f (%.2f) after; mean off by %.2f, then %.2f",
                (unsigned)index, a->before.median * 255.0, a->before.worst * 255.0, a->after.median * 255.0,
                a->after.worst * 255.0, a->before.mean * 255.0, a->after.mean * 255.0);
}

static int adjust_layer(make_treatment *t, uint32_t index, uint32_t layer) {
    const make_patch *patch = &t->texture->patches[index];
    uint32_t ancestors[MOST_GROUNDS], count = find_grounds(t->texture, index, ancestors), used = 0;
    author_picture pictures[MOST_GROUNDS] = {{0}};
    author_ground grounds[MOST_GROUNDS];
    author_adjustment report;
    int status = CMD_OK;
    for (uint32_t i = 0; i < count && status == CMD_OK; i++) {
        int found;
        status = take_ground(t, index, ancestors[i], layer, &pictures[used], &grounds[used], &found);
        used += found != 0;
    }
    if (status == CMD_OK) {
        author_colour how = patch->colour == COLOUR_GAIN ? AUTHOR_COLOUR_GAIN : AUTHOR_COLOUR_POISSON;
        status = status_of(t, patch,
                           author_adjust_colour(&t->run, &t->now[layer].picture, grounds, used, how, &report));
    }
    if (status == CMD_OK)
        tell_seam(t, index, &report);
    if (status == CMD_OK && report.covered == 0.0)
        cmd_warn(t->store->args, "%s: nothing lies beneath this patch: its colours stay as they are", patch->pointer);
    for (uint32_t i = 0; i < MOST_GROUNDS; i++)
        author_picture_release(&pictures[i]);
    return status;
}

static int adjust_layers(make_treatment *t, uint32_t index) {
    int status = CMD_OK;
    if (t->texture->patches[index].colour == COLOUR_NONE)
        return CMD_OK;
    for (uint32_t i = 0; i < t->texture->layer_count && status == CMD_OK; i++)
        if (is_colour_layer(t->texture, i))
            status = adjust_layer(t, index, i);
    return status;
}

static int keep_layers(make_treatment *t, uint32_t index) {
    treated *p = &t->patches[index];
    int status = CMD_OK;
    if (!p->wanted)
        return CMD_OK;
    p->layers = calloc(t->texture->layer_count, sizeof *p->layers);
    if (!p->layers)
        return no_memory();
    for (uint32_t i = 0; i < t->texture->layer_count && status == CMD_OK; i++) {
        const author_picture *picture = &t->now[i].picture;
        if (is_colour_layer(t->texture, i))
            status = keep(picture, keeping_format(picture->channels, 0), &p->layers[i]);
    }
    return status;
}

/* ---- coverage ---------------------------------------------------------------------------------------------------- */

static int multiply_mask(make_treatment *t, const make_image *mask, author_picture *coverage) {
    char error[IMG_ERROR];
    const char *path = mask->files[0].path;
    img_reader *reader = make_open_mask(t->store, mask, 0, coverage->width, coverage->height, error);
    if (!reader)
        return make_fail_picture(t->store, mask, path, error);
    float *row = malloc((size_t)coverage->width * sizeof *row);
    int status = row ? CMD_OK : no_memory();
    for (uint32_t y = 0; y < coverage->height && status == CMD_OK; y++) {
        float *to = coverage->texels + (size_t)y * coverage->width;
        if (img_read_rows(reader, 0, y, 1, 1, IMG_FLOAT, row, 0, error))
            status = make_fail_picture(t->store, mask, path, error);
        for (uint32_t x = 0; x < coverage->width && status == CMD_OK; x++)
            to[x] *= row[x];
    }
    free(row);
    img_close(reader);
    return status;
}

static int even_coverage(make_treatment *t, const make_patch *patch, author_picture *coverage) {
    const author_picture *picture = &t->now[0].picture;
    if (author_picture_create(&t->run, picture->width, picture->height, 1, coverage) != AUTHOR_OK)
        return no_memory();
    for (uint32_t y = 0; y < picture->height; y++)
        for (uint32_t x = 0; x < picture->width; x++)
            coverage->texels[(size_t)y * picture->width + x] = author_ramp(picture->width, picture->height, patch->ramp,
                                                                           x, y);
    return patch->mask ? multiply_mask(t, patch->mask, coverage) : CMD_OK;
}

static int density_coverage(make_treatment *t, uint32_t index, author_picture *coverage) {
    const make_patch *patch = &t->texture->patches[index];
    author_mask_options options = {.tau = patch->tau, .ramp = patch->ramp};
    double tau;
    int status = status_of(t, patch, author_gradient_mask(&t->run, &t->now[0].picture, &options, coverage, &tau));
    if (status == CMD_OK)
        cmd_verbose(t->store->args, "patch %u: tau %.3f", (unsigned)index, tau);
    return status;
}

/* Alpha of colours is coverage; of values it is a value. */
static int make_coverage(make_treatment *t, uint32_t index) {
    const make_patch *patch = &t->texture->patches[index];
    const author_picture *picture = &t->now[0].picture;
    author_picture *coverage = &t->now[0].coverage;
    int status = patch->auto_mask ? density_coverage(t, index, coverage) : even_coverage(t, patch, coverage);
    size_t texels = (size_t)picture->width * picture->height, channels = picture->channels;
    if (status != CMD_OK || channels % 2 || !is_colour_layer(t->texture, 0))
        return status;
    for (size_t i = 0; i < texels; i++)
        coverage->texels[i] *= picture->texels[i * channels + channels - 1];
    return CMD_OK;
}

/* ---- affine frames ---------------------------------------------------------------------------------------------- */

static int warp(make_treatment *t, const make_patch *patch, const author_baking *baking, author_picture *picture,
                uint8_t *inside) {
    author_picture out;
    author_result result = author_warp(&t->run, picture, baking->frame, baking->width, baking->height, &out, inside);
    if (result != AUTHOR_OK)
        return status_of(t, patch, result);
    author_picture_release(picture);
    *picture = out;
    return CMD_OK;
}

/* Layers are as large as they are beside the first one. */
static author_baking scaled(const author_baking *baking, const author_picture *first, const author_picture *picture) {
    author_baking out = *baking;
    double x = (double)picture->width / first->width, y = (double)picture->height / first->height;
    out.width = (uint32_t)fmax(floor(baking->width * x + 0.5), 1.0);
    out.height = (uint32_t)fmax(floor(baking->height * y + 0.5), 1.0);
    return out;
}

static int bake_coverage(make_treatment *t, const make_patch *patch, const author_baking *baking) {
    author_picture *coverage = &t->now[0].coverage;
    size_t texels = (size_t)baking->width * baking->height;
    uint8_t *inside = malloc(texels);
    int status = inside ? warp(t, patch, baking, coverage, inside) : no_memory();
    for (size_t i = 0; i < texels && status == CMD_OK; i++)
        coverage->texels[i] = inside[i] ? fminf(fmaxf(coverage->texels[i], 0.0f), 1.0f) : 0.0f;
    free(inside);
    return status;
}

/* From the root's coordinates to those of the patch's picture as it is stored. */
static void final_place(const make_treatment *t, uint32_t index, double out[9]) {
    const double *place = t->placed[index].self.root_matrix;
    if (t->patches[index].baked)
        make_matrix_multiply(t->patches[index].baking.frame, place, out);
    else
        memcpy(out, place, 9 * sizeof *out);
}

static int bake(make_treatment *t, uint32_t index) {
    const make_patch *patch = &t->texture->patches[index];
    treated *p = &t->patches[index];
    author_picture first = t->now[0].picture;
    double parent[9], back[9], matrix[9];
    final_place(t, patch->parent, parent);
    if (make_matrix_invert(parent, back))
        return make_complain(t->store->scene, patch->pointer, "the parent's own placement cannot be inverted");
    make_matrix_multiply(t->placed[index].self.root_matrix, back, matrix);
    p->flat = fabs(matrix[6]) + fabs(matrix[7]) <= FLAT * fabs(matrix[8]);
    if (p->flat)
        return CMD_OK;
    int status = status_of(t, patch, author_bake(&t->run, matrix, first.width, first.height, &p->baking));
    for (uint32_t i = 0; i < t->texture->layer_count && status == CMD_OK; i++) {
        author_baking own = scaled(&p->baking, &first, &t->now[i].picture);
        status = warp(t, patch, &own, &t->now[i].picture, NULL);
    }
    if (status == CMD_OK)
        status = bake_coverage(t, patch, &p->baking);
    p->baked = status == CMD_OK;
    return status;
}

/* ---- one patch --------------------------------------------------------------------------------------------------- */

static void set_wrap(const make_treatment *t, uint32_t index, make_use *use) {
    for (int i = 0; i < 3; i++)
        use->wrap[i] = index == 0 ? t->texture->wrap[i] : ZT_WRAP_CLAMP;
}

/* Layers that nothing was done to go straight from the file. */
static int store_layers(make_treatment *t, uint32_t index, make_placed *placed) {
    const make_patch *patch = &t->texture->patches[index];
    const treated *p = &t->patches[index];
    int status = CMD_OK;
    for (uint32_t i = 0; i < t->texture->layer_count && status == CMD_OK; i++) {
        make_use use = {.semantic = t->texture->semantics[i], .role = ROLE_PLAIN};
        make_stored stored;
        make_turn turn;
        int recoloured = patch->colour != COLOUR_NONE && is_colour_layer(t->texture, i);
        set_wrap(t, index, &use);
        if (p->baked || patch->prune || recoloured || (i == 0 && patch->auto_mask))
            use.ready = &t->now[i];
        use.turn = make_turn_for(t->texture, index, i, t->placed, p->baked ? p->baking.frame : NULL, &turn);
        status = index > 0 && i == 0 ? make_store_coverage(t->store, patch, &use, placed, &stored)
                                     : make_store_image(t->store, patch->images[i], &use, &stored);
        placed->sources[i] = stored.image;
    }
    return status;
}

/* Everything that the end needs of a patch that is pruned. */
static int keep_for_pruning(make_treatment *t, uint32_t index) {
    treated *p = &t->patches[index];
    int status = CMD_OK;
    p->finished = calloc(t->texture->layer_count, sizeof *p->finished);
    if (!p->finished)
        return no_memory();
    for (uint32_t i = 0; i < t->texture->layer_count && status == CMD_OK; i++) {
        const author_picture *picture = &t->now[i].picture;
        status = keep(picture, keeping_format(picture->channels, t->types[i] != IMG_U8), &p->finished[i]);
    }
    return status;
}

/* A patch whose levels end early fades out before it is small, and hides nothing then. */
static int hides(const make_treatment *t, uint32_t index) {
    return t->patches[index].covers && t->texture->patches[index].images[0]->options.levels <= 0;
}

static void release_grounds(make_treatment *t, uint32_t index) {
    uint32_t grounds[MOST_GROUNDS], count = find_grounds(t->texture, index, grounds);
    for (uint32_t i = 0; i < count; i++)
        if (t->patches[grounds[i]].wanted == index)
            drop_all(t, &t->patches[grounds[i]].layers);
}

static int work_on(make_treatment *t, uint32_t index, make_placed *placed) {
    const make_patch *patch = &t->texture->patches[index];
    treated *p = &t->patches[index];
    int status = adjust_layers(t, index);
    if (status == CMD_OK)
        status = keep_layers(t, index);
    if (status == CMD_OK && index > 0 && (p->works || p->covers))
        status = make_coverage(t, index);
    if (status == CMD_OK && patch->bake_affine)
        status = bake(t, index);
    if (status == CMD_OK && (hides(t, index) || (index > 0 && patch->prune)))
        status = keep(&t->now[0].coverage, COVERAGE_FORMAT, &p->coverage);
    if (status == CMD_OK)
        status = patch->prune ? keep_for_pruning(t, index) : store_layers(t, index, placed);
    release_grounds(t, index);
    return status;
}

int make_treat_patch(make_treatment *t, uint32_t index, make_placed *all) {
    t->placed = all;
    int status = work_on(t, index, &all[index]);
    release_now(t);
    return status;
}

/* ---- pruning ----------------------------------------------------------------------------------------------------- */

static int take_all(make_treatment *t, const kept *k, author_picture *out) {
    const uint32_t box[4] = {0, 0, k->width, k->height};
    return take_out(t, k, box, out);
}

static int find_depth(make_treatment *t, uint32_t index, author_depth *depth) {
    const make_texture *texture = t->texture;
    double place[9], back[9], other[9], matrix[9];
    final_place(t, index, place);
    int status = make_matrix_invert(place, back) ? make_complain(t->store->scene, texture->patches[index].pointer,
                                                                 "the placement cannot be inverted")
                                                 : CMD_OK;
    for (uint32_t i = index + 1; i < texture->patch_count && status == CMD_OK; i++) {
        author_picture coverage;
        if (!hides(t, i))
            continue;
        final_place(t, i, other);
        make_matrix_multiply(other, back, matrix);
        status = take_all(t, &t->patches[i].coverage, &coverage);
        if (status == CMD_OK)
            status = status_of(t, &texture->patches[i], author_depth_cover(&t->run, depth, &coverage, matrix));
        author_picture_release(&coverage);
    }
    return status;
}

/* Layers may have sizes of their own: each new size has its own depths. */
static int prune_layer(make_treatment *t, uint32_t index, uint32_t layer, author_depth *depth) {
    const make_patch *patch = &t->texture->patches[index];
    const kept *k = &t->patches[index].finished[layer];
    int status = CMD_OK;
    if (depth->width != k->width || depth->height != k->height) {
        author_depth_release(depth);
        status = status_of(t, patch, author_depth_create(&t->run, k->width, k->height, depth));
        if (status == CMD_OK)
            status = find_depth(t, index, depth);
    }
    if (status == CMD_OK)
        status = take_all(t, k, &t->now[layer].picture);
    return status == CMD_OK ? status_of(t, patch, author_prune(&t->run, &t->now[layer].picture, depth)) : status;
}

static int prune(make_treatment *t, uint32_t index, make_placed *placed) {
    treated *p = &t->patches[index];
    author_depth depth = {0};
    int status = CMD_OK;
    for (uint32_t i = 0; i < t->texture->layer_count && status == CMD_OK; i++)
        status = prune_layer(t, index, i, &depth);
    author_depth_release(&depth);
    drop_all(t, &p->finished);
    if (status == CMD_OK && p->coverage.bytes)
        status = take_all(t, &p->coverage, &t->now[0].coverage);
    if (status == CMD_OK)
        status = store_layers(t, index, placed);
    release_now(t);
    return status;
}

/* Of a patch beside baked frames, its own or its parent's. */
static int follow_frames(const make_treatment *t, uint32_t index, double matrix[9]) {
    const treated *p = &t->patches[index], *parent = &t->patches[t->texture->patches[index].parent];
    double back[9], own[9];
    if (p->baked) {
        memcpy(matrix, p->baking.matrix, sizeof p->baking.matrix);
    } else if (parent->baked) {
        if (make_matrix_invert(parent->baking.frame, back))
            return make_complain(t->store->scene, t->texture->patches[index].pointer,
                                 "the parent's own placement cannot be inverted");
        memcpy(own, matrix, sizeof own);
        make_matrix_multiply(own, back, matrix);
    }
    if (p->flat)
        matrix[6] = matrix[7] = 0.0;
    for (int i = 0; i < 9; i++)
        matrix[i] += 0.0; /* negative zero becomes zero: [R8109] */
    return CMD_OK;
}

int make_treat_finish(make_treatment *t, make_placed *all, zt_patch_desc *patches) {
    int status = CMD_OK;
    for (uint32_t i = 0; t && i < t->texture->patch_count && status == CMD_OK; i++) {
        t->placed = all;
        if (t->patches[i].finished)
            status = prune(t, i, &all[i]);
        if (status == CMD_OK && i > 0)
            status = follow_frames(t, i, patches[i].matrix);
    }
    return status;
}
