/* SPDX-License-Identifier: Apache-2.0 */
/* A picture into memory, as the authoring library wants it. */
#include "make.h"

#include <stdlib.h>
#include <string.h>

enum { BAND = 64 };

typedef struct loading {
    img_reader *reader;
    const img_info *info;
    make_shape shape;
    uint32_t transfer;
    img_type type; /* U8, U16 or FLOAT: how rows are read */
    float *table;  /* of linear light for all values of the first two */
    unsigned char *rows;
} loading;

static float value_at(const loading *l, size_t i) {
    if (l->type == IMG_U8)
        return (float)l->rows[i] / 255.0f;
    if (l->type == IMG_U16)
        return (float)((const uint16_t *)(const void *)l->rows)[i] / 65535.0f;
    return ((const float *)(const void *)l->rows)[i];
}

static float light_at(const loading *l, size_t i) {
    if (l->type == IMG_U8)
        return l->table[l->rows[i]];
    if (l->type == IMG_U16)
        return l->table[((const uint16_t *)(const void *)l->rows)[i]];
    return zt_transfer_decode(l->transfer, value_at(l, i));
}

static int make_table(loading *l) {
    uint32_t count = l->type == IMG_U8 ? 256 : l->type == IMG_U16 ? 65536 : 0;
    l->table = calloc(count + 1, sizeof *l->table);
    for (uint32_t i = 0; l->table && i < count; i++)
        l->table[i] = zt_transfer_decode(l->transfer, (float)i / (float)(count - 1));
    return l->table != NULL;
}

static void convert_row(const loading *l, size_t row, float *out) {
    const make_shape *s = &l->shape;
    for (size_t x = 0; x < l->info->width; x++) {
        size_t from = (row * l->info->width + x) * l->info->channels;
        float alpha = s->alpha >= 0 ? value_at(l, from + (size_t)s->alpha) : 1.0f;
        float undo = l->info->alpha == IMG_ALPHA_PREMULTIPLIED ? (alpha > 0.0f ? 1.0f / alpha : 0.0f) : 1.0f;
        for (int c = 0; c < s->count; c++)
            *out++ = light_at(l, from + (size_t)s->channels[c]) * undo;
        if (s->alpha >= 0)
            *out++ = alpha;
    }
}

static int read_rows(const loading *l, author_picture *out, char *error) {
    size_t pitch = (size_t)out->width * out->channels;
    for (uint32_t y = 0; y < out->height; y += BAND) {
        uint32_t count = out->height - y < BAND ? out->height - y : BAND;
        if (img_read_rows(l->reader, 0, y, count, 0, l->type, l->rows, 0, error))
            return -1;
        for (uint32_t i = 0; i < count; i++)
            convert_row(l, i, out->texels + (y + i) * pitch);
    }
    return 0;
}

static int load(make_store *store, const make_image *image, loading *l, author_picture *out) {
    const img_info *info = l->info;
    author_run run = {0};
    char error[IMG_ERROR], limit[32];
    uint32_t channels = (uint32_t)(l->shape.count + (l->shape.alpha >= 0));
    const char *path = image->files[0].path;
    uint64_t memory = cmd_limits(store->args)->memory ? cmd_limits(store->args)->memory : UINT64_C(1) << 30;
    if (channels > 4)
        return make_complain(store->scene, image->pointer, "%s: %u channels are too many to be worked on", path,
                             (unsigned)info->channels);
    if ((uint64_t)info->width * info->height > memory / (channels * sizeof(float)))
        return cmd_fail(CMD_LIMIT, "%s: %u x %u needs more memory than %s: see --memory", path, (unsigned)info->width,
                        (unsigned)info->height, cmd_bytes_text(limit, sizeof limit, memory));
    l->rows = malloc((size_t)info->width * BAND * info->channels * sizeof(float));
    if (!l->rows || !make_table(l) ||
        author_picture_create(&run, info->width, info->height, channels, out) != AUTHOR_OK)
        return cmd_fail(CMD_INTERNAL, "%s: out of memory", path);
    return read_rows(l, out, error) ? make_fail_picture(store, image, path, error) : CMD_OK;
}

int make_load_picture(make_store *store, const make_image *image, uint32_t semantic, author_picture *out,
                      img_info *info) {
    char error[IMG_ERROR];
    loading l = {0};
    const char *path = image->files[0].path;
    *out = (author_picture){0};
    cmd_verbose(store->args, "reading %s", path);
    l.reader = make_open_picture(store, image, 0, semantic, 1, error);
    if (!l.reader)
        return make_fail_picture(store, image, path, error);
    l.info = img_get_info(l.reader);
    *info = *l.info;
    l.transfer = make_transfer_of(image, l.info, semantic);
    l.type = l.info->type == IMG_U8 || l.info->type == IMG_U16 ? l.info->type : IMG_FLOAT;
    int status = CMD_OK;
    if (make_find_shape(l.info, semantic, &l.shape) || l.info->depth > 1)
        status = make_complain(store->scene, image->pointer, "%s is not a plain picture that can be worked on", path);
    else if (!zt_transfer_known(l.transfer))
        status = make_complain(store->scene, image->pointer,
                               "the colours of %s are coded in a way that is not known: say how with the option "
                               "transfer",
                               path);
    else
        status = load(store, image, &l, out);
    if (status != CMD_OK)
        author_picture_release(out);
    free(l.table);
    free(l.rows);
    img_close(l.reader);
    return status;
}
