/* SPDX-License-Identifier: Apache-2.0 */
/* ztex inspect for people. Everything that comes from the file goes through cmd_print_safe. */
#include "inspect.h"

#include <inttypes.h>
#include <string.h>

static const char *bytes_of(uint64_t bytes, char buffer[24]) {
    return cmd_bytes_text(buffer, 24, bytes);
}

static void print_ratio(uint64_t stored, uint64_t decoded) {
    if (decoded > 0)
        printf(" (%.1f %%)", 100.0 * (double)stored / (double)decoded);
}

/* ---- file and chunks -------------------------------------------------------------------------------- */

static void print_error(const ins_job *job) {
    const zt_diag *e = &job->error;
    printf("  NOT VALID: %s", e->text[0] ? e->text : zt_result_text(e->result));
    if (e->rule)
        printf("\n  rule %u (%s, %s)", (unsigned)e->rule, zt_find_rule(e->rule) ? zt_find_rule(e->rule)->name : "?",
               zt_find_rule(e->rule) ? zt_find_rule(e->rule)->anchor : "?");
    if (e->path[0])
        printf(", in %s", e->path);
    if (e->rule && e->offset != UINT64_MAX)
        printf(", offset %" PRIu64, e->offset);
    printf("\n");
    if (job->file)
        printf("  what follows is what the directory and the first chunks say; texels may be missing\n");
}

static void print_file(const ins_job *job) {
    char buffer[24];
    zt_file_info info;
    zt_get_file(job->file, &info);
    printf("  .ztex %u.%u, %s, %u chunks, %u texture%s, %u image%s\n", info.major, info.minor,
           bytes_of(info.file_size, buffer), (unsigned)info.chunk_count, (unsigned)info.texture_count,
           info.texture_count == 1 ? "" : "s", (unsigned)info.image_count, info.image_count == 1 ? "" : "s");
}

static void print_chunk(const zt_chunk_info *c, const char *end) {
    char buffer[24], number[16];
    printf("  ");
    cmd_print_safe(stdout, c->type);
    printf("  offset %" PRIu64 ", %s", c->offset, bytes_of(c->stored_size, buffer));
    if (c->codec)
        printf(" %s of %s", ins_name(ins_codec_name(c->codec), c->codec, number, sizeof number),
               bytes_of(c->decoded_size, buffer));
    if (c->version != 1)
        printf(", version %u", c->version);
    printf("%s%s%s\n", c->flags & 1 ? ", critical" : "", c->flags & 2 ? ", safe to copy" : "", end);
}

static void print_chunks(const ins_job *job) {
    zt_chunk_info chunk;
    printf("chunks\n");
    for (uint32_t i = 0; zt_get_chunk(job->file, i, &chunk) == ZT_OK; i++)
        print_chunk(&chunk, "");
}

static void print_salvaged(const ins_job *job) {
    if (job->salvaged_count > 0)
        printf("chunks that can be found\n");
    for (uint32_t i = 0; i < job->salvaged_count; i++)
        print_chunk(&job->salvaged[i].info, job->salvaged[i].intact ? "" : ", DAMAGED");
}

/* ---- textures ------------------------------------------------------------------------------------- */

static void print_layers(const zt_file *file, uint32_t texture, const zt_texture_info *info) {
    char number[16];
    zt_layer_info layer;
    for (uint32_t k = 0; k < info->layer_count; k++) {
        zt_get_layer(file, texture, k, &layer);
        printf("    layer %u: %s", (unsigned)k,
               ins_name(cmd_semantic_name(layer.semantic), layer.semantic, number, sizeof number));
        if (layer.image != ZT_NONE)
            printf(", image %u", (unsigned)layer.image);
        uint32_t minified = zt_get_silmap_minified(file, texture, k);
        if (minified != ZT_NONE)
            printf(", minified %u", (unsigned)minified);
        printf("\n");
    }
}

static void print_matrix(const double m[9]) {
    for (int r = 0; r < 3; r++)
        printf("        [ %.17g  %.17g  %.17g ]\n", m[3 * r], m[3 * r + 1], m[3 * r + 2]);
}

static void print_patch(const zt_file *file, uint32_t texture, uint32_t patch, uint32_t layers) {
    zt_patch_info info;
    ins_placement place;
    zt_get_patch(file, texture, patch, &info);
    ins_place(file, texture, patch, &place);
    printf("    patch %u: ", (unsigned)patch);
    if (info.texture != ZT_NONE)
        printf("texture %u", (unsigned)info.texture);
    for (uint32_t k = 0; info.texture == ZT_NONE && k < layers; k++)
        printf("%s %u",
               k            ? ","
               : layers > 1 ? "images"
                            : "image",
               (unsigned)zt_get_patch_image(file, texture, patch, k));
    if (info.mask != ZT_NONE)
        printf(", mask %u", (unsigned)info.mask);
    if (patch == 0) {
        printf(", root\n");
        return;
    }
    printf(", parent %u", (unsigned)info.parent);
    if (place.is_box)
        printf(", at %.6g, %.6g, size %.6g x %.6g of the parent", place.offset[0], place.offset[1], place.scale[0],
               place.scale[1]);
    printf("\n      covers u %.6g to %.6g, v %.6g to %.6g of the root", place.box[0], place.box[2], place.box[1],
           place.box[3]);
    if (place.finer[0] > 0)
        printf(", %.4g x %.4g times as fine", place.finer[0], place.finer[1]);
    printf("\n");
    if (!place.is_box)
        print_matrix(info.matrix);
}

static void print_patches(const ins_job *job, uint32_t texture, const zt_texture_info *info) {
    enum { SHOWN = 16 };
    uint32_t most = job->patches ? info->patch_count : SHOWN;
    for (uint32_t i = 0; i < info->patch_count && i < most; i++)
        print_patch(job->file, texture, i, info->layer_count);
    if (info->patch_count > most)
        printf("    and %u patches more: --patches\n", (unsigned)(info->patch_count - most));
}

static void print_silmap(const zt_file *file, uint32_t texture) {
    char a[24];
    ins_cells cells;
    if (ins_silmap(file, texture, &cells))
        return;
    double count = (double)cells.memory;
    printf("    %u x %u cells", (unsigned)cells.info.cells_x, (unsigned)cells.info.cells_y);
    if (cells.info.cell_layers > 1)
        printf(" x %u", (unsigned)cells.info.cell_layers);
    printf(", %" PRIu64 " of them cut (%.1f %%), filter %s\n", cells.cut, 100.0 * (double)cells.cut / count,
           ins_filter_name(cells.info.filter));
    printf("    a byte a cell in memory, %.3f in the file (%s)\n", (double)cells.stored / count,
           bytes_of(cells.stored, a));
}

static void print_textures(const ins_job *job) {
    zt_texture_info info;
    printf("textures\n");
    for (uint32_t i = 0; zt_get_texture(job->file, i, &info) == ZT_OK; i++) {
        printf("  %u \"", (unsigned)i);
        cmd_print_safe(stdout, info.name ? info.name : "");
        printf("\": %s, wrap %s, %s, %s", cmd_kind_name((uint32_t)info.kind), cmd_wrap_name((uint32_t)info.wrap_u),
               cmd_wrap_name((uint32_t)info.wrap_v), cmd_wrap_name((uint32_t)info.wrap_w));
        if (info.kind == ZT_KIND_ZIPMAP)
            printf(", %u patches", (unsigned)info.patch_count);
        printf("\n");
        print_layers(job->file, i, &info);
        print_silmap(job->file, i);
        ins_umbrella_text(job->file, i);
        print_patches(job, i, &info);
    }
}

/* ---- images ----------------------------------------------------------------------------------------- */

static void print_size(const zt_image_info *info) {
    printf("%u x %u", (unsigned)info->width, (unsigned)info->height);
    if (info->depth > 1)
        printf(" x %u", (unsigned)info->depth);
    if (info->layers > 1 || info->layer_kind != ZT_LAYERS_ARRAY)
        printf(", %u %s", (unsigned)info->layers,
               info->layer_kind == ZT_LAYERS_CUBE     ? "cube faces"
               : info->layer_kind == ZT_LAYERS_FRAMES ? "frames"
                                                      : "array layers");
}

static void print_image(const ins_job *job, uint32_t image, const zt_image_info *info) {
    char name[32], a[24], b[24];
    uint64_t decoded, stored;
    ins_image_bytes(job->file, image, &decoded, &stored);
    printf("  %u: %s, ", (unsigned)image, ins_format_name(info->format, name, sizeof name));
    print_size(info);
    printf(", %u levels, tiles of %u%s\n", (unsigned)info->levels, (unsigned)info->tile_edge,
           info->block_width > 1 || info->block_height > 1 ? " blocks" : "");
    printf("    alpha %s, primaries %s, ", cmd_alpha_name(info->alpha_mode),
           ins_name(cmd_primaries_name(info->primaries), info->primaries, a, sizeof a));
    printf("transfer %s", ins_name(cmd_transfer_name(info->transfer), info->transfer, a, sizeof a));
    printf(", %s stored of %s", bytes_of(stored, a), bytes_of(decoded, b));
    print_ratio(stored, decoded);
    printf("\n");
}

static void print_tile(const zt_file *file, uint32_t image, uint32_t level, uint64_t tile) {
    char number[16];
    zt_diag diag = {0};
    zt_tile_info info;
    if (zt_get_tile(file, image, level, tile, &info, &diag) != ZT_OK) {
        printf("        the tile index cannot be read: %s\n", diag.text);
        return;
    }
    printf("        tile %" PRIu64 ": offset %" PRIu64 ", %u %s of %u bytes, hash %016" PRIx64 "\n", tile, info.offset,
           (unsigned)info.stored_size, ins_name(ins_codec_name(info.codec), info.codec, number, sizeof number),
           (unsigned)info.decoded_size, info.hash);
}

static void print_level(const ins_job *job, uint32_t image, const zt_image_info *info, uint32_t level) {
    zt_level_info l;
    char buffer[24];
    zt_get_level(job->file, image, level, &l);
    printf("      level %u: %u x %u", (unsigned)level, (unsigned)l.width, (unsigned)l.height);
    if (l.depth > 1)
        printf(" x %u", (unsigned)l.depth);
    if (level > info->tail_level) {
        printf(", in the tail\n");
        return;
    }
    if (level == info->tail_level)
        printf(", begins the tail");
    else
        printf(", %" PRIu64 " tiles", l.tile_count);
    printf(", offset %" PRIu64 ", %s", l.unit_offset, bytes_of(l.unit_size, buffer));
    printf("%s\n", zt_level_state(job->file, image, level) == ZT_OK ? "" : ", NOT ALL HERE");
    /* The whole list ends with the first tile whose index cannot be read. */
    for (uint64_t i = 0; job->tiles && i < l.tile_count; i++) {
        zt_tile_info tile;
        print_tile(job->file, image, level, i);
        if (zt_get_tile(job->file, image, level, i, &tile, NULL) != ZT_OK || cmd_interrupted())
            break;
    }
}

static void print_images(const ins_job *job) {
    zt_image_info info;
    printf("images\n");
    for (uint32_t i = 0; zt_get_image(job->file, i, &info) == ZT_OK && !cmd_interrupted(); i++) {
        print_image(job, i, &info);
        for (uint32_t k = 0; (job->tree || job->tiles) && k < info.levels; k++)
            print_level(job, i, &info, k);
    }
}

/* ---- metadata ----------------------------------------------------------------------------------------- */

/* Lines after the first are indented, so that no value can pass for another key. */
static void print_value(const char *value) {
    const char *line = value, *end;
    while ((end = strchr(line, '\n'))) {
        char part[256];
        size_t length = (size_t)(end - line) < sizeof part - 1 ? (size_t)(end - line) : sizeof part - 1;
        memcpy(part, line, length);
        part[length] = '\0';
        cmd_print_safe(stdout, part);
        printf("%s\n      ", length < (size_t)(end - line) ? "..." : "");
        line = end + 1;
    }
    cmd_print_safe(stdout, line);
}

static void print_metadata(const ins_job *job) {
    uint32_t count;
    zt_diag diag = {0};
    const char *key, *value;
    if (zt_load_metadata(job->file, &count, &diag) != ZT_OK) {
        printf("metadata\n  cannot be read: %s\n", diag.text);
        return;
    }
    if (count > 0)
        printf("metadata\n");
    for (uint32_t i = 0; i < count; i++) {
        zt_get_metadata(job->file, i, &key, &value);
        printf("  ");
        cmd_print_safe(stdout, key);
        printf(": ");
        print_value(value);
        printf("\n");
    }
}

void ins_text(const ins_job *job) {
    /* For git diff both sides must look alike where they are alike: no names of temporary files. */
    if (!job->textconv) {
        cmd_print_safe(stdout, job->name);
        printf("\n");
    }
    if (!job->whole)
        print_error(job);
    if (!job->file) {
        print_salvaged(job);
        return;
    }
    print_file(job);
    print_chunks(job);
    print_textures(job);
    print_images(job);
    print_metadata(job);
}
