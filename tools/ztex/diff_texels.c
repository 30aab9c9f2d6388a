/* SPDX-License-Identifier: Apache-2.0 */
/* Texels: every level of every image that both files have, a band of rows at a time; the cells of silmaps, and the
 * arrays of umbrellas. */
#include "diff.h"

#include <stdlib.h>
#include <string.h>

typedef struct band {
    uint8_t *bytes[2];
    float *values[2]; /* NULL: not a plain format */
    size_t size, row_size, texels;
} band;

static int same_shape(const zt_image_info *a, const zt_image_info *b) {
    return a->format == b->format && a->width == b->width && a->height == b->height && a->depth == b->depth &&
           a->layers == b->layers && a->block_width == b->block_width && a->block_height == b->block_height &&
           a->block_bytes == b->block_bytes;
}

static int band_alloc(band *b, const zt_level_info *level, uint32_t rows, int plain) {
    b->row_size = (size_t)level->row_size;
    b->size = b->row_size * rows;
    b->texels = level->width;
    for (int i = 0; i < 2; i++) {
        b->bytes[i] = malloc(b->size);
        b->values[i] = plain ? malloc(b->texels * 4 * sizeof(float)) : NULL;
        if (!b->bytes[i] || (plain && !b->values[i]))
            return cmd_fail(CMD_INTERNAL, "out of memory");
    }
    return CMD_OK;
}

static void band_free(band *b) {
    for (int i = 0; i < 2; i++) {
        free(b->bytes[i]);
        free(b->values[i]);
    }
}

static void compare_rows(const band *b, const zt_image_info *info, uint32_t rows, dif_error *error) {
    for (uint32_t y = 0; y < rows; y++) {
        const uint8_t *row[2] = {b->bytes[0] + y * b->row_size, b->bytes[1] + y * b->row_size};
        for (int i = 0; i < 2 && b->values[0]; i++)
            (void)zt_unpack_texels(info->format, row[i], b->texels, b->values[i]);
        if (b->values[0])
            dif_error_add(error, b->values[0], b->values[1], b->texels * 4);
        for (size_t i = 0; i < b->row_size; i++)
            error->bytes += row[0][i] != row[1][i];
    }
}

static int read_band(dif_job *job, uint32_t image, const zt_region *region, const band *b) {
    zt_diag diag;
    zt_decode_options options = {.size = sizeof options, .parallel = cmd_parallel(job->args)};
    for (int i = 0; i < 2; i++) {
        zt_result result = zt_decode_region(i ? job->b : job->a, image, region, b->bytes[i], b->size, 0, 0, &options,
                                            &diag);
        if (result != ZT_OK)
            return cmd_fail_result(job->args->operands[i], result, &diag);
    }
    return CMD_OK;
}

/* One layer of a level. */
static int compare_layer(dif_job *job, uint32_t image, const zt_image_info *info, uint32_t level, uint32_t layer,
                         dif_error *error) {
    zt_level_info l;
    band b = {0};
    const zt_format_info *format = zt_find_format(info->format);
    zt_get_level(job->a, image, level, &l);
    uint32_t rows = l.blocks_y < info->tile_edge ? l.blocks_y : info->tile_edge;
    int status = band_alloc(&b, &l, rows, format && format->is_plain);
    uint64_t total = (uint64_t)l.depth * l.blocks_y, at = 0;
    while (status == CMD_OK && at < total) {
        /* Bands do not cross slices: each begins where the one before it ended, or at the next slice. */
        uint32_t z = (uint32_t)(at / l.blocks_y), y = (uint32_t)(at % l.blocks_y);
        uint32_t count = l.blocks_y - y < rows ? l.blocks_y - y : rows;
        uint32_t top = y * info->block_height, left = l.height - top, height = count * info->block_height;
        zt_region region = {level, layer, 0, top, z, l.width, height < left ? height : left, 1};
        status = cmd_interrupted() ? cmd_cancelled() : read_band(job, image, &region, &b);
        if (status == CMD_OK)
            compare_rows(&b, info, count, error);
        at += count;
    }
    band_free(&b);
    return status;
}

static int compare_level(dif_job *job, uint32_t image, const zt_image_info *info, uint32_t level) {
    int status = CMD_OK;
    for (uint32_t layer = 0; layer < info->layers && status == CMD_OK; layer++) {
        char where[96];
        dif_error error = {0};
        status = compare_layer(job, image, info, level, layer, &error);
        if (status != CMD_OK || error.bytes == 0 || (error.values && error.most <= job->tolerance))
            continue;
        snprintf(where, sizeof where, "image %u/level %u", (unsigned)image, (unsigned)level);
        if (info->layers > 1)
            snprintf(where + strlen(where), sizeof where - strlen(where), "/layer %u", (unsigned)layer);
        dif_report_error(job, "texels", where, &error);
    }
    return status;
}

/* A cell is a byte: how many differ. Sizes that differ have been told with the structure. */
static void compare_cells(dif_job *job, uint32_t texture) {
    zt_silmap_info a, b;
    char where[64];
    dif_error error = {0};
    if (zt_get_silmap(job->a, texture, &a) != ZT_OK || zt_get_silmap(job->b, texture, &b) != ZT_OK)
        return;
    if (a.cells_x != b.cells_x || a.cells_y != b.cells_y || a.cell_layers != b.cell_layers) {
        cmd_note(job->args, "texture %u: another number of cells, so they were not compared", (unsigned)texture);
        return;
    }
    size_t count = (size_t)a.cells_x * a.cells_y * a.cell_layers;
    for (size_t i = 0; i < count; i++)
        error.bytes += a.cells[i] != b.cells[i];
    snprintf(where, sizeof where, "texture %u/cells", (unsigned)texture);
    if (error.bytes > 0)
        dif_report_error(job, "texels", where, &error);
}

/* An array of umbrellas: how many bytes differ. */
static void compare_array(dif_job *job, uint32_t texture, const char *name, const void *a, const void *b,
                          uint64_t count_a, uint64_t count_b, size_t size) {
    char where[64];
    dif_error error = {0};
    const uint8_t *bytes_a = a, *bytes_b = b;
    if (count_a != count_b) {
        cmd_note(job->args, "texture %u: another number of %s, so they were not compared", (unsigned)texture, name);
        return;
    }
    for (size_t i = 0; i < (size_t)count_a * size; i++)
        error.bytes += bytes_a[i] != bytes_b[i];
    snprintf(where, sizeof where, "texture %u/%s", (unsigned)texture, name);
    if (error.bytes > 0)
        dif_report_error(job, "texels", where, &error);
}

static void compare_umbrellas(dif_job *job, uint32_t texture) {
    zt_umbrella_info a, b;
    if (zt_get_umbrellas(job->a, texture, &a) != ZT_OK || zt_get_umbrellas(job->b, texture, &b) != ZT_OK)
        return;
    const struct {
        const char *name;
        const void *a, *b;
        uint64_t count_a, count_b;
        size_t size;
    } arrays[] = {
#define ARRAY(name, member, count) {name, a.member, b.member, a.count, b.count, sizeof *a.member}
        ARRAY("bases", bases, base_count),
        ARRAY("base vertices", base_vertices, base_vertex_count),
        ARRAY("morph vertices", morph_vertices, morph_vertex_count),
        ARRAY("variant colours", variant_colours, variant_colour_count),
        ARRAY("umbrellas", umbrellas, umbrella_count),
        ARRAY("explicit vertices", explicit_vertices, explicit_vertex_count),
        ARRAY("explicit colours", explicit_colours, explicit_colour_count),
        ARRAY("list starts", list_starts, cell_count),
        ARRAY("list entries", entries, entry_count),
#undef ARRAY
    };
    for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++)
        compare_array(job, texture, arrays[i].name, arrays[i].a, arrays[i].b, arrays[i].count_a, arrays[i].count_b,
                      arrays[i].size);
}

int dif_texels(dif_job *job) {
    zt_image_info a, b;
    zt_texture_info texture;
    int status = CMD_OK;
    for (uint32_t i = 0; zt_get_texture(job->a, i, &texture) == ZT_OK; i++) {
        compare_cells(job, i);
        compare_umbrellas(job, i);
    }
    for (uint32_t i = 0; zt_get_image(job->a, i, &a) == ZT_OK && zt_get_image(job->b, i, &b) == ZT_OK; i++) {
        if (!same_shape(&a, &b)) {
            cmd_note(job->args, "image %u: another size or format, so its texels were not compared", (unsigned)i);
            continue;
        }
        for (uint32_t k = 0; k < a.levels && k < b.levels && status == CMD_OK; k++)
            status = compare_level(job, i, &a, k);
    }
    return status;
}
