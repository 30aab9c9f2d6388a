/* SPDX-License-Identifier: Apache-2.0 */
/* Umbrella textures in ztex inspect: what is in them, and the storage account of the paper beside what the file has. */
#include "inspect.h"

#include <inttypes.h>
#include <stdlib.h>

/* ---- the account -------------------------------------------------------------------------------------------- */

/* Equation 2 of the paper, each base and umbrella with its own number of vertices. */
static uint64_t count_words(const zt_file *file, const zt_umbrella_info *info) {
    uint64_t words = (uint64_t)info->longest_list * info->grid_x * info->grid_y;
    uint32_t width, height;
    for (uint32_t i = 0; i < info->base_count; i++) {
        if (element_picture(file, &info->bases[i], &width, &height) == 0)
            words += (uint64_t)width * height;
        words += 2 * (uint64_t)info->bases[i].vertex_count;
    }
    words += info->levels[0].umbrella_count + 3 * element_all_vertices(info, 0);
    return words;
}

static uint32_t image_of_base(const zt_umbrella_info *info, uint32_t base) {
    return info->bases[base].shows_texture ? ZT_NONE : info->bases[base].source;
}

/* Each image once. */
static uint64_t stored_images(const zt_file *file, const zt_umbrella_info *info) {
    uint64_t total = 0, decoded, stored;
    uint32_t ground = info->background_kind == ZT_BACKGROUND_IMAGE ? info->background_source : ZT_NONE;
    for (uint32_t i = 0; i < info->base_count; i++) {
        uint32_t image = image_of_base(info, i), k = 0;
        while (k < i && image_of_base(info, k) != image)
            k++;
        if (image == ZT_NONE || k < i)
            continue;
        ins_image_bytes(file, image, &decoded, &stored);
        total += stored;
        ground = ground == image ? ZT_NONE : ground;
    }
    if (ground == ZT_NONE)
        return total;
    ins_image_bytes(file, ground, &decoded, &stored);
    return total + stored;
}

int ins_umbrellas_of(const zt_file *file, uint32_t texture, ins_umbrellas *out) {
    *out = (ins_umbrellas){0};
    zt_umbrella_info *info = &out->info;
    if (zt_get_umbrellas(file, texture, info) != ZT_OK)
        return -1;
    for (uint32_t i = 0; i < info->umbrella_count; i++)
        out->forms[info->umbrellas[i].form % 3]++;
    out->paper_words = count_words(file, info);
    element_scale_of(file, info, &out->scale);
    for (int i = 0; i < 3; i++)
        out->whole_words[i] = out->scale.across[i] * info->grid_x * out->scale.down[i] * info->grid_y;
    out->stored = ins_stored_chunk(file, texture, ZT_KIND_UMBRELLA, "UMBR");
    out->stored_images = stored_images(file, info);
    return 0;
}

void ins_lists(const zt_umbrella_info *info, uint32_t level, uint64_t *entries, uint32_t *longest) {
    const zt_umbrella_level *l = &info->levels[level];
    const uint32_t *starts = info->list_starts + l->first_cell;
    uint32_t cells = l->width * l->height;
    *entries = starts[cells] - starts[0];
    *longest = 0;
    for (uint32_t i = 0; i < cells; i++)
        if (starts[i + 1] - starts[i] > *longest)
            *longest = starts[i + 1] - starts[i];
}

/* ---- names -------------------------------------------------------------------------------------------------- */

const char *ins_ellipsoid_name(unsigned ellipsoid) {
    static const char *const names[] = {"flat", "convex", "concave", "of the base"};
    return ellipsoid < 4 ? names[ellipsoid] : "unknown";
}

const char *ins_background_name(zt_background_kind kind) {
    static const char *const names[] = {"colour", "image", "texture"};
    return (unsigned)kind < 3 ? names[kind] : "unknown";
}

const char *ins_mode_name(zt_umbrella_colour_mode mode) {
    static const char *const names[] = {"barycentric", "inverse-distance"};
    return (unsigned)mode < 2 ? names[mode] : "unknown";
}

/* ---- for people --------------------------------------------------------------------------------------------- */

static void print_level(const zt_umbrella_info *info, uint32_t level) {
    const zt_umbrella_level *l = &info->levels[level];
    uint64_t entries;
    uint32_t longest;
    ins_lists(info, level, &entries, &longest);
    printf("    level %u: %u x %u cells, %u umbrellas, lists of %.1f in the mean, at most %u\n", (unsigned)level,
           (unsigned)l->width, (unsigned)l->height, (unsigned)l->umbrella_count,
           (double)entries / ((double)l->width * l->height), (unsigned)longest);
}

static void print_base(const zt_umbrella_info *info, uint32_t index) {
    const zt_umbrella_base *b = &info->bases[index];
    printf("    base %u: %s %u, %u vertices%s, %u colour variant%s", (unsigned)index,
           b->shows_texture ? "texture" : "image", (unsigned)b->source, (unsigned)b->vertex_count,
           b->first_morph == ZT_NONE ? "" : ", morph", (unsigned)b->variant_count, b->variant_count == 1 ? "" : "s");
    if (b->ellipsoid != ZT_ELLIPSOID_FLAT)
        printf(", %s, %.4g cells high", ins_ellipsoid_name(b->ellipsoid),
               b->height / 65535.0 * (double)info->prism_height);
    printf("\n");
}

static void print_account(const ins_umbrellas *u) {
    char paper[24], file[24], chunk[24], whole[3][24];
    double own = (double)(u->stored + u->stored_images), paper_bytes = 4.0 * (double)u->paper_words;
    cmd_bytes_text(paper, sizeof paper, 4 * u->paper_words);
    cmd_bytes_text(file, sizeof file, u->stored + u->stored_images);
    cmd_bytes_text(chunk, sizeof chunk, u->stored);
    printf("    %s in the file, %s of it umbrellas", file, chunk);
    if (own > 0)
        printf("; the paper's encoding J %s, %.1f times as much", paper, paper_bytes / own);
    printf("\n");
    if (!(u->whole_words[0] > 0) || !(own > 0))
        return;
    for (int i = 0; i < 3; i++)
        cmd_bytes_text(whole[i], sizeof whole[i], (uint64_t)(4 * u->whole_words[i]));
    printf("    an equal texture T %s, %s, %s (least, mean, largest resolution): %.0f, %.0f, %.0f times the file's, "
           "%.0f, %.0f, %.0f times J\n",
           whole[0], whole[1], whole[2], 4 * u->whole_words[0] / own, 4 * u->whole_words[1] / own,
           4 * u->whole_words[2] / own, u->whole_words[0] * 4 / paper_bytes, u->whole_words[1] * 4 / paper_bytes,
           u->whole_words[2] * 4 / paper_bytes);
}

void ins_umbrella_text(const zt_file *file, uint32_t texture) {
    enum { SHOWN = 16 };
    ins_umbrellas u;
    if (ins_umbrellas_of(file, texture, &u) != 0)
        return;
    const zt_umbrella_info *info = &u.info;
    printf("    %u x %u cells, %u umbrellas (%u parametric, %u explicit, %u coloured), colours %s\n",
           (unsigned)info->grid_x, (unsigned)info->grid_y, (unsigned)info->umbrella_count, (unsigned)u.forms[0],
           (unsigned)u.forms[1], (unsigned)u.forms[2], ins_mode_name(info->colour_mode));
    printf("    background %s", ins_background_name(info->background_kind));
    if (info->background_kind == ZT_BACKGROUND_COLOUR)
        printf(" %.3g %.3g %.3g %.3g", (double)info->background[0], (double)info->background[1],
               (double)info->background[2], (double)info->background[3]);
    else
        printf(" %u", (unsigned)info->background_source);
    printf(", prism %.4g cells high", (double)info->prism_height);
    if (info->prism_height > 0)
        printf(", heights taper from %.3g to %.3g cells a pixel", (double)info->taper_start, (double)info->taper_end);
    printf("\n");
    for (uint32_t i = 0; i < info->level_count; i++)
        print_level(info, i);
    for (uint32_t i = 0; i < info->base_count && i < SHOWN; i++)
        print_base(info, i);
    if (info->base_count > SHOWN)
        printf("    and %u bases more: --json\n", (unsigned)(info->base_count - SHOWN));
    print_account(&u);
}

/* ---- for programs ------------------------------------------------------------------------------------------- */

static json_t *floats(const float *values, size_t count) {
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(array, json_real((double)values[i]));
    return array;
}

static json_t *level_json(const zt_umbrella_info *info, uint32_t level) {
    const zt_umbrella_level *l = &info->levels[level];
    uint64_t entries;
    uint32_t longest;
    ins_lists(info, level, &entries, &longest);
    return json_pack("{sI sI sI sI sI sI}", "cells_x", (json_int_t)l->width, "cells_y", (json_int_t)l->height,
                     "umbrellas", (json_int_t)l->umbrella_count, "entries", (json_int_t)entries, "longest_list",
                     (json_int_t)longest, "bits", (json_int_t)l->bits);
}

static json_t *base_json(const zt_umbrella_info *info, uint32_t index) {
    const zt_umbrella_base *b = &info->bases[index];
    int flat = b->ellipsoid == ZT_ELLIPSOID_FLAT;
    return json_pack(
        "{so so sI sb sI ss sf sf}", "image", b->shows_texture ? json_null() : json_integer((json_int_t)b->source),
        "texture", b->shows_texture ? json_integer((json_int_t)b->source) : json_null(), "vertices",
        (json_int_t)b->vertex_count, "morph", b->first_morph != ZT_NONE, "variants", (json_int_t)b->variant_count,
        "ellipsoid", ins_ellipsoid_name(b->ellipsoid), "height", b->height / 65535.0 * (double)info->prism_height,
        "curvature", flat ? 0.0 : (b->curvature + 1) / 65536.0);
}

/* As words of four bytes, and the bytes of the file. */
static json_t *account_json(const ins_umbrellas *u) {
    json_t *whole = json_array();
    for (int i = 0; i < 3; i++)
        json_array_append_new(whole, json_real(4 * u->whole_words[i]));
    return json_pack("{so so so so}", "paper_size", cmd_json_u64(4 * u->paper_words), "whole_size", whole, "file_size",
                     cmd_json_u64(u->stored + u->stored_images), "images_size", cmd_json_u64(u->stored_images));
}

json_t *ins_umbrella_json(const zt_file *file, uint32_t texture) {
    ins_umbrellas u;
    if (ins_umbrellas_of(file, texture, &u) != 0)
        return json_null();
    const zt_umbrella_info *info = &u.info;
    json_t *object = json_object(), *levels = json_array(), *bases = json_array();
    int colour = info->background_kind == ZT_BACKGROUND_COLOUR;
    json_object_set_new(object, "cells_x", json_integer(info->grid_x));
    json_object_set_new(object, "cells_y", json_integer(info->grid_y));
    json_object_set_new(object, "umbrellas", json_integer(info->umbrella_count));
    json_object_set_new(object, "forms",
                        json_pack("{sI sI sI}", "parametric", (json_int_t)u.forms[0], "explicit",
                                  (json_int_t)u.forms[1], "coloured", (json_int_t)u.forms[2]));
    json_object_set_new(object, "longest_list", json_integer(info->longest_list));
    json_object_set_new(object, "colour_mode", json_string(ins_mode_name(info->colour_mode)));
    json_object_set_new(object, "background_kind", json_string(ins_background_name(info->background_kind)));
    json_object_set_new(object, "background_source", colour ? json_null() : json_integer(info->background_source));
    json_object_set_new(object, "background", floats(info->background, 4));
    json_object_set_new(object, "mean", floats(info->mean, 4));
    json_object_set_new(object, "prism_height", json_real((double)info->prism_height));
    json_object_set_new(object, "taper_start", json_real((double)info->taper_start));
    json_object_set_new(object, "taper_end", json_real((double)info->taper_end));
    for (uint32_t i = 0; i < info->level_count; i++)
        json_array_append_new(levels, level_json(info, i));
    for (uint32_t i = 0; i < info->base_count; i++)
        json_array_append_new(bases, base_json(info, i));
    json_object_set_new(object, "levels", levels);
    json_object_set_new(object, "bases", bases);
    json_object_set_new(object, "stored_size", cmd_json_u64(u.stored));
    json_object_set_new(object, "account", account_json(&u));
    return object;
}
