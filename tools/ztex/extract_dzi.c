/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A texture as a Deep Zoom pyramid: NAME.dzi beside NAME_files/LEVEL/COLUMN_ROW.FORMAT, level 0 being one pixel. Levels
 * that the texture's image has in just this size are taken from it; the others, and all of textures of other kinds, are
 * looked up.
 */
#include "extract.h"
#include "pick.h"
#include "render.h"

#include <dirent.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define PATH_SIZE 4096
#define ROWS 64 /* that are looked up at once */
#define SAMPLER_BYTES (UINT64_C(128) << 20)

typedef struct dzi_job {
    cmd_args *args;
    const cmd_input *input;
    uint32_t texture, layer, array_layer;
    const char *type; /* extension of the tiles */
    uint32_t tile_size, overlap;
    uint32_t width, height, levels;
    extract_part part; /* level 0 of the layer's image, that of the root of a zipmap */
    int exact;         /* levels of the image may be taken as they are */
    zt_sampler *sampler;
    render_style style;
    uint32_t channels;
    char folder[PATH_SIZE + 16]; /* of the tiles, until everything is there */
    cmd_progress progress;
    double done, total; /* texels */
} dzi_job;

static uint32_t halved(uint32_t size, uint32_t times) {
    return (uint32_t)(((uint64_t)size + (UINT64_C(1) << times) - 1) >> times);
}

/* ---- folders ------------------------------------------------------------------------------------------------ */

static int make_folder(const char *path) {
    return mkdir(path, 0777) == 0 ? CMD_OK : cmd_fail(CMD_IO, "%s: %s", path, strerror(errno));
}

/* What is in a folder that this program has made: files, and folders of files. */
static void empty_folder(const char *path, int depth) {
    DIR *list = opendir(path);
    char name[PATH_SIZE + 256];
    for (const struct dirent *entry; list && (entry = readdir(list)) != NULL;) {
        if (strcmp(entry->d_name, ".") == 0 || strcmp(entry->d_name, "..") == 0)
            continue;
        snprintf(name, sizeof name, "%s/%s", path, entry->d_name);
        if (depth == 0)
            empty_folder(name, 1);
        else
            unlink(name);
    }
    if (list)
        closedir(list);
    rmdir(path);
}

/* ---- tiles ---------------------------------------------------------------------------------------------------- */

/* A stretch of a level that a tile has, with its overlap. */
typedef struct stretch {
    uint32_t from, count;
} stretch;

static stretch stretch_of(const dzi_job *job, uint32_t index, uint32_t size) {
    uint64_t from = (uint64_t)index * job->tile_size, to = from + job->tile_size + job->overlap;
    from -= index > 0 ? job->overlap : 0;
    return (stretch){(uint32_t)from, (uint32_t)((to < size ? to : size) - from)};
}

static uint32_t count_tiles(const dzi_job *job, uint32_t size) {
    return (size + job->tile_size - 1) / job->tile_size;
}

static void tile_name(const dzi_job *job, uint32_t level, uint32_t column, uint32_t row, char path[PATH_SIZE + 96]) {
    snprintf(path, PATH_SIZE + 96, "%s/%u/%u_%u.%s", job->folder, (unsigned)level, (unsigned)column, (unsigned)row,
             job->type);
}

static int step(dzi_job *job, uint32_t width, uint32_t height) {
    job->done += (double)width * height;
    return cmd_progress_step(&job->progress, job->done / job->total) ? cmd_cancelled() : CMD_OK;
}

/* A level as it is stored. */
static int copy_row(dzi_job *job, uint32_t number, uint32_t source, uint32_t width, uint32_t row, stretch down) {
    char path[PATH_SIZE + 96];
    int status = CMD_OK;
    for (uint32_t column = 0; status == CMD_OK && column < count_tiles(job, width); column++) {
        stretch across = stretch_of(job, column, width);
        extract_part part = job->part;
        part.region = (zt_region){.level = source,
                                  .layer = job->array_layer,
                                  .x = across.from,
                                  .y = down.from,
                                  .width = across.count,
                                  .height = down.count,
                                  .depth = 1};
        part.quality = (int)cmd_integer(job->args, "quality");
        tile_name(job, number, column, row, path);
        status = extract_picture(job->args, &part, path, NULL);
        if (status == CMD_OK)
            status = step(job, across.count, down.count);
    }
    return status;
}

static int write_tile(const dzi_job *job, const char *path, const unsigned char *texels, size_t pitch, uint32_t width,
                      uint32_t height) {
    char error[IMG_ERROR];
    img_text texts[PICK_TEXTS];
    img_create_options how = {.width = width,
                              .height = height,
                              .channels = job->channels,
                              .type = IMG_U8,
                              .alpha = job->channels == 4 ? IMG_ALPHA_STRAIGHT : IMG_ALPHA_NONE,
                              .transfer = (uint8_t)job->style.transfer,
                              .primaries = job->part.info.primaries,
                              .quality = (int)cmd_integer(job->args, "quality"),
                              .texts = texts};
    how.text_count = pick_texts(job->input->file, texts);
    if (img_write(path, &how, IMG_U8, texels, pitch, error))
        return cmd_fail(CMD_IO, "%s: %s", path, error);
    return CMD_OK;
}

static int open_sampler(dzi_job *job) {
    zt_sampler_options how = {.size = sizeof how, .layer = job->layer};
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = zt_sampler_open(job->input->file, job->texture, &how, &diag, &job->sampler);
    return result == ZT_OK ? CMD_OK : cmd_fail_result(job->input->name, result, &diag);
}

/* A sampler keeps what it has decoded, which for large textures would be everything in the end. */
static int refresh_sampler(dzi_job *job) {
    zt_sampler_info info;
    zt_get_sampler(job->sampler, &info);
    if (info.tile_bytes < SAMPLER_BYTES)
        return CMD_OK;
    zt_sampler_close(job->sampler);
    job->sampler = NULL;
    return open_sampler(job);
}

/* Rows of a level, packed. */
static int look_up(dzi_job *job, stretch down, unsigned char *texels) {
    static const uint32_t formats[5] = {0, 9, 0, 23, 37};
    const render_view whole = {0.0, 0.0, 1.0, 1.0};
    size_t width = job->style.width;
    float *rgba = malloc(width * ROWS * 4 * sizeof *rgba);
    zt_result result = ZT_OK;
    zt_diag diag = {.offset = UINT64_MAX};
    if (!rgba)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    for (uint32_t y = 0; result == ZT_OK && y < down.count; y += ROWS) {
        uint32_t count = down.count - y < ROWS ? down.count - y : ROWS;
        result = render_rows(job->sampler, &job->style, &whole, down.from + y, count, rgba, 4 * width,
                             cmd_parallel(job->args), &diag);
        if (result == ZT_OK)
            result = zt_pack_texels(formats[job->channels], rgba, width * count, texels + y * width * job->channels);
    }
    free(rgba);
    return result == ZT_OK ? CMD_OK : cmd_fail_result(job->input->name, result, &diag);
}

static int render_row(dzi_job *job, uint32_t number, uint32_t width, uint32_t row, stretch down) {
    char path[PATH_SIZE + 96];
    size_t pitch = (size_t)width * job->channels;
    unsigned char *texels = malloc(pitch * down.count);
    int status = texels ? look_up(job, down, texels) : cmd_fail(CMD_INTERNAL, "out of memory");
    for (uint32_t column = 0; status == CMD_OK && column < count_tiles(job, width); column++) {
        stretch across = stretch_of(job, column, width);
        tile_name(job, number, column, row, path);
        status = write_tile(job, path, texels + (size_t)across.from * job->channels, pitch, across.count, down.count);
        if (status == CMD_OK)
            status = step(job, across.count, down.count);
    }
    free(texels);
    return status == CMD_OK ? refresh_sampler(job) : status;
}

/* The level of the image that has this size, or ZT_NONE. */
static uint32_t stored_level(const dzi_job *job, uint32_t times, uint32_t width, uint32_t height) {
    zt_level_info level;
    if (!job->exact || zt_get_level(job->input->file, job->part.image, times, &level) != ZT_OK)
        return ZT_NONE;
    return level.width == width && level.height == height ? times : ZT_NONE;
}

/* times: how often the full size is halved. */
static int write_level(dzi_job *job, uint32_t times) {
    uint32_t width = halved(job->width, times), height = halved(job->height, times), number = job->levels - 1 - times;
    uint32_t source = stored_level(job, times, width, height);
    char path[PATH_SIZE + 96];
    snprintf(path, sizeof path, "%s/%u", job->folder, (unsigned)number);
    int status = make_folder(path);
    job->style.width = width;
    job->style.height = height;
    /* One trilinear lookup between two levels is soft: four of a finer one are nearer to a filter's work. */
    job->style.supersample = times > 0 ? 2 : 1;
    for (uint32_t row = 0; status == CMD_OK && row < count_tiles(job, height); row++) {
        stretch down = stretch_of(job, row, height);
        status = source == ZT_NONE ? render_row(job, number, width, row, down)
                                   : copy_row(job, number, source, width, row, down);
    }
    return status;
}

/* ---- sizes ---------------------------------------------------------------------------------------------------- */

/* How many times as dense as the root's the texels of a patch are, in its middle. */
static double density_of(const zt_patch_info *patch, const zt_image_info *image, const zt_image_info *root) {
    const double *m = patch->root_matrix;
    /* The root's point that the middle of the patch is: with the adjugate. */
    double a[3];
    for (int r = 0; r < 3; r++) {
        int i = (r + 1) % 3, k = (r + 2) % 3;
        double c0 = m[3 + i] * m[6 + k] - m[3 + k] * m[6 + i];
        double c1 = m[6 + i] * m[k] - m[6 + k] * m[i];
        double c2 = m[i] * m[3 + k] - m[k] * m[3 + i];
        a[r] = 0.5 * c0 + 0.5 * c1 + c2;
    }
    double u = a[0] / a[2], v = a[1] / a[2], w = m[6] * u + m[7] * v + m[8];
    double x0 = (m[0] - 0.5 * m[6]) / w, x1 = (m[1] - 0.5 * m[7]) / w;
    double y0 = (m[3] - 0.5 * m[6]) / w, y1 = (m[4] - 0.5 * m[7]) / w;
    double texels = (double)image->width * image->height / ((double)root->width * root->height);
    return sqrt(fabs(x0 * y1 - x1 * y0) * texels);
}

/* How much larger than the root the picture is that shows the finest patch texel by texel. */
static double find_enlargement(const dzi_job *job) {
    zt_texture_info info;
    double most = 1.0;
    zt_get_texture(job->input->file, job->texture, &info);
    for (uint32_t i = 1; i < info.patch_count; i++) {
        zt_patch_info patch;
        zt_layer_info shown;
        zt_image_info image;
        if (zt_get_patch(job->input->file, job->texture, i, &patch) != ZT_OK)
            continue;
        uint32_t number = zt_get_patch_image(job->input->file, job->texture, i, job->layer);
        if (patch.texture != ZT_NONE && zt_get_layer(job->input->file, patch.texture, job->layer, &shown) == ZT_OK)
            number = shown.image;
        if (zt_get_image(job->input->file, number, &image) != ZT_OK)
            continue;
        double density = density_of(&patch, &image, &job->part.info);
        most = isfinite(density) && density > most ? density : most;
    }
    return most;
}

static uint32_t scaled(uint32_t size, double factor) {
    double value = floor(size * factor + 0.5);
    return value < 1.0 ? 1 : (uint32_t)value;
}

static void choose_size(dzi_job *job) {
    const zt_image_info *root = &job->part.info;
    uint32_t longer = root->width > root->height ? root->width : root->height;
    double most = (double)cmd_integer(job->args, "max-size"), factor = find_enlargement(job);
    if (factor * longer > most) {
        cmd_note(job->args, "%s: %.0f pixels would show every texel; --max-size bounds it to %.0f", job->input->name,
                 factor * longer, most);
        factor = most / longer;
    }
    job->width = scaled(root->width, factor);
    job->height = scaled(root->height, factor);
    uint32_t side = job->width > job->height ? job->width : job->height;
    for (job->levels = 1; halved(side, job->levels - 1) > 1;)
        job->levels++;
    for (uint32_t i = 0; i < job->levels; i++)
        job->total += (double)halved(job->width, i) * halved(job->height, i);
}

static int open_texture(dzi_job *job) {
    uint32_t image, semantic;
    zt_image_info seen;
    zt_texture_info info;
    int status = pick_texture(job->input, cmd_text(job->args, "texture"), &job->texture);
    if (status == CMD_OK)
        status = pick_layer(job->input, job->texture, cmd_text(job->args, "layer"), &job->layer);
    if (status != CMD_OK)
        return status;
    zt_get_texture(job->input->file, job->texture, &info);
    if (pick_image_of(job->input->file, job->texture, job->layer, &image, &semantic, &seen) != 0)
        return cmd_fail(CMD_INTERNAL, "%s: the texture has no image", job->input->name);
    if (image != ZT_NONE)
        status = extract_part_of(job->input->file, job->input->name, image, 0, &job->part);
    else
        job->part = (extract_part){
            .info = seen, .format = zt_find_format(seen.format), .is_colour = pick_is_colour(semantic)};
    if (status != CMD_OK)
        return status;
    /* What is looked up has 8 bits in sRGB, or as the values are: levels of one picture shall not differ in kind. */
    job->exact = info.kind == ZT_KIND_IMAGE && job->part.format && !job->part.format->is_float &&
                 (!job->part.is_colour || job->part.info.transfer == ZT_TRANSFER_SRGB);
    job->array_layer = (uint32_t)cmd_integer(job->args, "array-layer");
    if (job->array_layer >= job->part.info.layers)
        return cmd_usage(job->args, "--array-layer %u: there are %u, from 0 on", (unsigned)job->array_layer,
                         (unsigned)job->part.info.layers);
    if (job->part.info.depth > 1)
        return cmd_fail(CMD_UNSUPPORTED, "%s: a volume has no Deep Zoom form: extract slices", job->input->name);
    return open_sampler(job);
}

static void choose_style(dzi_job *job) {
    const extract_part *part = &job->part;
    job->channels = part->format && part->format->channels == 1 ? 1 : 3;
    if (part->is_colour && part->info.alpha_mode != ZT_ALPHA_NONE)
        job->channels = 4;
    const char *type = cmd_text(job->args, "format");
    job->type = type ? type : job->channels == 4 ? "png" : "jpg";
    job->style = (render_style){.array_layer = job->array_layer,
                                .w = 0.5,
                                .gain = 1.0f,
                                .transfer = part->is_colour ? ZT_TRANSFER_SRGB : ZT_TRANSFER_LINEAR,
                                .straight = job->channels == 4};
}

/* ---- the whole ------------------------------------------------------------------------------------------------ */

static int write_descriptor(const dzi_job *job, const char *path) {
    cmd_output output = {0};
    int status = cmd_output_open(&output, path, 0);
    if (status != CMD_OK)
        return status;
    fprintf(
        output.stream,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<Image xmlns=\"http://schemas.microsoft.com/deepzoom/2008\" Format=\"%s\" Overlap=\"%u\" TileSize=\"%u\">\n"
        "  <Size Width=\"%u\" Height=\"%u\"/>\n</Image>\n",
        job->type, (unsigned)job->overlap, (unsigned)job->tile_size, (unsigned)job->width, (unsigned)job->height);
    return cmd_output_commit(&output);
}

static int check_paths(const char *path, char tiles[PATH_SIZE], char temporary[PATH_SIZE]) {
    const char *slash = strrchr(path, '/');
    size_t length = strlen(path), base = slash ? (size_t)(slash + 1 - path) : 0;
    struct stat status;
    if (length < 5 || length - base < 5 || strcmp(path + length - 4, ".dzi") != 0)
        return cmd_fail(CMD_USAGE, "%s: the name of a Deep Zoom descriptor ends in .dzi", path);
    if (length > PATH_SIZE - 64)
        return cmd_fail(CMD_USAGE, "the path is too long");
    snprintf(tiles, PATH_SIZE, "%.*s_files", (int)(length - 4), path);
    snprintf(temporary, PATH_SIZE, "%.*s.ztex-XXXXXX", (int)base, path);
    if (lstat(tiles, &status) != 0)
        return CMD_OK;
    cmd_error("%s: it is there already", tiles);
    cmd_hint("Remove it, or take another name: tiles of two pictures shall not mix.");
    return CMD_USAGE;
}

static int write_all(dzi_job *job, const char *path, const char *tiles) {
    int status = make_folder(job->folder);
    for (uint32_t times = 0; status == CMD_OK && times < job->levels; times++)
        status = write_level(job, times);
    if (status == CMD_OK && rename(job->folder, tiles) != 0)
        status = cmd_fail(CMD_IO, "%s: %s", tiles, strerror(errno));
    if (status != CMD_OK) {
        empty_folder(job->folder, 0);
        return status;
    }
    status = write_descriptor(job, path);
    if (status != CMD_OK)
        empty_folder(tiles, 0);
    return status;
}

int extract_dzi(cmd_args *args, const cmd_input *input, const char *path) {
    char tiles[PATH_SIZE], temporary[PATH_SIZE];
    dzi_job job = {.args = args,
                   .input = input,
                   .tile_size = (uint32_t)cmd_integer(args, "tile-size"),
                   .overlap = (uint32_t)cmd_integer(args, "overlap")};
    if (job.overlap > job.tile_size)
        return cmd_usage(args, "--overlap %u is larger than the tiles", (unsigned)job.overlap);
    int status = check_paths(path, tiles, temporary);
    if (status == CMD_OK)
        status = open_texture(&job);
    if (status == CMD_OK && !mkdtemp(temporary))
        status = cmd_fail(CMD_IO, "%s: %s", temporary, strerror(errno));
    if (status == CMD_OK) {
        /* What mkdtemp makes is for nobody else; the folder in it is as the user's mask says. */
        snprintf(job.folder, sizeof job.folder, "%s/files", temporary);
        choose_size(&job);
        choose_style(&job);
        cmd_progress_begin(&job.progress, args, "extracting");
        status = write_all(&job, path, tiles);
        cmd_progress_end(&job.progress);
        rmdir(temporary);
    }
    zt_sampler_close(job.sampler);
    return status;
}
