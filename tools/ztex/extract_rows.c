/* SPDX-License-Identifier: Apache-2.0 */
/* One slice of an image, band by band, into a picture or a file of plain bytes. */
#include "extract.h"
#include "pick.h"

#include <stdlib.h>
#include <string.h>

#define BAND_BYTES (UINT64_C(8) << 20)

/* ---- what to extract ------------------------------------------------------------------------------------ */

static int shows(const zt_file *file, uint32_t texture, uint32_t patch_count, uint32_t layer, uint32_t image) {
    for (uint32_t p = 0; p < patch_count; p++)
        if (zt_get_patch_image(file, texture, p, layer) == image)
            return 1;
    return 0;
}

/* What the first texture that uses the image says about it. */
static uint32_t semantic_of(const zt_file *file, uint32_t image) {
    zt_file_info info;
    zt_texture_info texture;
    zt_layer_info layer;
    zt_get_file(file, &info);
    for (uint32_t t = 0; t < info.texture_count && zt_get_texture(file, t, &texture) == ZT_OK; t++)
        for (uint32_t l = 0; l < texture.layer_count && zt_get_layer(file, t, l, &layer) == ZT_OK; l++)
            if (layer.image == image || shows(file, t, texture.patch_count, l, image))
                return layer.semantic;
    return ZT_SEMANTIC_UNSPECIFIED;
}

int extract_part_of(const zt_file *file, const char *name, uint32_t image, uint32_t level, extract_part *part) {
    zt_level_info size;
    *part = (extract_part){.file = file, .name = name, .image = image};
    if (zt_get_image(file, image, &part->info) != ZT_OK)
        return cmd_fail(CMD_USAGE, "%s: there is no image %u", name, (unsigned)image);
    if (zt_get_level(file, image, level, &size) != ZT_OK)
        return cmd_fail(CMD_USAGE, "%s: image %u has %u levels, from 0 on", name, (unsigned)image,
                        (unsigned)part->info.levels);
    part->format = zt_find_format(part->info.format);
    part->is_colour = pick_is_colour(semantic_of(file, image));
    part->region = (zt_region){.level = level, .width = size.width, .height = size.height, .depth = 1};
    return CMD_OK;
}

char *extract_path(const char *folder, const char *name) {
    size_t size = strlen(folder) + strlen(name) + 2;
    char *path = malloc(size);
    if (path)
        snprintf(path, size, "%s/%s", folder, name);
    return path;
}

const char *extract_refusal(const extract_part *part) {
    if (!part->format)
        return "its texel format is not known";
    return part->format->is_plain ? NULL : "its texels are compressed in blocks";
}

/* ---- bands ------------------------------------------------------------------------------------------------ */

typedef struct bands {
    const extract_part *part;
    cmd_args *args;
    cmd_progress *progress;
    unsigned char *data;
    size_t row_size; /* of blocks */
    uint32_t rows;   /* of blocks, in a band */
    uint32_t blocks_y;
} bands;

static uint32_t least(uint64_t a, uint64_t b) {
    return (uint32_t)(a < b ? a : b);
}

static int bands_open(bands *b, cmd_args *args, const extract_part *part, cmd_progress *progress) {
    const zt_image_info *info = &part->info;
    *b = (bands){.part = part, .args = args, .progress = progress};
    b->row_size = (size_t)((part->region.width + info->block_width - 1) / info->block_width) * info->block_bytes;
    b->blocks_y = (part->region.height + info->block_height - 1) / info->block_height;
    /* Bands of a tile's height read every tile once. */
    b->rows = info->tile_edge;
    while (b->rows > 16 && b->rows * (uint64_t)b->row_size > BAND_BYTES)
        b->rows /= 2;
    b->rows = least(b->rows, b->blocks_y);
    b->data = malloc(b->rows * b->row_size);
    return b->data ? CMD_OK : cmd_fail(CMD_INTERNAL, "%s: out of memory", part->name);
}

/* Rows y to y + count (of blocks, of the region) of a slice of the region. */
static int bands_read(bands *b, uint32_t slice, uint32_t y, uint32_t count) {
    zt_region region = b->part->region;
    zt_decode_options how = {.size = sizeof how, .parallel = cmd_parallel(b->args)};
    zt_diag diag = {.offset = UINT64_MAX};
    uint32_t top = y * b->part->info.block_height;
    region.y += top;
    region.height = least(region.height - top, (uint64_t)count * b->part->info.block_height);
    region.z += slice;
    region.depth = 1;
    zt_result result = zt_decode_region(b->part->file, b->part->image, &region, b->data, count * b->row_size, 0, 0,
                                        &how, &diag);
    if (result != ZT_OK)
        return cmd_fail_result(b->part->name, result, &diag);
    double done = ((double)slice + (double)(y + count) / b->blocks_y) / b->part->region.depth;
    return cmd_progress_step(b->progress, done) ? cmd_cancelled() : CMD_OK;
}

int extract_raw(cmd_args *args, const extract_part *part, const char *path, cmd_progress *progress) {
    cmd_output output = {0};
    bands b;
    int status = bands_open(&b, args, part, progress);
    if (status == CMD_OK)
        status = cmd_output_open(&output, path, 1);
    uint64_t total = (uint64_t)part->region.depth * b.blocks_y;
    for (uint64_t done = 0; status == CMD_OK && done < total;) {
        uint32_t slice = (uint32_t)(done / b.blocks_y), y = (uint32_t)(done % b.blocks_y);
        uint32_t count = least(b.blocks_y - y, b.rows);
        status = bands_read(&b, slice, y, count);
        if (status == CMD_OK)
            fwrite(b.data, b.row_size, count, output.stream); /* the commit looks for errors */
        done += count;
    }
    free(b.data);
    return cmd_output_end(&output, status);
}

/* ---- pictures --------------------------------------------------------------------------------------------- */

typedef enum way {
    WAY_DIRECT = 0, /* the picture's bytes are the texture's */
    WAY_WIDEN = 1,  /* the same with a third, zero channel: pictures with two are taken for grey and alpha */
    WAY_FLOATS = 2
} way;

typedef struct plan {
    way way;
    img_type type; /* of the rows that are handed over, and of the picture */
    uint32_t channels;
    img_alpha alpha;
    uint32_t transfer;
} plan;

static img_type type_of(const zt_format_info *format) {
    if (format->channel_bits == 8)
        return IMG_U8;
    if (format->channel_bits == 16)
        return format->is_float ? IMG_HALF : IMG_U16;
    return format->channel_bits == 32 ? IMG_FLOAT : IMG_HALF; /* E5B9G9R9 fits into halves */
}

static int is_tiff(const char *path) {
    const char *dot = strrchr(path, '.');
    return dot && (strcmp(dot, ".tif") == 0 || strcmp(dot, ".tiff") == 0);
}

static plan plan_of(const extract_part *part, const char *path) {
    const zt_format_info *format = part->format;
    int linear = pick_is_linear(path);
    plan p = {.type = type_of(format), .channels = format->channels, .transfer = part->info.transfer};
    p.alpha = (img_alpha)part->info.alpha_mode;
    if (linear) {
        if (part->info.alpha_mode == ZT_ALPHA_STRAIGHT)
            p.alpha = IMG_ALPHA_PREMULTIPLIED;
        if (zt_transfer_known(p.transfer))
            p.transfer = ZT_TRANSFER_LINEAR;
        if (!format->is_float)
            p.type = format->channel_bits == 8 ? IMG_HALF : IMG_FLOAT;
    } else if (!is_tiff(path)) {
        p.alpha = part->info.alpha_mode == ZT_ALPHA_NONE ? IMG_ALPHA_NONE : IMG_ALPHA_STRAIGHT;
        if (format->is_float) {
            p.type = IMG_U16;
            p.transfer = part->is_colour && p.transfer == ZT_TRANSFER_LINEAR ? ZT_TRANSFER_SRGB : p.transfer;
        }
    }
    int same = (int)p.alpha == part->info.alpha_mode && p.transfer == part->info.transfer &&
               p.type == type_of(format) && format->channel_bits != 0;
    if (format->channels == 2 && !linear && !is_tiff(path))
        p.channels = 3;
    p.way = !same ? WAY_FLOATS : p.channels != format->channels ? WAY_WIDEN : WAY_DIRECT;
    if (p.way == WAY_FLOATS && p.channels == 2)
        p.channels = 3;
    return p;
}

static float recode(const extract_part *part, const plan *p, float value, float factor) {
    if (p->transfer == part->info.transfer && !(factor > 1.0f || factor < 1.0f))
        return value;
    float light = zt_transfer_decode(part->info.transfer, value) * factor;
    return zt_transfer_encode(p->transfer, light);
}

/* From the texture's values to the picture's, in place; four floats a texel. */
static void convert(const extract_part *part, const plan *p, float *rgba, size_t count) {
    int multiply = p->alpha == IMG_ALPHA_PREMULTIPLIED && part->info.alpha_mode == ZT_ALPHA_STRAIGHT;
    int divide = p->alpha == IMG_ALPHA_STRAIGHT && part->info.alpha_mode == ZT_ALPHA_PREMULTIPLIED;
    for (float *t = rgba; count > 0; count--, t += 4) {
        float factor = 1.0f;
        if (multiply)
            factor = t[3];
        if (divide)
            factor = t[3] > 0.0f ? 1.0f / t[3] : 0.0f;
        for (int c = 0; c < 3; c++)
            t[c] = recode(part, p, t[c], factor);
    }
}

static int write_floats(const bands *b, const plan *p, img_writer *writer, uint32_t count, float *rgba, char *error) {
    static const uint32_t formats[2][5] = {{0, 9, 0, 23, 37}, {0, 70, 0, 84, 91}};
    const extract_part *part = b->part;
    size_t texels = (size_t)part->region.width * count;
    zt_unpack_texels(part->info.format, b->data, texels, rgba);
    convert(part, p, rgba, texels);
    if (p->type == IMG_U8 || p->type == IMG_U16) {
        zt_pack_texels(formats[p->type == IMG_U16][p->channels], rgba, texels, b->data);
        return img_write_rows(writer, count, p->type, b->data, 0, error);
    }
    for (size_t i = 0; p->channels < 4 && i < texels; i++)
        memmove(rgba + i * p->channels, rgba + 4 * i, p->channels * sizeof *rgba);
    return img_write_rows(writer, count, IMG_FLOAT, rgba, 0, error);
}

static int write_wide(const bands *b, const plan *p, img_writer *writer, uint32_t count, float *room, char *error) {
    size_t texels = (size_t)b->part->region.width * count, size = img_type_size(p->type);
    unsigned char *to = (unsigned char *)room;
    memset(to, 0, texels * 3 * size);
    for (size_t i = 0; i < texels; i++)
        memcpy(to + i * 3 * size, b->data + i * 2 * size, 2 * size);
    return img_write_rows(writer, count, p->type, to, 0, error);
}

static img_writer *create(const extract_part *part, const plan *p, const char *path, char *error) {
    static const char *const two[] = {"R", "G"};
    img_text texts[PICK_TEXTS];
    img_create_options how = {.width = part->region.width,
                              .height = part->region.height,
                              .channels = p->channels,
                              .type = p->type,
                              .channel_names = p->channels == 2 ? two : NULL,
                              .alpha = p->alpha,
                              .transfer = (uint8_t)p->transfer,
                              .primaries = part->info.primaries,
                              .quality = part->quality,
                              .texts = texts};
    how.text_count = pick_texts(part->file, texts);
    /* A fourth channel of data would be lost on readers as one of no meaning. */
    if (p->alpha == IMG_ALPHA_NONE && p->channels == 4 && is_tiff(path))
        how.alpha = IMG_ALPHA_STRAIGHT;
    return img_create(path, &how, error);
}

static int write_bands(bands *b, const plan *p, img_writer *writer, float *room, const char *path) {
    char error[IMG_ERROR];
    uint32_t height = b->part->region.height;
    for (uint32_t y = 0; y < height; y += b->rows) {
        uint32_t count = least(height - y, b->rows);
        int status = bands_read(b, 0, y, count), bad;
        if (status != CMD_OK)
            return status;
        if (p->way == WAY_DIRECT)
            bad = img_write_rows(writer, count, p->type, b->data, 0, error);
        else if (p->way == WAY_WIDEN)
            bad = write_wide(b, p, writer, count, room, error);
        else
            bad = write_floats(b, p, writer, count, room, error);
        if (bad)
            return cmd_fail(CMD_IO, "%s: %s", path, error);
    }
    return CMD_OK;
}

int extract_picture(cmd_args *args, const extract_part *part, const char *path, cmd_progress *progress) {
    char error[IMG_ERROR];
    bands b;
    const char *refusal = extract_refusal(part);
    if (refusal) {
        cmd_error("%s: image %u cannot become a picture: %s", part->name, (unsigned)part->image, refusal);
        cmd_hint("--raw writes its bytes as they are.");
        return CMD_UNSUPPORTED;
    }
    plan p = plan_of(part, path);
    if (p.transfer != part->info.transfer && !zt_transfer_known(part->info.transfer))
        return cmd_fail(CMD_UNSUPPORTED, "%s: the transfer %u of image %u cannot be converted for this type of picture",
                        part->name, (unsigned)part->info.transfer, (unsigned)part->image);
    int status = bands_open(&b, args, part, progress);
    if (status != CMD_OK)
        return status;
    size_t texels = (size_t)part->region.width * b.rows;
    float *room = p.way == WAY_DIRECT ? NULL : malloc(texels * 4 * sizeof(float));
    /* The band also takes the packed pixels of the picture, which may be larger than the texels. */
    unsigned char *wider = p.way == WAY_FLOATS ? realloc(b.data, texels * 16) : b.data;
    b.data = wider ? wider : b.data;
    img_writer *writer = NULL;
    if (!wider || (p.way != WAY_DIRECT && !room))
        status = cmd_fail(CMD_INTERNAL, "%s: out of memory", part->name);
    if (status == CMD_OK && !(writer = create(part, &p, path, error)))
        status = cmd_fail(CMD_IO, "%s: %s", path, error);
    if (status == CMD_OK)
        status = write_bands(&b, &p, writer, room, path);
    if (status != CMD_OK)
        img_discard(writer);
    else if (img_finish(writer, error))
        status = cmd_fail(CMD_IO, "%s: %s", path, error);
    free(room);
    free(b.data);
    return status;
}
