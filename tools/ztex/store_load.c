/* SPDX-License-Identifier: Apache-2.0 */
/* A picture into memory, as the authoring library wants it. */
#include "light_rows.h"
#include "make.h"

typedef struct loading {
    light_rows rows;
    make_shape shape;
    author_picture *out;
} loading;

static void convert_row(void *user, uint32_t y, size_t from) {
    const loading *l = user;
    const img_info *info = l->rows.info;
    const make_shape *s = &l->shape;
    float *out = l->out->texels + (size_t)y * l->out->width * l->out->channels;
    for (size_t x = 0; x < info->width; x++, from += info->channels) {
        float alpha = s->alpha >= 0 ? light_rows_value(&l->rows, from + (size_t)s->alpha) : 1.0f;
        float undo = info->alpha == IMG_ALPHA_PREMULTIPLIED ? (alpha > 0.0f ? 1.0f / alpha : 0.0f) : 1.0f;
        for (int c = 0; c < s->count; c++)
            *out++ = light_rows_light(&l->rows, from + (size_t)s->channels[c]) * undo;
        if (s->alpha >= 0)
            *out++ = alpha;
    }
}

static int load(make_store *store, const make_image *image, img_reader *reader, uint32_t transfer, loading *l) {
    const img_info *info = img_get_info(reader);
    author_run run = {0};
    char error[IMG_ERROR], limit[32];
    img_type type = info->type == IMG_U8 || info->type == IMG_U16 ? info->type : IMG_FLOAT;
    uint32_t channels = (uint32_t)(l->shape.count + (l->shape.alpha >= 0));
    const char *path = image->files[0].path;
    uint64_t memory = cmd_limits(store->args)->memory ? cmd_limits(store->args)->memory : UINT64_C(1) << 30;
    if (channels > 4)
        return make_complain(store->scene, image->pointer, "%s: %u channels are too many to be worked on", path,
                             (unsigned)info->channels);
    if ((uint64_t)info->width * info->height > memory / (channels * sizeof(float)))
        return cmd_fail(CMD_LIMIT, "%s: %u x %u needs more memory than %s: see --memory", path, (unsigned)info->width,
                        (unsigned)info->height, cmd_bytes_text(limit, sizeof limit, memory));
    if (light_rows_open(&l->rows, reader, info->channels, transfer, type) ||
        author_picture_create(&run, info->width, info->height, channels, l->out) != AUTHOR_OK)
        return cmd_fail(CMD_INTERNAL, "%s: out of memory", path);
    return light_rows_each(&l->rows, convert_row, l, error) ? make_fail_picture(store, image, path, error) : CMD_OK;
}

int make_load_picture(make_store *store, const make_image *image, uint32_t semantic, author_picture *out,
                      img_info *info) {
    char error[IMG_ERROR];
    loading l = {.out = out};
    const char *path = image->files[0].path;
    *out = (author_picture){0};
    cmd_verbose(store->args, "reading %s", path);
    img_reader *reader = make_open_picture(store, image, 0, semantic, 1, error);
    if (!reader)
        return make_fail_picture(store, image, path, error);
    *info = *img_get_info(reader);
    uint32_t transfer = make_transfer_of(image, info, semantic);
    int status = CMD_OK;
    if (make_find_shape(info, semantic, &l.shape) || info->depth > 1)
        status = make_complain(store->scene, image->pointer, "%s is not a plain picture that can be worked on", path);
    else if (!zt_transfer_known(transfer))
        status = make_complain(store->scene, image->pointer,
                               "the colours of %s are coded in a way that is not known: say how with the option "
                               "transfer",
                               path);
    else
        status = load(store, image, reader, transfer, &l);
    if (status != CMD_OK)
        author_picture_release(out);
    light_rows_close(&l.rows);
    img_close(reader);
    return status;
}
