/* SPDX-License-Identifier: Apache-2.0 */
/* ztex inspect for programs: spec/inspect.schema.json. */
#include "inspect.h"

/* A name where there is one, else null. */
static json_t *name_or_null(const char *name) {
    return name ? json_string(name) : json_null();
}

static json_t *index_or_null(uint32_t index) {
    return index == ZT_NONE ? json_null() : json_integer(index);
}

static json_t *numbers(const double *values, size_t count) {
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++) {
        json_t *number = json_real(values[i]); /* NULL for what is not finite */
        json_array_append_new(array, number ? number : json_null());
    }
    return array;
}

/* ---- parts ------------------------------------------------------------------------------------------ */

static json_t *error_json(const zt_diag *error) {
    static const char *const kinds[] = {"ok",      "again",     "bad-argument", "no-memory", "io",        "not-ztex",
                                        "corrupt", "truncated", "unsupported",  "limit",     "cancelled", "internal"};
    const zt_rule *rule = zt_find_rule(error->rule);
    json_t *object = json_object();
    json_object_set_new(object, "kind", json_string((unsigned)error->result < 12 ? kinds[error->result] : "internal"));
    json_object_set_new(object, "rule", error->rule ? json_integer(error->rule) : json_null());
    json_object_set_new(object, "name", name_or_null(rule ? rule->name : NULL));
    json_object_set_new(object, "offset", error->rule ? cmd_json_offset(error->offset) : json_null());
    json_object_set_new(object, "path", cmd_json_text(error->path));
    json_object_set_new(object, "text", cmd_json_text(error->text[0] ? error->text : zt_result_text(error->result)));
    return object;
}

static json_t *chunk_json(const zt_chunk_info *c) {
    json_t *object = json_object();
    json_object_set_new(object, "type", cmd_json_text(c->type));
    json_object_set_new(object, "version", json_integer(c->version));
    json_object_set_new(object, "critical", json_boolean(c->flags & 1));
    json_object_set_new(object, "safe_to_copy", json_boolean(c->flags & 2));
    json_object_set_new(object, "codec", json_integer(c->codec));
    json_object_set_new(object, "offset", cmd_json_u64(c->offset));
    json_object_set_new(object, "stored_size", cmd_json_u64(c->stored_size));
    json_object_set_new(object, "decoded_size", cmd_json_u64(c->decoded_size));
    json_object_set_new(object, "stored_hash", cmd_json_hash(c->stored_hash));
    json_object_set_new(object, "decoded_hash", cmd_json_hash(c->decoded_hash));
    return object;
}

static json_t *chunks_json(const zt_file *file) {
    json_t *array = json_array();
    zt_chunk_info chunk;
    for (uint32_t i = 0; zt_get_chunk(file, i, &chunk) == ZT_OK; i++)
        json_array_append_new(array, chunk_json(&chunk));
    return array;
}

static json_t *salvaged_json(const ins_job *job) {
    json_t *array = json_array();
    for (uint32_t i = 0; i < job->salvaged_count; i++) {
        json_t *chunk = chunk_json(&job->salvaged[i].info);
        json_object_set_new(chunk, "intact", json_boolean(job->salvaged[i].intact));
        json_array_append_new(array, chunk);
    }
    return array;
}

static json_t *layers_json(const zt_file *file, uint32_t texture, uint32_t count) {
    json_t *array = json_array();
    zt_layer_info layer;
    for (uint32_t i = 0; i < count; i++) {
        json_t *object = json_object();
        zt_get_layer(file, texture, i, &layer);
        json_object_set_new(object, "semantic", json_integer(layer.semantic));
        json_object_set_new(object, "semantic_name", name_or_null(cmd_semantic_name(layer.semantic)));
        json_object_set_new(object, "image", index_or_null(layer.image));
        json_array_append_new(array, object);
    }
    return array;
}

static json_t *images_of_patch(const zt_file *file, uint32_t texture, uint32_t patch, uint32_t layers) {
    json_t *array = json_array();
    for (uint32_t k = 0; k < layers; k++) {
        uint32_t image = zt_get_patch_image(file, texture, patch, k);
        if (image != ZT_NONE)
            json_array_append_new(array, json_integer(image));
    }
    return array;
}

static json_t *patch_json(const zt_file *file, uint32_t texture, uint32_t patch, uint32_t layers) {
    zt_patch_info info;
    ins_placement place;
    json_t *object = json_object(), *corners = json_array();
    zt_get_patch(file, texture, patch, &info);
    ins_place(file, texture, patch, &place);
    json_object_set_new(object, "parent", patch == 0 ? json_null() : json_integer(info.parent));
    json_object_set_new(object, "texture", index_or_null(info.texture));
    json_object_set_new(object, "images", images_of_patch(file, texture, patch, layers));
    json_object_set_new(object, "mask", index_or_null(info.mask));
    json_object_set_new(object, "matrix", numbers(info.matrix, 9));
    json_object_set_new(object, "root_matrix", numbers(info.root_matrix, 9));
    json_object_set_new(object, "offset", place.is_box ? numbers(place.offset, 2) : json_null());
    json_object_set_new(object, "scale", place.is_box ? numbers(place.scale, 2) : json_null());
    json_object_set_new(object, "box", numbers(place.box, 4));
    for (int i = 0; i < 4; i++)
        json_array_append_new(corners, numbers(place.corners[i], 2));
    json_object_set_new(object, "corners", corners);
    json_object_set_new(object, "finer", place.finer[0] > 0 ? numbers(place.finer, 2) : json_null());
    return object;
}

static json_t *silmap_json(const zt_file *file, uint32_t texture, uint32_t layers) {
    ins_cells cells;
    json_t *minified = json_array();
    if (ins_silmap(file, texture, &cells)) {
        json_decref(minified);
        return json_null();
    }
    json_t *object = json_object();
    json_object_set_new(object, "cells_x", json_integer(cells.info.cells_x));
    json_object_set_new(object, "cells_y", json_integer(cells.info.cells_y));
    json_object_set_new(object, "cell_layers", json_integer(cells.info.cell_layers));
    json_object_set_new(object, "filter", json_string(ins_filter_name(cells.info.filter)));
    json_object_set_new(object, "cut_cells", cmd_json_u64(cells.cut));
    json_object_set_new(object, "cells_size", cmd_json_u64(cells.memory));
    json_object_set_new(object, "stored_size", cmd_json_u64(cells.stored));
    for (uint32_t i = 0; i < layers; i++)
        json_array_append_new(minified, index_or_null(zt_get_silmap_minified(file, texture, i)));
    json_object_set_new(object, "minified", minified);
    return object;
}

static json_t *textures_json(const zt_file *file) {
    json_t *array = json_array();
    zt_texture_info info;
    for (uint32_t i = 0; zt_get_texture(file, i, &info) == ZT_OK; i++) {
        json_t *object = json_object(), *patches = json_array();
        json_object_set_new(object, "name", cmd_json_text(info.name ? info.name : ""));
        json_object_set_new(object, "kind", json_string(cmd_kind_name((uint32_t)info.kind)));
        json_object_set_new(object, "wrap_u", json_string(cmd_wrap_name((uint32_t)info.wrap_u)));
        json_object_set_new(object, "wrap_v", json_string(cmd_wrap_name((uint32_t)info.wrap_v)));
        json_object_set_new(object, "wrap_w", json_string(cmd_wrap_name((uint32_t)info.wrap_w)));
        json_object_set_new(object, "layers", layers_json(file, i, info.layer_count));
        for (uint32_t k = 0; k < info.patch_count; k++)
            json_array_append_new(patches, patch_json(file, i, k, info.layer_count));
        json_object_set_new(object, "patches", patches);
        if (info.kind == ZT_KIND_SILMAP)
            json_object_set_new(object, "silmap", silmap_json(file, i, info.layer_count));
        if (info.kind == ZT_KIND_UMBRELLA)
            json_object_set_new(object, "umbrellas", ins_umbrella_json(file, i));
        json_array_append_new(array, object);
    }
    return array;
}

/* ---- images ----------------------------------------------------------------------------------------- */

static json_t *tiles_json(const zt_file *file, uint32_t image, uint32_t level, uint64_t count) {
    json_t *array = json_array();
    zt_tile_info info;
    for (uint64_t i = 0; i < count; i++) {
        if (zt_get_tile(file, image, level, i, &info, NULL) != ZT_OK || cmd_interrupted())
            break;
        json_t *object = json_object();
        json_object_set_new(object, "offset", cmd_json_u64(info.offset));
        json_object_set_new(object, "stored_size", json_integer(info.stored_size));
        json_object_set_new(object, "decoded_size", json_integer(info.decoded_size));
        json_object_set_new(object, "codec", json_integer(info.codec));
        json_object_set_new(object, "hash", cmd_json_hash(info.hash));
        json_array_append_new(array, object);
    }
    return array;
}

static json_t *level_json(const ins_job *job, uint32_t image, const zt_image_info *info, uint32_t level) {
    zt_level_info l;
    json_t *object = json_object();
    zt_get_level(job->file, image, level, &l);
    json_object_set_new(object, "width", json_integer(l.width));
    json_object_set_new(object, "height", json_integer(l.height));
    json_object_set_new(object, "depth", json_integer(l.depth));
    json_object_set_new(object, "tail", json_boolean(level >= info->tail_level));
    json_object_set_new(object, "tile_count", cmd_json_u64(l.tile_count));
    json_object_set_new(object, "size", cmd_json_u64(l.level_size));
    json_object_set_new(object, "unit_offset", cmd_json_u64(l.unit_offset));
    json_object_set_new(object, "unit_size", cmd_json_u64(l.unit_size));
    json_object_set_new(object, "here", json_boolean(zt_level_state(job->file, image, level) == ZT_OK));
    if (job->tiles && ins_begins_unit(info, level))
        json_object_set_new(object, "tiles", tiles_json(job->file, image, level, l.tile_count));
    return object;
}

static json_t *image_json(const ins_job *job, uint32_t image, const zt_image_info *info) {
    const zt_format_info *format = zt_find_format(info->format);
    json_t *object = json_object(), *levels = json_array();
    uint64_t decoded, stored;
    ins_image_bytes(job->file, image, &decoded, &stored);
    json_object_set_new(object, "format", json_integer(info->format));
    json_object_set_new(object, "format_name", name_or_null(format ? format->name : NULL));
    json_object_set_new(object, "width", json_integer(info->width));
    json_object_set_new(object, "height", json_integer(info->height));
    json_object_set_new(object, "depth", json_integer(info->depth));
    json_object_set_new(object, "layers", json_integer(info->layers));
    json_object_set_new(object, "layer_kind", name_or_null(cmd_layer_kind_name(info->layer_kind)));
    json_object_set_new(object, "tile_edge", json_integer(info->tile_edge));
    json_object_set_new(object, "block_width", json_integer(info->block_width));
    json_object_set_new(object, "block_height", json_integer(info->block_height));
    json_object_set_new(object, "block_bytes", json_integer(info->block_bytes));
    json_object_set_new(object, "alpha", name_or_null(cmd_alpha_name(info->alpha_mode)));
    json_object_set_new(object, "primaries", json_integer(info->primaries));
    json_object_set_new(object, "primaries_name", name_or_null(cmd_primaries_name(info->primaries)));
    json_object_set_new(object, "transfer", json_integer(info->transfer));
    json_object_set_new(object, "transfer_name", name_or_null(cmd_transfer_name(info->transfer)));
    json_object_set_new(object, "tail_level",
                        info->tail_level < info->levels ? json_integer(info->tail_level) : json_null());
    json_object_set_new(object, "decoded_size", cmd_json_u64(decoded));
    json_object_set_new(object, "stored_size", cmd_json_u64(stored));
    for (uint32_t k = 0; k < info->levels; k++)
        json_array_append_new(levels, level_json(job, image, info, k));
    json_object_set_new(object, "levels", levels);
    return object;
}

static json_t *images_json(const ins_job *job) {
    json_t *array = json_array();
    zt_image_info info;
    for (uint32_t i = 0; zt_get_image(job->file, i, &info) == ZT_OK && !cmd_interrupted(); i++)
        json_array_append_new(array, image_json(job, i, &info));
    return array;
}

/* Pairs, because a key may be any text. */
static json_t *metadata_json(const zt_file *file) {
    uint32_t count;
    const char *key, *value;
    if (zt_load_metadata(file, &count, NULL) != ZT_OK)
        return json_null();
    json_t *array = json_array();
    for (uint32_t i = 0; i < count; i++) {
        json_t *pair = json_object();
        zt_get_metadata(file, i, &key, &value);
        json_object_set_new(pair, "key", cmd_json_text(key));
        json_object_set_new(pair, "value", cmd_json_text(value));
        json_array_append_new(array, pair);
    }
    return array;
}

json_t *ins_json(const ins_job *job) {
    json_t *object = json_object();
    zt_file_info info;
    json_object_set_new(object, "file", job->textconv ? json_null() : cmd_json_text(job->name));
    json_object_set_new(object, "valid", json_boolean(job->whole));
    json_object_set_new(object, "error", job->whole ? json_null() : error_json(&job->error));
    if (!job->file) {
        json_object_set_new(object, "found_chunks", salvaged_json(job));
        return object;
    }
    zt_get_file(job->file, &info);
    json_object_set_new(object, "major", json_integer(info.major));
    json_object_set_new(object, "minor", json_integer(info.minor));
    json_object_set_new(object, "size", cmd_json_u64(info.file_size));
    json_object_set_new(object, "chunks", chunks_json(job->file));
    json_object_set_new(object, "textures", textures_json(job->file));
    json_object_set_new(object, "images", images_json(job));
    json_object_set_new(object, "metadata", metadata_json(job->file));
    return object;
}
