/* SPDX-License-Identifier: Apache-2.0 */
/* One image of the texture file out of one or several pictures: which format, which channels, then row by row. */
#include "make.h"

#include <stdlib.h>
#include <string.h>

#define BAND_BYTES (UINT32_C(4) << 20) /* of float texels that are held at once */

/* What it becomes. */
typedef struct choice {
    const zt_format_info *format;
    zt_alpha alpha;
    uint32_t transfer_in, transfer_out, primaries;
} choice;

int make_is_colour(uint32_t semantic) {
    return semantic == ZT_SEMANTIC_UNSPECIFIED || semantic == ZT_SEMANTIC_BASE_COLOUR ||
           semantic == ZT_SEMANTIC_EMISSIVE;
}

int make_fail_picture(const make_store *store, const make_image *image, const char *path, const char *error) {
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

img_reader *make_open_picture(const make_store *store, const make_image *image, size_t file, uint32_t semantic,
                              int resized, char *error) {
    img_open_options options = {.subimage = image->files[file].subimage,
                                .keep_orientation = image->options.keep_orientation == 1,
                                .crop = image->crop,
                                .resize_data = !make_is_colour(semantic),
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

int make_find_shape(const img_info *info, uint32_t semantic, make_shape *s) {
    static const char *const names[] = {"R", "G", "B"};
    *s = (make_shape){.alpha = info->alpha_channel};
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
    if (s->alpha >= 0 && (s->count == 0 || !make_is_colour(semantic))) {
        s->channels[s->count++] = s->alpha;
        s->alpha = -1;
    }
    return 0;
}

uint32_t make_usual_format(img_type type, int channels, int srgb) {
    static const uint32_t formats[5][4] = {{15, 22, 29, 43}, /* sRGB */
                                           {9, 16, 23, 37},
                                           {70, 77, 84, 91},
                                           {76, 83, 90, 97},
                                           {100, 103, 106, 109}};
    int row = type == IMG_U8 ? !srgb : (int)type;
    return formats[row][channels - 1];
}

/* A patch's coverage goes into the alpha where there is room for it. */
static int has_room(const make_image *image, const make_shape *s, uint32_t semantic) {
    const make_options *o = &image->options;
    if (!make_is_colour(semantic) || o->alpha == ZT_ALPHA_NONE)
        return 0;
    if (o->format)
        return zt_find_format(o->format)->has_alpha;
    return s->count == 3 || s->alpha >= 0;
}

static int channels_wanted(const make_image *image, const make_shape *s, make_role role) {
    int keeps_alpha = s->alpha >= 0 && role != ROLE_BARE && image->options.alpha != ZT_ALPHA_NONE;
    int more = image->options.alpha == ZT_ALPHA_STRAIGHT || image->options.alpha == ZT_ALPHA_PREMULTIPLIED;
    if (role == ROLE_COVERED || keeps_alpha || more)
        return 4;
    return s->count;
}

static zt_alpha alpha_wanted(const make_image *image, const img_info *info, const make_shape *s, const make_use *use,
                             const zt_format_info *format) {
    int wish = image->options.alpha;
    if (use->role == ROLE_BARE || use->role == ROLE_MASK || !format->has_alpha || !make_is_colour(use->semantic))
        return ZT_ALPHA_NONE;
    if (wish != MAKE_UNSET)
        return (zt_alpha)wish;
    if (s->alpha >= 0)
        return info->alpha == IMG_ALPHA_PREMULTIPLIED ? ZT_ALPHA_PREMULTIPLIED : ZT_ALPHA_STRAIGHT;
    return use->role == ROLE_COVERED ? ZT_ALPHA_STRAIGHT : ZT_ALPHA_NONE;
}

uint32_t make_transfer_of(const make_image *image, const img_info *info, uint32_t semantic) {
    if (image->options.transfer != MAKE_UNSET)
        return (uint32_t)image->options.transfer;
    if (!make_is_colour(semantic))
        return 8;
    if (info->transfer)
        return info->transfer;
    return info->type == IMG_U8 || info->type == IMG_U16 ? ZT_TRANSFER_SRGB : ZT_TRANSFER_LINEAR;
}

static const char *choose_transfer(const make_image *image, const img_info *info, const make_use *use, choice *c) {
    const make_options *o = &image->options;
    c->transfer_in = c->transfer_out = make_transfer_of(image, info, use->semantic);
    if (c->format->is_srgb && !make_is_colour(use->semantic))
        return "an SRGB format is for colours, not for this semantic: take the UNORM format";
    if (c->format->is_srgb)
        c->transfer_out = ZT_TRANSFER_SRGB;
    else if (o->format && c->format->is_float && o->transfer == MAKE_UNSET)
        c->transfer_out = ZT_TRANSFER_LINEAR;
    if (c->transfer_in != c->transfer_out && !(zt_transfer_known(c->transfer_in) && zt_transfer_known(c->transfer_out)))
        return "the colours are coded in a way that cannot be converted to this format: say how "
               "with the option transfer, or take another format";
    return NULL;
}

/* NULL, or what is wrong with the wishes. */
static const char *choose(const make_image *image, const img_info *info, const make_shape *s, const make_use *use,
                          choice *c) {
    const make_options *o = &image->options;
    int coded = make_transfer_of(image, info, use->semantic) == 13 && make_is_colour(use->semantic);
    uint32_t number = o->format;
    if (use->role == ROLE_MASK)
        number = 9; /* R8_UNORM */
    else if (number == 0)
        number = make_usual_format(info->type, channels_wanted(image, s, use->role), coded);
    c->format = zt_find_format(number);
    if (!c->format || !c->format->is_plain)
        return "this format is stored only: ztex does not compress pictures into blocks. Take an "
               "uncompressed one";
    c->alpha = alpha_wanted(image, info, s, use, c->format);
    c->primaries = o->primaries != MAKE_UNSET ? (uint32_t)o->primaries : info->primaries;
    if (use->role == ROLE_MASK || !make_is_colour(use->semantic))
        c->primaries = 0;
    if (use->role == ROLE_MASK) {
        c->transfer_in = c->transfer_out = ZT_TRANSFER_LINEAR;
        return NULL;
    }
    if ((o->alpha == ZT_ALPHA_STRAIGHT || o->alpha == ZT_ALPHA_PREMULTIPLIED) && !c->format->has_alpha &&
        use->role == ROLE_PLAIN)
        return "this format has no alpha channel";
    return choose_transfer(image, info, use, c);
}

/* Which channel of the picture goes where. Grey becomes red, green and blue where these are wanted. */
static void map_channels(const make_shape *s, const choice *c, make_rows *rows) {
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

static void set_up_rows(make_rows *rows, const img_info *info, const make_shape *s, const choice *c,
                        const make_use *use) {
    rows->info = info;
    rows->format = c->format;
    rows->source_alpha = s->alpha;
    rows->alpha_in = s->alpha >= 0 ? info->alpha : IMG_ALPHA_NONE;
    rows->alpha_out = c->alpha;
    rows->transfer_in = c->transfer_in;
    rows->transfer_out = c->transfer_out;
    rows->role = use->role;
    rows->ramp = use->ramp;
    rows->turn = use->turn;
    map_channels(s, c, rows);
    int same_alpha = (int)rows->alpha_in == (int)rows->alpha_out ||
                     (rows->alpha_in != IMG_ALPHA_PREMULTIPLIED && c->alpha == ZT_ALPHA_NONE);
    rows->direct = (use->role == ROLE_PLAIN || use->role == ROLE_BARE) && same_alpha &&
                   rows->transfer_in == rows->transfer_out && c->format->channel_bits != 0 && !use->turn;
    for (uint32_t i = 0; i < rows->channels; i++)
        rows->direct &= rows->map[i] >= 0;
}

/* A picture in memory has its channels in order, straight alpha, and linear light. */
static void set_up_ready(make_rows *rows, const make_use *use, float *table) {
    rows->ready = use->ready;
    rows->alpha_in = IMG_ALPHA_STRAIGHT;
    rows->transfer_in = ZT_TRANSFER_LINEAR;
    rows->direct = 0;
    for (int i = 0; i <= MAKE_TABLE; i++) {
        float root = (float)i / MAKE_TABLE;
        table[i] = zt_transfer_encode(rows->transfer_out, root * root);
    }
    rows->table = table;
}

static void order_shape(make_shape *s) {
    for (int i = 0; i < s->count; i++)
        s->channels[i] = i;
    s->alpha = s->alpha >= 0 ? s->count : -1;
}

static void warn_of_loss(const make_store *store, const make_image *image, const make_shape *s, const choice *c,
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

/* levels: of the picture, that are the image's; 1: the others are made. */
static int start_image(make_store *store, const make_image *image, const img_info *info, const choice *c,
                       const make_use *use, uint32_t levels, make_stored *out) {
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
                          .given_levels = levels > 1,
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

static int pump(make_store *store, const make_image *image, make_rows *rows, const char *path, uint32_t level,
                const make_stored *out) {
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
            status = make_fail_picture(store, image, path, error);
        zt_result result = ZT_OK;
        if (status == CMD_OK)
            result = level ? zt_writer_put_level_rows(store->writer, out->image, level, texture_rows, count, 0, &diag)
                           : zt_writer_put_rows(store->writer, out->image, texture_rows, count, 0, &diag);
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

img_reader *make_open_mask(const make_store *store, const make_image *mask, size_t index, uint32_t width,
                           uint32_t height, char *error) {
    make_image sized = *mask;
    size_t file = mask->file_count > 1 ? index : 0;
    img_reader *reader = make_open_picture(store, mask, file, ZT_SEMANTIC_OPACITY, 1, error);
    if (!reader)
        return NULL;
    const img_info *own = img_get_info(reader);
    if (own->width == width && own->height == height)
        return reader;
    img_close(reader);
    sized.resize_width = width;
    sized.resize_height = height;
    return make_open_picture(store, &sized, file, ZT_SEMANTIC_OPACITY, 1, error);
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
    choice chosen;   /* by the first picture, for all */
    size_t index;    /* of the picture */
    uint32_t levels; /* that the picture has and the image takes; 1: the others are made */
    make_stored *out;
} picture_job;

/* What the reader tells, or, of a picture that has been worked on, what became of it. */
static const img_info *info_of(const picture_job *job, const img_reader *reader, img_info *own) {
    *own = *img_get_info(reader);
    if (job->use->ready) {
        own->width = job->use->ready->picture.width;
        own->height = job->use->ready->picture.height;
    }
    return own;
}

static img_reader *open_level(const picture_job *job, uint32_t level, char *error) {
    const make_image *image = job->image;
    img_open_options options = {.subimage = image->files[0].subimage,
                                .level = level,
                                .keep_orientation = 1,
                                .memory = cmd_limits(job->store->args)->memory};
    return img_open(image->files[0].path, &options, error);
}

/* A picture may bring its coarser levels along. They are taken where they are all that are wanted and have the right
 * sizes, unless something is done to the picture, or a filter is named to make them with. */
static uint32_t own_levels(const picture_job *job, const img_info *info) {
    const make_image *image = job->image;
    char error[IMG_ERROR];
    uint32_t side = info->width > info->height ? info->width : info->height, wanted = 1;
    while (side >> wanted)
        wanted++;
    if (image->options.levels > 0 && (uint32_t)image->options.levels < wanted)
        wanted = (uint32_t)image->options.levels;
    int changed = job->use->role != ROLE_PLAIN || job->use->ready || job->use->turn || image->crop.width > 0 ||
                  image->resize_width > 0 || (info->orientation > 1 && image->options.keep_orientation != 1);
    if (changed || image->file_count > 1 || image->all_subimages || image->volume || info->depth > 1 ||
        image->options.mip_filter >= 0 || info->levels < wanted)
        return 1;
    for (uint32_t level = 1; level < wanted; level++) {
        img_reader *reader = open_level(job, level, error);
        const img_info *own = reader ? img_get_info(reader) : NULL;
        uint32_t width = info->width >> level, height = info->height >> level;
        int fits = own && own->width == (width ? width : 1) && own->height == (height ? height : 1) &&
                   own->channels == info->channels;
        img_close(reader);
        if (!fits)
            return 1;
    }
    return wanted;
}

static int open_mask(const picture_job *job, const img_info *info, img_reader **out) {
    const make_image *mask = job->use->mask;
    char error[IMG_ERROR];
    *out = NULL;
    if (mask->all_subimages || mask->volume)
        return make_complain(job->store->scene, mask->pointer,
                             "a mask is one picture, or a list of 'files' for frames");
    if (mask->file_count > 1 && mask->file_count != job->image->file_count)
        return make_complain(job->store->scene, mask->pointer, "the mask has %u frames, and what it covers has %u",
                             (unsigned)mask->file_count, (unsigned)job->image->file_count);
    *out = make_open_mask(job->store, mask, job->index, info->width, info->height, error);
    size_t file = mask->file_count > 1 ? job->index : 0;
    return *out ? CMD_OK : make_fail_picture(job->store, mask, mask->files[file].path, error);
}

/* rows: as for level 0. */
static int pump_level(const picture_job *job, const make_rows *rows, const char *path, uint32_t level) {
    char error[IMG_ERROR];
    make_rows own = *rows;
    own.reader = open_level(job, level, error);
    if (!own.reader)
        return make_fail_picture(job->store, job->image, path, error);
    own.info = img_get_info(own.reader);
    int status = pump(job->store, job->image, &own, path, level, job->out);
    img_close(own.reader);
    return status;
}

static int store_open_picture(picture_job *job, img_reader *reader, const char *path, int is_first) {
    img_info own;
    const img_info *info = info_of(job, reader, &own);
    char error[IMG_ERROR];
    float table[MAKE_TABLE + 1];
    make_rows rows = {.reader = reader};
    make_shape s;
    choice c;
    int status = check_picture(job->store, job->image, path, info, job->out, is_first);
    if (status != CMD_OK)
        return status;
    if (make_find_shape(info, job->use->semantic, &s)) {
        snprintf(error, sizeof error, "%u channels, and no R, G, B among them", (unsigned)info->channels);
        return make_fail_picture(job->store, job->image, path, error);
    }
    if (job->use->ready)
        order_shape(&s);
    make_image same = *job->image;
    if (!is_first)
        same.options.format = job->chosen.format->format;
    const char *wrong = choose(&same, info, &s, job->use, &c);
    if (wrong)
        return make_complain(job->store->scene, job->image->pointer, "%s: %s", path, wrong);
    if (is_first) {
        job->chosen = c;
        warn_of_loss(job->store, job->image, &s, &c, job->use);
        job->levels = own_levels(job, info);
        status = start_image(job->store, job->image, info, &c, job->use, job->levels, job->out);
    }
    c.alpha = job->chosen.alpha;
    c.transfer_out = job->chosen.transfer_out;
    set_up_rows(&rows, info, &s, &c, job->use);
    if (job->use->ready)
        set_up_ready(&rows, job->use, table);
    else if (status == CMD_OK && job->use->mask && rows.role != ROLE_BARE && rows.role != ROLE_PLAIN)
        status = open_mask(job, info, &rows.mask);
    if (status == CMD_OK)
        status = pump(job->store, job->image, &rows, path, 0, job->out);
    for (uint32_t level = 1; status == CMD_OK && level < job->levels; level++)
        status = pump_level(job, &rows, path, level);
    img_close(rows.mask);
    return status;
}

static int store_pictures(picture_job *job) {
    char error[IMG_ERROR];
    size_t count = job->image->file_count;
    int status = CMD_OK;
    for (size_t i = 0; status == CMD_OK && i < count; i++) {
        const char *path = job->image->files[i].path;
        job->index = i;
        img_reader *reader = make_open_picture(job->store, job->image, i, job->use->semantic, !job->use->ready, error);
        if (!reader)
            return make_fail_picture(job->store, job->image, path, error);
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
        img_reader *reader = make_open_picture(job->store, &part, 0, job->use->semantic, 1, error);
        if (!reader)
            return make_fail_picture(job->store, job->image, file.path, error);
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
    if (use->ready) /* only itself is like it */
        fprintf(stream, "%p|", (const void *)use->ready);
    for (int i = 0; use->turn && i < 9; i++)
        fprintf(stream, "%a %a ", use->turn->to_patch[i], use->turn->to_root[i]);
    for (int i = 0; use->turn && i < 4; i++)
        fprintf(stream, "%a ", use->turn->scale[i]);
    if (use->turn)
        fprintf(stream, "%d|", use->turn->y_down);
    fprintf(stream, "%d %d|%d %d %d|%d", make_is_colour(use->semantic), use->semantic == ZT_SEMANTIC_NORMAL,
            use->wrap[0], use->wrap[1], use->wrap[2], (int)use->role);
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
    for (size_t i = 0; i < store->stored_count && !use->ready; i++)
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
    make_shape s;
    *mask = 0;
    img_reader *reader = make_open_picture(store, image, 0, use->semantic, 0, error);
    if (!reader)
        return make_fail_picture(store, image, image->files[0].path, error);
    if (make_find_shape(img_get_info(reader), use->semantic, &s) == 0)
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
