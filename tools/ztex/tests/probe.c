/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is in a texture file, as JSON for the tests, straight from libzt, so that the tests of one verb do not lean on
 * another.
 *
 * Usage: ztex_probe FILE                         everything but the texels, and the findings of a full check
 *        ztex_probe FILE IMAGE LEVEL             the decoded bytes of all layers
 *        ztex_probe FILE look LAYER FRAME EDGE   the first texture, looked up at EDGE x EDGE pixels: four floats each
 */
#include <stdlib.h>

#include <jansson.h>

#include <zt/zt.h>
#include <zt/zt_check.h>

static int add_finding(void *user, const zt_finding *f) {
    json_array_append_new(user, json_sprintf("%u %s: %s", f->rule, f->path, f->text));
    return 0;
}

static json_t *matrix_of(const double *m) {
    json_t *list = json_array();
    for (int i = 0; i < 9; i++)
        json_array_append_new(list, json_real(m[i]));
    return list;
}

static json_t *patches_of(const zt_file *file, uint32_t texture, const zt_texture_info *info) {
    json_t *list = json_array();
    for (uint32_t p = 0; p < info->patch_count; p++) {
        zt_patch_info patch;
        json_t *images = json_array();
        zt_get_patch(file, texture, p, &patch);
        for (uint32_t l = 0; l < info->layer_count; l++)
            json_array_append_new(images, json_integer(zt_get_patch_image(file, texture, p, l)));
        json_array_append_new(list, json_pack("{si si si so so so}", "parent", (int)patch.parent, "texture",
                                              (int)patch.texture, "mask", (int)patch.mask, "images", images, "matrix",
                                              matrix_of(patch.matrix), "root_matrix", matrix_of(patch.root_matrix)));
    }
    return list;
}

static json_t *textures_of(const zt_file *file, uint32_t count) {
    json_t *list = json_array();
    for (uint32_t t = 0; t < count; t++) {
        zt_texture_info info;
        json_t *layers = json_array();
        zt_get_texture(file, t, &info);
        for (uint32_t l = 0; l < info.layer_count; l++) {
            zt_layer_info layer;
            zt_get_layer(file, t, l, &layer);
            json_array_append_new(layers, json_pack("[ii]", (int)layer.semantic, (int)layer.image));
        }
        json_array_append_new(list, json_pack("{ss si s[iii] so so}", "name", info.name, "kind", (int)info.kind, "wrap",
                                              (int)info.wrap_u, (int)info.wrap_v, (int)info.wrap_w, "layers", layers,
                                              "patches", patches_of(file, t, &info)));
    }
    return list;
}

static json_t *images_of(const zt_file *file, uint32_t count) {
    json_t *list = json_array();
    for (uint32_t i = 0; i < count; i++) {
        zt_image_info m;
        zt_get_image(file, i, &m);
        const zt_format_info *format = zt_find_format(m.format);
        json_array_append_new(list, json_pack("{ss s[iii] si si si si si si si}", "format",
                                              format ? format->name : "unknown", "size", (int)m.width, (int)m.height,
                                              (int)m.depth, "layers", (int)m.layers, "layer_kind", m.layer_kind,
                                              "levels", (int)m.levels, "tile_edge", (int)m.tile_edge, "alpha",
                                              m.alpha_mode, "primaries", m.primaries, "transfer", m.transfer));
    }
    return list;
}

static json_t *metadata_of(const zt_file *file, zt_diag *diag) {
    json_t *object = json_object();
    const char *key, *value;
    uint32_t count = 0;
    zt_load_metadata(file, &count, diag);
    for (uint32_t i = 0; i < count; i++)
        if (zt_get_metadata(file, i, &key, &value) == ZT_OK)
            json_object_set_new(object, key, json_string(value));
    return object;
}

static int print_texels(const zt_file *file, uint32_t image, uint32_t level, zt_diag *diag) {
    zt_image_info info;
    zt_level_info size;
    if (zt_get_image(file, image, &info) != ZT_OK || zt_get_level(file, image, level, &size) != ZT_OK)
        return 1;
    void *texels = malloc((size_t)size.layer_size);
    zt_result result = texels ? ZT_OK : ZT_NO_MEMORY;
    for (uint32_t l = 0; result == ZT_OK && l < info.layers; l++) {
        result = zt_decode_level(file, image, level, l, texels, (size_t)size.layer_size, 0, NULL, diag);
        if (result == ZT_OK)
            fwrite(texels, 1, (size_t)size.layer_size, stdout);
    }
    free(texels);
    return result != ZT_OK;
}

static void print_facts(const zt_file *file, const char *path, zt_diag *diag) {
    zt_file_info info;
    zt_check_summary summary;
    json_t *findings = json_array();
    zt_check_options check = {.user = findings, .finding = add_finding};
    zt_get_file(file, &info);
    zt_check_path(path, &check, diag, &summary);
    json_t *root = json_pack("{so so so so}", "findings", findings, "textures", textures_of(file, info.texture_count),
                             "images", images_of(file, info.image_count), "metadata", metadata_of(file, diag));
    json_dumpf(root, stdout, JSON_INDENT(1));
    json_decref(root);
}

static int print_lookups(const zt_file *file, char **words, zt_diag *diag) {
    zt_sampler_options options = {.filter = ZT_FILTER_TRILINEAR, .layer = (uint32_t)atoi(words[0])};
    uint32_t frame = (uint32_t)atoi(words[1]), edge = (uint32_t)atoi(words[2]);
    double pixel = 1.0 / edge;
    zt_sampler *sampler;
    zt_result result = zt_sampler_open(file, 0, &options, diag, &sampler);
    for (uint32_t i = 0; result == ZT_OK && i < edge * edge; i++) {
        zt_point point = {.u = (i % edge + 0.5) * pixel,
                          .v = (i / edge + 0.5) * pixel,
                          .du_dx = pixel,
                          .dv_dy = pixel,
                          .array_layer = frame};
        float rgba[4];
        result = zt_sample(sampler, &point, 1, rgba, diag);
        fwrite(rgba, sizeof rgba, 1, stdout);
    }
    zt_sampler_close(sampler);
    if (result != ZT_OK)
        fprintf(stderr, "%s\n", diag->text);
    return result != ZT_OK;
}

int main(int argc, char **argv) {
    zt_diag diag = {0};
    zt_file *file;
    int failed = 0;
    if (argc < 2 || zt_open_path(argv[1], NULL, &diag, &file) != ZT_OK) {
        fprintf(stderr, "%s\n", diag.text);
        return 1;
    }
    if (argc == 4)
        failed = print_texels(file, (uint32_t)atoi(argv[2]), (uint32_t)atoi(argv[3]), &diag);
    else if (argc == 6)
        failed = print_lookups(file, argv + 3, &diag);
    else
        print_facts(file, argv[1], &diag);
    zt_close(file);
    return failed;
}
