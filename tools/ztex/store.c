/* SPDX-License-Identifier: Apache-2.0 */
/* A scene into a texture file: images first, then textures with their patches, then metadata. */
#include "silmap.h"
#include "umbrellas.h"

#include <stdlib.h>
#include <string.h>

static const uint8_t clamped[3] = {ZT_WRAP_CLAMP, ZT_WRAP_CLAMP, ZT_WRAP_CLAMP};

int make_fail_writer(const make_scene *scene, const char *pointer, zt_result result, const zt_diag *diag) {
    char name[512];
    if (!scene->name)
        return cmd_fail_result("make", result, diag);
    snprintf(name, sizeof name, "%s: %s", scene->name, pointer);
    return cmd_fail_result(name, result, diag);
}

static size_t count_images(const make_scene *scene) {
    size_t count = 0;
    for (uint32_t t = 0; t < scene->texture_count; t++) {
        const make_texture *texture = &scene->textures[t];
        count += (size_t)texture->layer_count * (texture->is_zipmap ? texture->patch_count : 1);
    }
    return count;
}

/* ---- kind image ------------------------------------------------------------------------------------- */

static int check_layer(const make_store *store, const make_image *image, const make_stored *layer,
                       const make_stored *first) {
    if (layer->width == first->width && layer->height == first->height && layer->depth == first->depth &&
        layer->layers == first->layers)
        return CMD_OK;
    return make_complain(store->scene, image->pointer,
                         "%s is %u x %u x %u with %u layers, but the texture's first picture %u x "
                         "%u x %u with %u: they have one size (resize it)",
                         image->files[0].path, (unsigned)layer->width, (unsigned)layer->height, (unsigned)layer->depth,
                         (unsigned)layer->layers, (unsigned)first->width, (unsigned)first->height,
                         (unsigned)first->depth, (unsigned)first->layers);
}

zt_texture_desc make_describe(const make_texture *texture, const uint32_t *images, zt_layer_desc layers[MAKE_LAYERS]) {
    for (uint32_t i = 0; i < texture->layer_count; i++)
        layers[i] = (zt_layer_desc){texture->semantics[i], images ? images[i] : ZT_NONE};
    return (zt_texture_desc){.name = texture->name,
                             .wrap_u = (zt_wrap)texture->wrap[0],
                             .wrap_v = (zt_wrap)texture->wrap[1],
                             .wrap_w = (zt_wrap)texture->wrap[2],
                             .layers = layers,
                             .layer_count = texture->layer_count};
}

static int store_image_texture(make_store *store, const make_texture *texture, make_size *size) {
    zt_layer_desc layers[MAKE_LAYERS];
    uint32_t images[MAKE_LAYERS];
    make_stored first = {0}, stored;
    for (uint32_t i = 0; i < texture->layer_count; i++) {
        make_use use = {.semantic = texture->semantics[i], .role = ROLE_PLAIN};
        memcpy(use.wrap, texture->wrap, sizeof use.wrap);
        int status = make_store_image(store, texture->images[i], &use, &stored);
        if (status == CMD_OK && i == 0)
            first = stored;
        if (status == CMD_OK)
            status = check_layer(store, texture->images[i], &stored, &first);
        if (status != CMD_OK)
            return status;
        images[i] = stored.image;
    }
    *size = (make_size){first.width, first.height};
    zt_texture_desc desc = make_describe(texture, images, layers);
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = zt_writer_add_texture(store->writer, &desc, &diag, NULL);
    return result == ZT_OK ? CMD_OK : make_fail_writer(store->scene, texture->pointer, result, &diag);
}

/* ---- kind zipmap -------------------------------------------------------------------------------------- */

int make_store_coverage(make_store *store, const make_patch *patch, make_use *use, make_placed *p,
                        make_stored *stored) {
    const make_image *image = patch->images[0];
    int separate = patch->separate_mask;
    int status = CMD_OK;
    use->ramp = patch->ramp;
    use->mask = patch->mask;
    if (!separate)
        status = make_wants_mask(store, image, use, &separate);
    use->role = separate ? ROLE_BARE : ROLE_COVERED;
    if (status == CMD_OK)
        status = make_store_image(store, image, use, stored);
    if (status != CMD_OK || !separate)
        return status;
    make_stored mask;
    use->role = ROLE_MASK;
    status = make_store_image(store, image, use, &mask);
    p->mask = mask.image;
    return status;
}

static void note_size(make_placed *p, const make_patch *patch, const make_stored *stored) {
    p->self.width = stored->width;
    p->self.height = stored->height;
    p->crop = (make_crop){patch->images[0]->crop, stored->full_width, stored->full_height};
}

/* How large a patch is, from the header of its picture: it is placed before it is stored, since normals turn with
 * it. */
static int measure(const make_store *store, const make_texture *texture, uint32_t index, make_placed *p) {
    const make_patch *patch = &texture->patches[index];
    const make_image *image = patch->images[0];
    char error[IMG_ERROR];
    img_reader *reader = make_open_picture(store, image, 0, texture->semantics[0], 0, error);
    if (!reader)
        return make_fail_picture(store, image, image->files[0].path, error);
    const img_info *info = img_get_info(reader);
    int resized = image->resize_width > 0 && image->resize_height > 0;
    make_stored size = {.width = resized ? image->resize_width : info->width,
                        .height = resized ? image->resize_height : info->height,
                        .full_width = info->full_width,
                        .full_height = info->full_height};
    note_size(p, patch, &size);
    img_close(reader);
    return CMD_OK;
}

/* [R8108] with the place in the scene. */
static int check_frames(const make_store *store, const make_image *image, const make_placed *root, uint32_t layers) {
    if (layers == 1 || layers == root->frames)
        return CMD_OK;
    return make_complain(store->scene, image->pointer,
                         "%u frames, where the root has %u: a patch has as many frames as the root, or one",
                         (unsigned)layers, (unsigned)root->frames);
}

static int store_layers(make_store *store, const make_texture *texture, uint32_t index, make_placed *all) {
    const make_patch *patch = &texture->patches[index];
    make_placed *p = &all[index];
    make_stored stored;
    for (uint32_t i = 0; i < texture->layer_count; i++) {
        make_turn turn;
        make_use use = {.semantic = texture->semantics[i], .role = ROLE_PLAIN};
        use.turn = make_turn_for(texture, index, i, all, NULL, &turn);
        memcpy(use.wrap, index == 0 ? texture->wrap : clamped, sizeof use.wrap);
        int status = index > 0 && i == 0 ? make_store_coverage(store, patch, &use, p, &stored)
                                         : make_store_image(store, patch->images[i], &use, &stored);
        if (status == CMD_OK && index == 0 && i == 0)
            p->frames = stored.layers;
        if (status == CMD_OK)
            status = check_frames(store, patch->images[i], &all[0], stored.layers);
        if (status != CMD_OK)
            return status;
        p->sources[i] = stored.image;
    }
    return CMD_OK;
}

/* A patch that shows a texture of the file: its coverage is the texture's, times a mask if there is one. */
static int store_shown(make_store *store, const make_texture *texture, uint32_t index, const make_size *sizes,
                       make_placed *all) {
    const make_patch *patch = &texture->patches[index];
    make_placed *p = &all[index];
    for (uint32_t i = 0; i < texture->layer_count; i++)
        p->sources[i] = patch->texture;
    p->self.width = sizes[patch->texture].width;
    p->self.height = sizes[patch->texture].height;
    if (!patch->mask)
        return CMD_OK;
    make_stored stored;
    make_use use = {.semantic = ZT_SEMANTIC_OPACITY, .role = ROLE_MASK, .ramp = patch->ramp, .mask = patch->mask};
    memcpy(use.wrap, clamped, sizeof use.wrap);
    int status = make_store_image(store, patch->mask, &use, &stored);
    p->mask = stored.image;
    return status == CMD_OK ? check_frames(store, patch->mask, &all[0], stored.layers) : status;
}

static int place_patch(make_store *store, const make_texture *texture, uint32_t index, make_placed *all,
                       double matrix[9]) {
    const make_patch *patch = &texture->patches[index];
    make_placed *self = &all[index];
    if (index == 0) {
        memcpy(matrix, make_identity, sizeof make_identity);
        memcpy(self->self.root_matrix, make_identity, sizeof make_identity);
        return CMD_OK;
    }
    const make_parent *parent = &all[patch->parent].self;
    const char *wrong = make_place_matrix(patch, parent, &self->crop, matrix);
    if (wrong)
        return make_complain(store->scene, patch->pointer, "%s", wrong);
    make_matrix_multiply(matrix, parent->root_matrix, self->self.root_matrix);
    return CMD_OK;
}

static int add_zipmap(make_store *store, const make_texture *texture, const zt_patch_desc *patches) {
    zt_layer_desc layers[MAKE_LAYERS];
    zt_texture_desc desc = make_describe(texture, NULL, layers);
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = zt_writer_add_zipmap(store->writer, &desc, patches, texture->patch_count, &diag, NULL);
    return result == ZT_OK ? CMD_OK : make_fail_writer(store->scene, texture->pointer, result, &diag);
}

static void warn_of_normals(const make_store *store, const make_texture *texture, uint32_t index,
                            const make_placed *all) {
    make_turn turn;
    for (uint32_t i = 0; i < texture->layer_count; i++)
        if (make_turn_for(texture, index, i, all, NULL, &turn))
            cmd_warn(store->args, "%s: the normals of the texture that it shows do not turn with it",
                     texture->patches[index].pointer);
}

/* The place of a patch that is worked on has to be known before. */
static int store_treated(make_store *store, const make_texture *texture, uint32_t index, make_treatment *treatment,
                         make_placed *all, double matrix[9]) {
    make_stored size;
    int status = make_treat_load(treatment, index, &size);
    if (status != CMD_OK)
        return status;
    all[index].frames = 1;
    note_size(&all[index], &texture->patches[index], &size);
    status = place_patch(store, texture, index, all, matrix);
    return status == CMD_OK ? make_treat_patch(treatment, index, all) : status;
}

static int store_patch(make_store *store, const make_texture *texture, uint32_t index, const make_size *sizes,
                       make_treatment *treatment, make_placed *all, zt_patch_desc *desc) {
    const make_patch *patch = &texture->patches[index];
    int shows = patch->texture != ZT_NONE, status;
    all[index].mask = ZT_NONE;
    if (make_treats(treatment, index)) {
        status = store_treated(store, texture, index, treatment, all, desc->matrix);
    } else {
        status = shows ? store_shown(store, texture, index, sizes, all) : measure(store, texture, index, &all[index]);
        if (status == CMD_OK)
            status = place_patch(store, texture, index, all, desc->matrix);
        if (status == CMD_OK && shows)
            warn_of_normals(store, texture, index, all);
        else if (status == CMD_OK)
            status = store_layers(store, texture, index, all);
    }
    desc->parent = patch->parent;
    desc->shows_texture = (uint32_t)shows;
    desc->sources = all[index].sources;
    return status;
}

static int store_zipmap(make_store *store, const make_texture *texture, make_size *sizes, uint32_t self) {
    uint32_t count = texture->patch_count;
    make_placed *all = calloc(count, sizeof *all);
    zt_patch_desc *patches = calloc(count, sizeof *patches);
    make_treatment *treatment = NULL;
    int status = all && patches ? make_treat_begin(store, texture, &treatment)
                                : cmd_fail(CMD_INTERNAL, "out of memory");
    for (uint32_t i = 0; status == CMD_OK && i < count; i++)
        status = store_patch(store, texture, i, sizes, treatment, all, &patches[i]);
    if (status == CMD_OK)
        status = make_treat_finish(treatment, all, patches);
    for (uint32_t i = 0; status == CMD_OK && i < count; i++)
        patches[i].mask = all[i].mask;
    if (status == CMD_OK) {
        sizes[self] = (make_size){all[0].self.width, all[0].self.height};
        status = add_zipmap(store, texture, patches);
    }
    make_treat_end(treatment);
    free(patches);
    free(all);
    return status;
}

/* ---- the file ----------------------------------------------------------------------------------------- */

int make_store_textures(make_store *store, uint32_t count, make_size *sizes) {
    int status = CMD_OK;
    for (uint32_t t = 0; status == CMD_OK && t < count; t++) {
        const make_texture *texture = &store->scene->textures[t];
        if (texture->silmap)
            status = make_store_silmap(store, texture, &sizes[t].width, &sizes[t].height);
        else if (texture->umbrellas)
            status = make_store_umbrellas(store, texture, sizes);
        else
            status = texture->is_zipmap ? store_zipmap(store, texture, sizes, t)
                                        : store_image_texture(store, texture, &sizes[t]);
    }
    return status;
}

static int store_textures(make_store *store) {
    make_size *sizes = calloc(store->scene->texture_count, sizeof *sizes);
    int status = sizes ? CMD_OK : cmd_fail(CMD_INTERNAL, "out of memory");
    if (status == CMD_OK)
        status = make_store_textures(store, store->scene->texture_count, sizes);
    free(sizes);
    return status;
}

static int store_metadata(make_store *store) {
    const make_scene *scene = store->scene;
    for (size_t i = 0; i < scene->metadata_count; i++) {
        zt_diag diag = {.offset = UINT64_MAX};
        zt_result result = zt_writer_set_metadata(store->writer, scene->metadata[i].key, scene->metadata[i].value,
                                                  &diag);
        if (result != ZT_OK)
            return make_fail_writer(scene, "/metadata", result, &diag);
    }
    return CMD_OK;
}

int make_store_scene(cmd_args *args, const make_scene *scene, const char *output, const zt_writer_options *options,
                     cmd_progress *progress) {
    make_store store = {.args = args, .scene = scene, .progress = progress};
    int status = cmd_writer_open(args, output, options, &store.writer);
    if (status != CMD_OK)
        return status;
    store.total = count_images(scene);
    status = store_textures(&store);
    if (status == CMD_OK)
        status = store_metadata(&store);
    cmd_progress_part(progress, 0.9, 1.0);
    if (status == CMD_OK)
        status = cmd_writer_finish(output, store.writer);
    zt_writer_close(store.writer);
    make_store_release(&store);
    return status;
}
