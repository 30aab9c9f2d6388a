/* SPDX-License-Identifier: Apache-2.0 */
/* One image of the texture file out of one or several pictures: which format, which channels, then row by row. */
#include "make.h"

#include <stdlib.h>
#include <string.h>

#define BAND_BYTES (UINT32_C(4) << 20) /* of float texels that are held at once */

/* What is in a picture, seen as a texture. */
typedef struct shape {
    int channels[4]; /* of colour or data, in order */
    int count;
    int alpha; /* channel of coverage; -1: none, or the values are data */
} shape;

/* What it becomes. */
typedef struct choice {
    const zt_format_info *format;
    zt_alpha alpha;
    uint32_t transfer_in, transfer_out, primaries;
} choice;

static int is_colour(uint32_t semantic) {
    return semantic == ZT_SEMANTIC_UNSPECIFIED || semantic == ZT_SEMANTIC_BASE_COLOUR ||
           semantic == ZT_SEMANTIC_EMISSIVE;
}

static int fail_picture(const make_store *store, const make_image *image, const char *path, const char *error) {
    if (store->scene->name)
        return cmd_fail(CMD_IO, "%s: %s: %s: %s", store->scene->name, image->pointer, path, error);
    return cmd_fail(CMD_IO, "%s: %s", path, error);
}

static int fail_writer(const make_store *store, const make_image *image, zt_result result, const zt_diag *diag) {
    char name[512];
    snprintf(name, sizeof name, "%s%s%s", store->scene->name ? store->scene->name : "", store->scene->name ? ": " : "",
             store->scene->name ? image->pointer : image->files[0].path);
    return cmd_fail_result(name, result, diag);
}

static img_reader *open_picture(const make_store *store, const make_image *image, size_t file, const make_use *use,
                                int resized, char *error) {
    img_open_options options = {.subimage = image->files[file].subimage,
                                .keep_orientation = image->options.keep_orientation == 1,
                                .crop = image->crop,
                                .resize_data = !is_colour(use->semantic),
                                .memory = cmd_limits(store->args)->memory};
    if (resized) {
        options.resize_width = image->resize_width;
        options.resize_height = image->resize_height;
    }
    return img_open(image->files[file].path, &options, error);
}

/* ---- channels and format --------------------------------------------------------------------------------- */

static int find_channel(const img_info *info, const char *name) {
    for (uint32_t c = 0; c < info->channels; c++)
        if (strcmp(info->channel_names[c], name) == 0)
            return (int)c;
    return -1;
}

/* 0, or -1: more channels than a texel has, and no R, G, B among them. */
static int find_shape(const img_info *info, uint32_t semantic, shape *s) {
    static const char *const names[] = {"R", "G", "B"};
    *s = (shape){.alpha = info->alpha_channel};
    for (int c = 0; c < 3 && find_channel(info, names[c]) >= 0; c++)
        s->channels[s->count++] = find_channel(info, names[c]);
    if (s->count < 3) {
        s->count = 0;
        for (int c = 0; c < (int)info->channels; c++) {
            if (c == s->alpha)
                continue;
            if (s->count == (s->alpha >= 0 ? 3 : 4))
                return -1;
            s->channels[s->count++] = c;
        }
    }
    /* A picture of nothing but alpha, and alpha that means something else, are values like others. */
    if (s->alpha >= 0 && (s->count == 0 || !is_colour(semantic))) {
        s->channels[s->count++] = s->alpha;
        s->alpha = -1;
    }
    return 0;
}

static uint32_t usual_format(img_type type, int channels, int srgb) {
    static const uint32_t formats[5][4] = {{15, 22, 29, 43}, /* sRGB */
                                           {9, 16, 23, 37},
                                           {70, 77, 84, 91},
                                           {76, 83, 90, 97},
                                           {100, 103, 106, 109}};
    int row = type == IMG_U8 ? !srgb : (int)type;
    return formats[row][channels - 1];
}

/* A patch's coverage goes into the alpha where there is room for it. */
static int has_room(const make_image *image, const shape *s, uint32_t semantic) {
    const make_options *o = &image->options;
    if (!is_colour(semantic) || o->alpha == ZT_ALPHA_NONE)
        return 0;
    if (o->format)
        return zt_find_format(o->format)->has_alpha;
    return s->count == 3 || s->alpha >= 0;
}

static int channels_wanted(const make_image *image, const shape *s, make_role role) {
    int keeps_alpha = s->alpha >= 0 && role != ROLE_BARE && image->options.alpha != ZT_ALPHA_NONE;
    int more = image->options.alpha == ZT_ALPHA_STRAIGHT || image->options.alpha == ZT_ALPHA_PREMULTIPLIED;
    if (role == ROLE_COVERED || keeps_alpha || more)
        return 4;
    return s->count;
}

static zt_alpha alpha_wanted(const make_image *image, const img_info *info, const shape *s, const make_use *use,
                             const zt_format_info *format) {
    int wish = image->options.alpha;
    if (use->role == ROLE_BARE || use->role == ROLE_MASK || !format->has_alpha || !is_colour(use->semantic))
        return ZT_ALPHA_NONE;
    if (wish != MAKE_UNSET)
        return (zt_alpha)wish;
    if (s->alpha >= 0)
        return info->alpha == IMG_ALPHA_PREMULTIPLIED ? ZT_ALPHA_PREMULTIPLIED : ZT_ALPHA_STRAIGHT;
    return use->role == ROLE_COVERED ? ZT_ALPHA_STRAIGHT : ZT_ALPHA_NONE;
}

static uint32_t transfer_of(const make_image *image, const img_info *info, uint32_t semantic) {
    if (image->options.transfer != MAKE_UNSET)
        return (uint32_t)image->options.transfer;
    if (!is_colour(semantic))
        return 8;
    if (info->transfer)
        return info->transfer;
    return info->type == IMG_U8 || info->type == IMG_U16 ? 13 : 8;
}

static const char *choose_transfer(const make_image *image, const img_info *info, const make_use *use, choice *c) {
    const make_options *o = &image->options;
    c->transfer_in = c->transfer_out = transfer_of(image, info, use->semantic);
    if (c->format->is_srgb && !is_colour(use->semantic))
        return "an SRGB format is for colours, not for this semantic: take the UNORM format";
    if (c->format->is_srgb)
        c->transfer_out = 13;
    else if (o->format && c->format->is_float && o->transfer == MAKE_UNSET)
        c->transfer_out = 8;
    if (c->transfer_in != c->transfer_out && !(zt_transfer_known(c->transfer_in) && zt_transfer_known(c->transfer_out)))
        return "the colours are coded in a way that cannot be converted to this format: say how "
               "with the option transfer, or take another format";
    return NULL;
}

/* NULL, or what is wrong with the wishes. */
static const char *choose(const make_image *image, const img_info *info, const shape *s, const make_use *use,
                          choice *c) {
    const make_options *o = &image->options;
    int coded = transfer_of(image, info, use->semantic) == 13 && is_colour(use->semantic);
    uint32_t number = o->format;
    if (use->role == ROLE_MASK)
        number = 9; /* R8_UNORM */
    else if (number == 0)
        number = usual_format(info->type, channels_wanted(image, s, use->role), coded);
    c->format = zt_find_format(number);
    if (!c->format || !c->format->is_plain)
        return "this format is stored only: ztex does not compress pictures into blocks. Take an "
               "uncompressed one";
    c->alpha = alpha_wanted(image, info, s, use, c->format);
    c->primaries = o->primaries != MAKE_UNSET ? (uint32_t)o->primaries : info->primaries;
    if (use->role == ROLE_MASK || !is_colour(use->semantic))
        c->primaries = 0;
    if (use->role == ROLE_MASK) {
        c->transfer_in = c->transfer_out = 8;
        return NULL;
    }
    if ((o->alpha == ZT_ALPHA_STRAIGHT || o->alpha == ZT_ALPHA_PREMULTIPLIED) && !c->format->has_alpha &&
        use->role == ROLE_PLAIN)
        return "this format has no alpha channel";
    return choose_transfer(image, info, use, c);
}

/* Which channel of the picture goes where. Grey becomes red, green and blue where these are wanted. */
static void map_channels(const shape *s, const choice *c, make_rows *rows) {
    rows->channels = c->format->channels;
    for (int i = 0; i < 4; i++) {
        rows->map[i] = i < s->count ? s->channels[i] : i == 3 ? -2 : -1;
        if (s->count == 1 && i < 3 && rows->channels >= 3)
            rows->map[i] = s->channels[0];
    }
    if (s->alpha >= 0)
        rows->map[3] = s->alpha;
    if (c->alpha != ZT_ALPHA_NONE && s->alpha < 0)
        rows->map[3] = -2;
}

static void set_up_rows(make_rows *rows, const img_info *info, const shape *s, const choice *c, const make_use *use) {
    rows->info = info;
    rows->format = c->format;
    rows->source_alpha = s->alpha;
    rows->alpha_in = s->alpha >= 0 ? info->alpha : IMG_ALPHA_NONE;
    rows->alpha_out = c->alpha;
    rows->transfer_in = c->transfer_in;
    rows->transfer_out = c->transfer_out;
    rows->role = use->role;
    rows->ramp = use->ramp;
    map_channels(s, c, rows);
    int same_alpha = (int)rows->alpha_in == (int)rows->alpha_out ||
                     (rows->alpha_in != IMG_ALPHA_PREMULTIPLIED && c->alpha == ZT_ALPHA_NONE);
    rows->direct = (use->role == ROLE_PLAIN || use->role == ROLE_BARE) && same_alpha &&
                   rows->transfer_in == rows->transfer_out && c->format->channel_bits != 0;
    for (uint32_t i = 0; i < rows->channels; i++)
        rows->direct &= rows->map[i] >= 0;
}

static void warn_of_loss(const make_store *store, const make_image *image, const shape *s, const choice *c,
                         const make_use *use) {
    const char *path = image->files[0].path;
    int channels = c->format->channels;
    if (use->role == ROLE_MASK)
        return;
    if (s->count > channels)
        cmd_warn(store->args, "%s: %s keeps the first %d of %d channels", path, c->format->name, channels, s->count);
    else if (s->alpha >= 0 && use->role == ROLE_PLAIN && !c->format->has_alpha && image->options.alpha == MAKE_UNSET)
        cmd_warn(store->args, "%s: %s has no room for the alpha", path, c->format->name);
}

/* ---- storing --------------------------------------------------------------------------------------------- */

static int start_image(make_store *store, const make_image *image, const img_info *info, const choice *c,
                       const make_use *use, make_stored *out) {
    const make_options *o = &image->options;
    int covers = use->role == ROLE_COVERED || use->role == ROLE_MASK;
    zt_diag diag = {.offset = UINT64_MAX};
    uint32_t count = (uint32_t)image->file_count;
    if (image->all_subimages && count == 1)
        count = info->subimages;
    out->width = info->width;
    out->height = info->height;
    out->full_width = info->full_width;
    out->full_height = info->full_height;
    out->layers = image->volume ? 1 : count;
    out->depth = image->volume && info->depth == 1 ? count : info->depth;
    zt_image_desc desc = {.format = c->format->format,
                          .width = out->width,
                          .height = out->height,
                          .depth = out->depth,
                          .layers = out->layers,
                          .levels = o->levels > 0 ? (uint32_t)o->levels : 0,
                          .tile_edge = o->tile_edge > 0 ? (uint32_t)o->tile_edge : 0,
                          .alpha_mode = c->alpha,
                          .layer_kind = (zt_layer_kind)image->layer_kind,
                          .primaries = (uint8_t)c->primaries,
                          .transfer = (uint8_t)c->transfer_out,
                          .mip_filter = o->mip_filter > 0 ? (uint8_t)o->mip_filter : 0,
                          .wrap_u = use->wrap[0],
                          .wrap_v = use->wrap[1],
                          .wrap_w = use->wrap[2],
                          .is_normal = use->semantic == ZT_SEMANTIC_NORMAL && use->role != ROLE_MASK,
                          .zero_border = (uint8_t)covers};
    zt_result result = zt_writer_add_image(store->writer, &desc, &diag, &out->image);
    return result == ZT_OK ? CMD_OK : fail_writer(store, image, result, &diag);
}

static int pump(make_store *store, const make_image *image, make_rows *rows, const char *path, const make_stored *out) {
    char error[IMG_ERROR];
    const img_info *info = rows->info;
    size_t row = (size_t)info->width * 4 * sizeof(float);
    uint32_t band = (uint32_t)(BAND_BYTES / row);
    band = band < 1 ? 1 : band > 256 ? 256 : band;
    size_t texels = (size_t)info->width * band;
    unsigned char *texture_rows = malloc(texels * rows->format->block_bytes);
    rows->rgba = malloc(texels * 4 * sizeof(float));
    rows->source = malloc(texels * info->channels * sizeof(float));
    rows->coverage = malloc(texels * sizeof(float));
    int status = CMD_OK;
    if (!texture_rows || !rows->rgba || !rows->source || !rows->coverage)
        status = cmd_fail(CMD_INTERNAL, "%s: out of memory", path);
    uint64_t total = (uint64_t)info->depth * info->height, done = 0;
    while (status == CMD_OK && done < total) {
        uint32_t y = (uint32_t)(done % info->height);
        uint32_t count = info->height - y < band ? info->height - y : band;
        zt_diag diag = {.offset = UINT64_MAX};
        if (make_rows_read(rows, (uint32_t)(done / info->height), y, count, texture_rows, error))
            status = fail_picture(store, image, path, error);
        zt_result result = ZT_OK;
        if (status == CMD_OK)
            result = zt_writer_put_rows(store->writer, out->image, texture_rows, count, 0, &diag);
        if (result != ZT_OK)
            status = fail_writer(store, image, result, &diag);
        done += count;
        if (status == CMD_OK && cmd_progress_step(store->progress, (double)done / (double)total))
            status = cmd_cancelled();
    }
    free(texture_rows);
    free(rows->rgba);
    free(rows->source);
    free(rows->coverage);
    return status;
}

/* The mask, at the size of the picture that it belongs to. */
static img_reader *open_mask(const make_store *store, const make_image *mask, const img_info *info, char *error) {
    make_image sized = *mask;
    make_use use = {.semantic = ZT_SEMANTIC_OPACITY};
    img_reader *reader = open_picture(store, mask, 0, &use, 1, error);
    if (!reader)
        return NULL;
    const img_info *own = img_get_info(reader);
    if (own->width == info->width && own->height == info->height)
        return reader;
    img_close(reader);
    sized.resize_width = info->width;
    sized.resize_height = info->height;
    return open_picture(store, &sized, 0, &use, 1, error);
}

static int check_picture(const make_store *store, const make_image *image, const char *path, const img_info *info,
                         const make_stored *first, int is_first) {
    if (image->volume && info->depth > 1 && image->file_count > 1)
        return make_complain(store->scene, image->pointer, "%s is a volume already: give it alone", path);
    if (is_first || (info->width == first->width && info->height == first->height))
        return CMD_OK;
    return make_complain(
        store->scene, image->pointer, "%s is %u x %u, but the first picture %u x %u: layers have one size", path,
        (unsigned)info->width, (unsigned)info->height, (unsigned)first->width, (unsigned)first->height);
}

typedef struct picture_job {
    make_store *store;
    const make_image *image;
    const make_use *use;
    choice chosen; /* by the first picture, for all */
    make_stored *out;
} picture_job;

static int store_open_picture(picture_job *job, img_reader *reader, const char *path, int is_first) {
    const img_info *info = img_get_info(reader);
    char error[IMG_ERROR];
    make_rows rows = {.reader = reader};
    shape s;
    choice c;
    int status = check_picture(job->store, job->image, path, info, job->out, is_first);
    if (status != CMD_OK)
        return status;
    if (find_shape(info, job->use->semantic, &s)) {
        snprintf(error, sizeof error, "%u channels, and no R, G, B among them", (unsigned)info->channels);
        return fail_picture(job->store, job->image, path, error);
    }
    make_image same = *job->image;
    if (!is_first)
        same.options.format = job->chosen.format->format;
    const char *wrong = choose(&same, info, &s, job->use, &c);
    if (wrong)
        return make_complain(job->store->scene, job->image->pointer, "%s: %s", path, wrong);
    if (is_first) {
        job->chosen = c;
        warn_of_loss(job->store, job->image, &s, &c, job->use);
        status = start_image(job->store, job->image, info, &c, job->use, job->out);
    }
    c.alpha = job->chosen.alpha;
    c.transfer_out = job->chosen.transfer_out;
    set_up_rows(&rows, info, &s, &c, job->use);
    if (status == CMD_OK && job->use->mask && rows.role != ROLE_BARE && rows.role != ROLE_PLAIN) {
        rows.mask = open_mask(job->store, job->use->mask, info, error);
        if (!rows.mask)
            status = fail_picture(job->store, job->use->mask, job->use->mask->files[0].path, error);
    }
    if (status == CMD_OK)
        status = pump(job->store, job->image, &rows, path, job->out);
    img_close(rows.mask);
    return status;
}

static int store_pictures(picture_job *job) {
    char error[IMG_ERROR];
    size_t count = job->image->file_count;
    int status = CMD_OK;
    for (size_t i = 0; status == CMD_OK && i < count; i++) {
        const char *path = job->image->files[i].path;
        img_reader *reader = open_picture(job->store, job->image, i, job->use, 1, error);
        if (!reader)
            return fail_picture(job->store, job->image, path, error);
        status = store_open_picture(job, reader, path, i == 0);
        img_close(reader);
    }
    return status;
}

/* One picture whose subimages are the layers. */
static int store_subimages(picture_job *job) {
    char error[IMG_ERROR];
    uint32_t count = 1;
    int status = CMD_OK;
    for (uint32_t i = 0; status == CMD_OK && i < count; i++) {
        make_file file = {job->image->files[0].path, i};
        make_image part = *job->image;
        part.files = &file;
        img_reader *reader = open_picture(job->store, &part, 0, job->use, 1, error);
        if (!reader)
            return fail_picture(job->store, job->image, file.path, error);
        count = img_get_info(reader)->subimages > count ? img_get_info(reader)->subimages : count;
        status = store_open_picture(job, reader, file.path, i == 0);
        img_close(reader);
    }
    return status;
}

/* ---- once only ------------------------------------------------------------------------------------------------ */

static void describe_image(FILE *stream, const make_image *image) {
    const make_options *o = &image->options;
    for (size_t i = 0; i < image->file_count; i++)
        fprintf(stream, "%s\n%u\n", image->files[i].path, (unsigned)image->files[i].subimage);
    fprintf(stream, "%d %d %d|%u %u %u %u|%u %u|", image->layer_kind, image->volume, image->all_subimages,
            (unsigned)image->crop.x, (unsigned)image->crop.y, (unsigned)image->crop.width, (unsigned)image->crop.height,
            (unsigned)image->resize_width, (unsigned)image->resize_height);
    fprintf(stream, "%u %d %d %d %d %d %d %d|", (unsigned)o->format, o->alpha, o->transfer, o->primaries, o->mip_filter,
            o->tile_edge, o->levels, o->keep_orientation);
}

static char *describe(const make_image *image, const make_use *use) {
    char *text = NULL;
    size_t size = 0;
    FILE *stream = open_memstream(&text, &size);
    if (!stream)
        return NULL;
    describe_image(stream, image);
    fprintf(stream, "%d %d|%d %d %d|%d", is_colour(use->semantic), use->semantic == ZT_SEMANTIC_NORMAL, use->wrap[0],
            use->wrap[1], use->wrap[2], (int)use->role);
    if (use->role == ROLE_COVERED || use->role == ROLE_MASK) {
        fprintf(stream, "|%u|", (unsigned)use->ramp);
        if (use->mask)
            describe_image(stream, use->mask);
    }
    if (fclose(stream) != 0) {
        free(text);
        return NULL;
    }
    return text;
}

static int keep(make_store *store, char *key, make_stored *out) {
    if (store->stored_count == store->stored_capacity) {
        size_t capacity = store->stored_capacity ? 2 * store->stored_capacity : 64;
        make_stored *grown = realloc(store->stored, capacity * sizeof *grown);
        if (!grown) {
            free(key);
            return cmd_fail(CMD_INTERNAL, "out of memory");
        }
        store->stored = grown;
        store->stored_capacity = capacity;
    }
    out->key = key;
    store->stored[store->stored_count++] = *out;
    return CMD_OK;
}

int make_store_image(make_store *store, const make_image *image, const make_use *use, make_stored *out) {
    char *key = describe(image, use);
    if (!key)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    for (size_t i = 0; i < store->stored_count; i++)
        if (strcmp(store->stored[i].key, key) == 0) {
            *out = store->stored[i];
            free(key);
            return CMD_OK;
        }
    cmd_verbose(store->args, "reading %s", image->files[0].path);
    *out = (make_stored){0};
    picture_job job = {.store = store, .image = image, .use = use, .out = out};
    double share = store->total ? 0.9 / (double)store->total : 0.9;
    double from = share * (double)store->done;
    cmd_progress_part(store->progress, from, from + share);
    store->done += store->done + 1 < store->total;
    int status = image->all_subimages && image->file_count == 1 ? store_subimages(&job) : store_pictures(&job);
    if (status != CMD_OK) {
        free(key);
        return status;
    }
    return keep(store, key, out);
}

int make_wants_mask(make_store *store, const make_image *image, const make_use *use, int *mask) {
    char error[IMG_ERROR];
    shape s;
    *mask = 0;
    img_reader *reader = open_picture(store, image, 0, use, 0, error);
    if (!reader)
        return fail_picture(store, image, image->files[0].path, error);
    if (find_shape(img_get_info(reader), use->semantic, &s) == 0)
        *mask = !has_room(image, &s, use->semantic);
    img_close(reader);
    return CMD_OK;
}

void make_store_release(make_store *store) {
    for (size_t i = 0; i < store->stored_count; i++)
        free(store->stored[i].key);
    free(store->stored);
    store->stored = NULL;
    store->stored_count = store->stored_capacity = 0;
}
