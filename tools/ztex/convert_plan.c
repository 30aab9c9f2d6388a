/* SPDX-License-Identifier: Apache-2.0 */
/* What becomes of each image: who uses it, and what the wishes mean for it. */
#include "convert.h"
#include "pick.h"

#include <string.h>

/* ---- uses ------------------------------------------------------------------------------------------------- */

static convert_use *use_of(convert_job *job, uint32_t image) {
    return image < job->file.image_count ? &job->uses[image] : NULL;
}

static void use_image(convert_job *job, uint32_t image, uint32_t semantic, const uint8_t wrap[3]) {
    convert_use *use = use_of(job, image);
    if (!use || use->used)
        return;
    use->used = 1;
    use->semantic = semantic;
    memcpy(use->wrap, wrap, 3);
}

static void use_patch(convert_job *job, uint32_t texture, const zt_texture_info *info, uint32_t patch) {
    static const uint8_t clamp[3] = {ZT_WRAP_CLAMP, ZT_WRAP_CLAMP, ZT_WRAP_CLAMP};
    uint8_t root_wrap[3] = {(uint8_t)info->wrap_u, (uint8_t)info->wrap_v, (uint8_t)info->wrap_w};
    zt_patch_info placed;
    if (zt_get_patch(job->input.file, texture, patch, &placed) != ZT_OK)
        return;
    for (uint32_t l = 0; placed.texture == ZT_NONE && l < info->layer_count; l++) {
        zt_layer_info layer;
        uint32_t image = zt_get_patch_image(job->input.file, texture, patch, l);
        if (zt_get_layer(job->input.file, texture, l, &layer) != ZT_OK)
            continue;
        use_image(job, image, layer.semantic, patch ? clamp : root_wrap);
        if (patch > 0 && l == 0 && placed.mask == ZT_NONE && use_of(job, image))
            use_of(job, image)->covers = 1;
    }
    convert_use *mask = use_of(job, placed.mask);
    if (!mask)
        return;
    use_image(job, placed.mask, ZT_SEMANTIC_OPACITY, clamp);
    mask->is_mask = mask->covers = 1;
}

/* The pictures of bases end where they end, whatever the texture does. */
static void use_umbrellas(convert_job *job, uint32_t texture, const zt_texture_info *info) {
    static const uint8_t clamp[3] = {ZT_WRAP_CLAMP, ZT_WRAP_CLAMP, ZT_WRAP_CLAMP};
    uint8_t wrap[3] = {(uint8_t)info->wrap_u, (uint8_t)info->wrap_v, (uint8_t)info->wrap_w};
    zt_umbrella_info umbrellas;
    zt_layer_info row;
    if (zt_get_umbrellas(job->input.file, texture, &umbrellas) != ZT_OK ||
        zt_get_layer(job->input.file, texture, 0, &row) != ZT_OK)
        return;
    for (uint32_t i = 0; i < umbrellas.base_count; i++)
        if (!umbrellas.bases[i].shows_texture)
            use_image(job, umbrellas.bases[i].source, row.semantic, clamp);
    if (umbrellas.background_kind == ZT_BACKGROUND_IMAGE)
        use_image(job, umbrellas.background_source, row.semantic, wrap);
}

static void use_layer(convert_job *job, uint32_t texture, const zt_texture_info *info, uint32_t layer) {
    uint8_t wrap[3] = {(uint8_t)info->wrap_u, (uint8_t)info->wrap_v, (uint8_t)info->wrap_w};
    zt_layer_info row;
    if (zt_get_layer(job->input.file, texture, layer, &row) != ZT_OK)
        return;
    use_image(job, row.image, row.semantic, wrap);
    use_image(job, zt_get_silmap_minified(job->input.file, texture, layer), row.semantic, wrap);
    if (info->kind == ZT_KIND_SILMAP && use_of(job, row.image))
        use_of(job, row.image)->is_samples = 1;
}

int convert_find_uses(convert_job *job) {
    int everything = !cmd_given(job->args, "keep-textures") && !job->strip_patches;
    for (uint32_t t = 0; t < job->file.texture_count; t++) {
        zt_texture_info info;
        if (!job->keep[t] || zt_get_texture(job->input.file, t, &info) != ZT_OK)
            continue;
        uint32_t patches = job->strip_patches && info.patch_count > 1 ? 1 : info.patch_count;
        for (uint32_t p = 0; p < patches; p++)
            use_patch(job, t, &info, p);
        for (uint32_t l = 0; patches == 0 && l < info.layer_count; l++)
            use_layer(job, t, &info, l);
        use_umbrellas(job, t, &info);
    }
    for (uint32_t i = 0; everything && i < job->file.image_count; i++)
        job->uses[i].used = 1;
    return CMD_OK;
}

/* ---- plans ------------------------------------------------------------------------------------------------ */

static int wants_format(const convert_job *job, const convert_use *use) {
    if (!job->format || use->is_mask)
        return 0;
    return job->semantic >= 0 ? use->semantic == (uint32_t)job->semantic : pick_is_colour(use->semantic);
}

/* SRGB formats are coded so, floats hold light; other integers keep the coding that they had. */
static uint32_t transfer_for(const convert_job *job, uint32_t now) {
    if (job->format->is_srgb)
        return 13;
    if (job->transfer >= 0)
        return (uint32_t)job->transfer;
    return job->format->is_float ? 8 : now;
}

static int plan_format(convert_job *job, uint32_t image, const convert_use *use, convert_plan *plan) {
    const zt_format_info *now = zt_find_format(plan->from.format);
    if (!now || !now->is_plain)
        return cmd_fail(CMD_UNSUPPORTED, "%s: image %u has the format %s, which cannot be converted", job->input.name,
                        (unsigned)image, now ? now->name : "unknown");
    if (use->covers && plan->from.alpha_mode != ZT_ALPHA_NONE && !job->format->has_alpha)
        return cmd_fail(CMD_USAGE, "%s: image %u is a patch: it needs a format with alpha, not %s", job->input.name,
                        (unsigned)image, job->format->name);
    uint32_t transfer = transfer_for(job, plan->from.transfer);
    if (transfer != plan->from.transfer && !(zt_transfer_known(transfer) && zt_transfer_known(plan->from.transfer)))
        return cmd_fail(CMD_UNSUPPORTED, "%s: image %u has the transfer %u, which cannot be converted", job->input.name,
                        (unsigned)image, (unsigned)plan->from.transfer);
    if (job->format->channels < now->channels)
        cmd_warn(job->args, "image %u: %s has %u channels, %s keeps %u", (unsigned)image, now->name,
                 (unsigned)now->channels, job->format->name, (unsigned)job->format->channels);
    plan->reformat = job->format->format != plan->from.format || transfer != plan->from.transfer;
    plan->to.format = job->format->format;
    plan->to.transfer = (uint8_t)transfer;
    if (!job->format->has_alpha)
        plan->to.alpha_mode = ZT_ALPHA_NONE;
    job->reformatted++;
    return CMD_OK;
}

static uint32_t full_levels(const zt_image_info *info) {
    uint32_t most = info->width > info->height ? info->width : info->height, levels = 1;
    for (most = most > info->depth ? most : info->depth; most > 1; most /= 2)
        levels++;
    return levels;
}

/* Sets levels, and how they are made. */
static int plan_levels(const convert_job *job, uint32_t image, const convert_use *use, convert_plan *plan) {
    uint32_t full = full_levels(&plan->from), wanted = job->levels ? job->levels : plan->from.levels;
    const zt_format_info *format = zt_find_format(plan->to.format);
    int plain = format && format->is_plain;
    if (job->all_levels || (job->rebuild && !job->levels))
        wanted = full;
    if (wanted > full)
        wanted = full;
    int make = job->rebuild || wanted > plan->from.levels;
    plan->to.levels = wanted;
    if (use->is_samples)
        plan->to.levels = plan->from.levels;
    if (!make || use->is_samples)
        return CMD_OK;
    if (!plain)
        return cmd_fail(CMD_UNSUPPORTED, "%s: image %u: mip levels of this format cannot be made", job->input.name,
                        (unsigned)image);
    plan->to.given_levels = 0;
    plan->to.mip_filter = job->mip_filter;
    plan->to.is_normal = use->semantic == ZT_SEMANTIC_NORMAL && !use->is_mask && format->channels > 1;
    plan->to.zero_border = (uint8_t)use->covers;
    plan->to.wrap_u = use->wrap[0];
    plan->to.wrap_v = use->wrap[1];
    plan->to.wrap_w = use->wrap[2];
    return CMD_OK;
}

int convert_plan_image(convert_job *job, uint32_t image, convert_plan *plan) {
    const convert_use *use = &job->uses[image];
    zt_image_info *from = &plan->from;
    memset(plan, 0, sizeof *plan);
    if (zt_get_image(job->input.file, image, from) != ZT_OK)
        return cmd_fail(CMD_INTERNAL, "%s: there is no image %u", job->input.name, (unsigned)image);
    zt_describe_image(from, &plan->to);
    plan->to.tile_edge = job->tile_edge ? job->tile_edge : from->tile_edge;
    int status = wants_format(job, use) ? plan_format(job, image, use, plan) : CMD_OK;
    if (status == CMD_OK)
        status = plan_levels(job, image, use, plan);
    plan->stored = !job->recode && !plan->reformat && plan->to.given_levels && plan->to.tile_edge == from->tile_edge &&
                   plan->to.levels == from->levels;
    return status;
}
