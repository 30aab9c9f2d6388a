/* SPDX-License-Identifier: Apache-2.0 */
/* A scene into a file, as all verbs `make ...` that have a scene do it. */
#include <string.h>

#include "make_args.h"
#include "silmap.h"
#include "umbrellas.h"

/* ---- originals ----------------------------------------------------------------------------------------------- */

static int check_image_output(const make_image *image, const char *output) {
    int status = CMD_OK;
    for (size_t f = 0; image && status == CMD_OK && f < image->file_count; f++)
        status = cmd_check_output(output, &image->files[f].path, 1);
    return status;
}

static int check_base_outputs(const make_umbrellas *u, const char *output) {
    int status = check_image_output(u->background_image, output);
    for (uint32_t b = 0; status == CMD_OK && b < u->base_count; b++) {
        const make_umbrella_base *base = &u->bases[b];
        status = check_image_output(base->image, output);
        if (status == CMD_OK && base->outline.drawing)
            status = cmd_check_output(output, &base->outline.drawing, 1);
        if (status == CMD_OK && base->morph.drawing)
            status = cmd_check_output(output, &base->morph.drawing, 1);
        for (uint32_t v = 0; status == CMD_OK && v < base->input.variant_count; v++)
            status = check_image_output(base->variants[v].image, output);
    }
    return status;
}

static int check_patch_output(const make_patch *patch, uint32_t layer_count, const char *output) {
    int status = check_image_output(patch->mask, output);
    for (uint32_t i = 0; status == CMD_OK && i < layer_count; i++)
        status = check_image_output(patch->images[i], output);
    return status;
}

static int check_output(const make_scene *scene, const char *output) {
    int status = CMD_OK;
    for (uint32_t t = 0; status == CMD_OK && t < scene->texture_count; t++) {
        const make_texture *texture = &scene->textures[t];
        for (uint32_t i = 0; status == CMD_OK && !texture->is_zipmap && i < texture->layer_count; i++)
            status = check_image_output(texture->images[i], output);
        if (status == CMD_OK && texture->umbrellas)
            status = check_base_outputs(texture->umbrellas, output);
        if (status == CMD_OK && texture->silmap && texture->silmap->edges)
            status = cmd_check_output(output, &texture->silmap->edges, 1);
        for (uint32_t i = 0; status == CMD_OK && i < texture->patch_count; i++)
            status = check_patch_output(&texture->patches[i], texture->layer_count, output);
    }
    return status;
}

/* ---- storing -------------------------------------------------------------------------------------------------- */

int make_file_of(cmd_args *args, const make_scene *scene, const char *output, const char *report) {
    cmd_progress progress;
    if (report && strcmp(report, output) == 0)
        return cmd_usage(args, "--report and --output have one name: %s", report);
    int status = check_output(scene, output);
    if (status == CMD_OK && report)
        status = check_output(scene, report);
    if (status != CMD_OK)
        return status;
    cmd_progress_begin(&progress, args, "making");
    zt_writer_options writer = write_options(args, &progress);
    status = make_store_scene(args, scene, output, &writer, &progress);
    cmd_progress_end(&progress);
    return status;
}
