/* SPDX-License-Identifier: Apache-2.0 */
#include "inspect.h"

#include <math.h>
#include <string.h>

const char *ins_format_name(uint32_t format, char *buffer, size_t size) {
    const zt_format_info *info = zt_find_format(format);
    if (info)
        return info->name;
    snprintf(buffer, size, "format %u", (unsigned)format);
    return buffer;
}

const char *ins_name(const char *name, uint32_t number, char *buffer, size_t size) {
    if (name)
        return name;
    snprintf(buffer, size, "%u", (unsigned)number);
    return buffer;
}

const char *ins_codec_name(uint8_t codec) {
    static const char *const names[] = {"raw", "zstd", "pred", NULL, "fields"};
    return codec < sizeof names / sizeof names[0] ? names[codec] : NULL;
}

int ins_begins_unit(const zt_image_info *image, uint32_t level) {
    return level <= image->tail_level;
}

void ins_image_bytes(const zt_file *file, uint32_t image, uint64_t *decoded, uint64_t *stored) {
    zt_image_info info;
    zt_level_info level;
    *decoded = *stored = 0;
    zt_get_image(file, image, &info);
    for (uint32_t k = 0; k < info.levels; k++) {
        zt_get_level(file, image, k, &level);
        *decoded += level.level_size;
        if (ins_begins_unit(&info, k))
            *stored += level.unit_size;
    }
}

/* The n-th texture of a kind owns the n-th chunk of its type. */
uint64_t ins_stored_chunk(const zt_file *file, uint32_t texture, zt_kind kind, const char *type) {
    zt_texture_info info;
    zt_chunk_info chunk;
    uint32_t wanted = 0, seen = 0;
    for (uint32_t i = 0; i < texture && zt_get_texture(file, i, &info) == ZT_OK; i++)
        wanted += info.kind == kind;
    for (uint32_t i = 0; zt_get_chunk(file, i, &chunk) == ZT_OK; i++)
        if (strcmp(chunk.type, type) == 0 && seen++ == wanted)
            return chunk.stored_size;
    return 0;
}

/* ---- silmaps ---------------------------------------------------------------------------------------- */

const char *ins_filter_name(zt_silmap_filter filter) {
    static const char *const names[] = {"continuous", "sen2004", "nearest"};
    return (unsigned)filter < 3 ? names[filter] : "unknown";
}

/* A cell is cut by its own two arms, or by the first of its neighbours to the east and to the south. */
static int is_cut(const zt_silmap_info *info, const uint8_t *cells, uint32_t x, uint32_t y) {
    /* Beyond the last column and row are the first ones: where the texture does not repeat they have nothing cut
     * there. */
    size_t east = (size_t)y * info->cells_x + (x + 1) % info->cells_x;
    size_t south = (size_t)((y + 1) % info->cells_y) * info->cells_x + x;
    return (cells[(size_t)y * info->cells_x + x] & (ZT_SILMAP_WEST | ZT_SILMAP_NORTH)) ||
           (cells[east] & ZT_SILMAP_WEST) || (cells[south] & ZT_SILMAP_NORTH);
}

int ins_silmap(const zt_file *file, uint32_t texture, ins_cells *out) {
    *out = (ins_cells){0};
    if (zt_get_silmap(file, texture, &out->info) != ZT_OK)
        return -1;
    uint64_t layer = (uint64_t)out->info.cells_x * out->info.cells_y;
    out->memory = layer * out->info.cell_layers;
    out->stored = ins_stored_chunk(file, texture, ZT_KIND_SILMAP, "SLMP");
    for (uint32_t l = 0; l < out->info.cell_layers; l++)
        for (uint32_t y = 0; y < out->info.cells_y; y++)
            for (uint32_t x = 0; x < out->info.cells_x; x++)
                out->cut += (uint64_t)is_cut(&out->info, out->info.cells + (size_t)(l * layer), x, y);
    return 0;
}

/* ---- patches -------------------------------------------------------------------------------------- */

/* Inverse up to scale, which homogeneous coordinates do not see. */
static void adjugate(const double m[9], double a[9]) {
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++) {
            int i = (c + 1) % 3, j = (c + 2) % 3, x = (r + 1) % 3, y = (r + 2) % 3;
            a[3 * r + c] = m[3 * i + x] * m[3 * j + y] - m[3 * i + y] * m[3 * j + x];
        }
    }
}

static void apply(const double m[9], double u, double v, double out[2]) {
    double w = m[6] * u + m[7] * v + m[8];
    out[0] = (m[0] * u + m[1] * v + m[2]) / w;
    out[1] = (m[3] * u + m[4] * v + m[5]) / w;
}

/* An offset and a scale, and nothing else. */
static void find_box(const double m[9], ins_placement *out) {
    out->is_box = m[1] == 0 && m[3] == 0 && m[6] == 0 && m[7] == 0 && m[8] > 0 && m[0] > 0 && m[4] > 0;
    if (!out->is_box)
        return;
    out->scale[0] = m[8] / m[0];
    out->scale[1] = m[8] / m[4];
    out->offset[0] = -m[2] / m[0];
    out->offset[1] = -m[5] / m[4];
}

static void find_corners(const double root[9], ins_placement *out) {
    double inverse[9];
    adjugate(root, inverse);
    for (int i = 0; i < 4; i++) {
        double *corner = out->corners[i];
        apply(inverse, i == 1 || i == 2, i >= 2, corner);
        for (int k = 0; k < 2; k++) {
            out->box[k] = i == 0 ? corner[k] : fmin(out->box[k], corner[k]);
            out->box[2 + k] = i == 0 ? corner[k] : fmax(out->box[2 + k], corner[k]);
        }
    }
}

/* Texels of the patch that lie on one texel of the root, from the derivative of the map in the middle of the patch. */
static void find_finer(const zt_file *file, uint32_t texture, const double root[9], ins_placement *out) {
    double middle[2], inverse[9], at[2];
    zt_image_info base;
    adjugate(root, inverse);
    apply(inverse, 0.5, 0.5, middle);
    apply(root, middle[0], middle[1], at);
    double w = root[6] * middle[0] + root[7] * middle[1] + root[8];
    uint32_t image = zt_get_patch_image(file, texture, 0, 0);
    if (out->width == 0 || image == ZT_NONE || zt_get_image(file, image, &base) != ZT_OK)
        return;
    for (int k = 0; k < 2; k++) {
        double dx = (root[k] - at[0] * root[6 + k]) / w * out->width;
        double dy = (root[3 + k] - at[1] * root[6 + k]) / w * out->height;
        out->finer[k] = sqrt(dx * dx + dy * dy) / (k == 0 ? base.width : base.height);
    }
}

void ins_place(const zt_file *file, uint32_t texture, uint32_t patch, ins_placement *out) {
    zt_patch_info info;
    zt_image_info image;
    *out = (ins_placement){0};
    if (zt_get_patch(file, texture, patch, &info) != ZT_OK)
        return;
    uint32_t index = zt_get_patch_image(file, texture, patch, 0);
    if (index != ZT_NONE && zt_get_image(file, index, &image) == ZT_OK) {
        out->width = image.width;
        out->height = image.height;
    }
    find_box(info.matrix, out);
    find_corners(info.root_matrix, out);
    find_finer(file, texture, info.root_matrix, out);
}
