/* SPDX-License-Identifier: Apache-2.0 */
/* Umbrellas into the writer: bases, arrangement, coarser levels. What level 0 shows is asked of a file in memory that
 * has nothing else. */
#include "umbrellas.h"

#include <stdlib.h>
#include <string.h>

#include "drawing.h"
#include "make_author.h"

#define R8G8B8A8_SRGB 43
#define DRAWN 1024     /* pixels along the longer side of a background that is drawn */
#define SAMPLES 2      /* along each side of what the truth of level 1 is made of */
#define MEAN_SAMPLES 2 /* where there is no level 1 */

typedef struct storing {
    make_store *store;
    const make_texture *texture;
    const make_size *sizes;
    uint32_t index; /* of the texture */
    author_base *bases;
    author_umbrellas umbrellas;
    uint32_t level_count;
} storing;

/* A file in memory. */
typedef struct bytes {
    uint8_t *data;
    size_t size, room;
} bytes;

/* ---- images ------------------------------------------------------------------------------------------------ */

static int fail(const storing *s, zt_result result, const zt_diag *diag) {
    return make_fail_writer(s->store->scene, s->texture->pointer, result, diag);
}

static int put_rows(const storing *s, zt_writer *writer, uint32_t image, const author_picture *picture) {
    size_t count = (size_t)picture->width * 4;
    float *coded = malloc(count * sizeof *coded);
    uint8_t *row = malloc(count);
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = coded && row ? ZT_OK : ZT_NO_MEMORY;
    for (uint32_t y = 0; result == ZT_OK && y < picture->height; y++) {
        const float *from = picture->texels + y * count;
        for (size_t i = 0; i < count; i++)
            coded[i] = i % 4 == 3 ? from[i] : zt_transfer_encode(ZT_TRANSFER_SRGB, from[i]);
        result = zt_pack_texels(R8G8B8A8_SRGB, coded, picture->width, row);
        if (result == ZT_OK)
            result = zt_writer_put_rows(writer, image, row, 1, 0, &diag);
    }
    free(coded);
    free(row);
    return result == ZT_OK ? CMD_OK : fail(s, result, &diag);
}

static int put_picture(const storing *s, make_store *to, const author_picture *picture, const make_options *o,
                       const uint8_t wrap[3], uint32_t *image) {
    zt_image_desc desc = {.format = R8G8B8A8_SRGB,
                          .width = picture->width,
                          .height = picture->height,
                          .levels = o->levels > 0 ? (uint32_t)o->levels : 0,
                          .tile_edge = o->tile_edge > 0 ? (uint32_t)o->tile_edge : 0,
                          .alpha_mode = ZT_ALPHA_STRAIGHT,
                          .primaries = o->primaries != MAKE_UNSET ? (uint8_t)o->primaries : 0,
                          .mip_filter = o->mip_filter > 0 ? (uint8_t)o->mip_filter : 0,
                          .wrap_u = wrap[0],
                          .wrap_v = wrap[1],
                          .wrap_w = wrap[2]};
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = zt_writer_add_image(to->writer, &desc, &diag, image);
    return result == ZT_OK ? put_rows(s, to->writer, *image, picture) : fail(s, result, &diag);
}

static int put_base(const storing *s, make_store *to, uint32_t index) {
    static const uint8_t clamped[3] = {ZT_WRAP_CLAMP, ZT_WRAP_CLAMP, ZT_WRAP_CLAMP};
    const make_options *o = &s->texture->umbrellas->bases[index].image->options;
    return put_picture(s, to, &s->bases[index].picture, o, clamped, &s->umbrellas.bases[index].source);
}

/* A drawing as a background. */
static int put_drawing(const storing *s, make_store *to, const make_image *image, uint32_t *out) {
    const char *path = image->files[0].path;
    uint32_t longer = image->resize_width > image->resize_height ? image->resize_width : image->resize_height;
    author_picture picture;
    char error[DRAWING_ERROR];
    int status = drawing_picture(to->args, path, longer ? longer : DRAWN, &picture, error);
    if (status == CMD_INVALID)
        return make_fail_picture(to, image, path, error);
    if (status == CMD_OK)
        status = put_picture(s, to, &picture, &image->options, s->texture->wrap, out);
    author_picture_release(&picture);
    return status;
}

static int put_background(const storing *s, make_store *to, zt_umbrella_info *info) {
    const make_umbrellas *u = s->texture->umbrellas;
    make_stored stored;
    make_use use = {.semantic = s->texture->semantics[0], .role = ROLE_PLAIN};
    info->background_kind = u->background_kind;
    memcpy(info->background, u->background, sizeof info->background);
    info->background_source = u->background_kind == ZT_BACKGROUND_TEXTURE ? u->background_texture : ZT_NONE;
    if (u->background_kind != ZT_BACKGROUND_IMAGE)
        return CMD_OK;
    if (drawing_is_one(u->background_image->files[0].path))
        return put_drawing(s, to, u->background_image, &info->background_source);
    memcpy(use.wrap, s->texture->wrap, sizeof use.wrap);
    int status = make_store_image(to, u->background_image, &use, &stored);
    info->background_source = status == CMD_OK ? stored.image : ZT_NONE;
    return status;
}

/* Sources of the bases and the background are those of this writer from then on. */
static int put_sources(storing *s, make_store *to) {
    int status = put_background(s, to, &s->umbrellas.info);
    for (uint32_t i = 0; status == CMD_OK && i < s->texture->umbrellas->base_count; i++) {
        zt_umbrella_base *base = &s->umbrellas.bases[i];
        base->shows_texture = s->texture->umbrellas->bases[i].texture != ZT_NONE;
        base->source = s->texture->umbrellas->bases[i].texture;
        status = base->shows_texture ? CMD_OK : put_base(s, to, i);
    }
    return status;
}

static int put_texture(const storing *s, make_store *to, const char *name, const zt_umbrella_info *info,
                       uint32_t *texture) {
    zt_layer_desc layers[MAKE_LAYERS];
    zt_texture_desc desc = make_describe(s->texture, NULL, layers);
    zt_diag diag = {.offset = UINT64_MAX};
    desc.name = name;
    zt_result result = zt_writer_add_umbrellas(to->writer, &desc, info, &diag, texture);
    return result == ZT_OK ? CMD_OK : fail(s, result, &diag);
}

/* ---- the file in memory ------------------------------------------------------------------------------------ */

static zt_result append(void *user, const void *data, size_t size) {
    bytes *m = user;
    if (m->room - m->size < size) {
        size_t room = m->room + size > m->room * 2 ? m->room + size : m->room * 2;
        uint8_t *more = realloc(m->data, room);
        if (!more)
            return ZT_NO_MEMORY;
        m->data = more;
        m->room = room;
    }
    memcpy(m->data + m->size, data, size);
    m->size += size;
    return ZT_OK;
}

static int shows_textures(const make_umbrellas *u) {
    int shows = u->background_kind == ZT_BACKGROUND_TEXTURE;
    for (uint32_t i = 0; i < u->base_count; i++)
        shows = shows || u->bases[i].texture != ZT_NONE;
    return shows;
}

/* The background alone, at all levels. */
static int put_bare(const storing *s, make_store *to, uint32_t *texture) {
    zt_umbrella_level levels[UMBRELLAS_LEVELS] = {{0}};
    zt_umbrella_info info = s->umbrellas.info;
    size_t cells = 0;
    for (uint32_t l = 0; l < s->level_count; l++)
        cells += (size_t)((info.grid_x >> l) + !(info.grid_x >> l)) * ((info.grid_y >> l) + !(info.grid_y >> l));
    uint32_t *starts = calloc(cells + 1, sizeof *starts);
    if (!starts)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    info.level_count = s->level_count;
    info.levels = levels;
    info.base_count = info.umbrella_count = info.base_vertex_count = info.morph_vertex_count = 0;
    info.variant_colour_count = info.explicit_vertex_count = info.explicit_colour_count = 0;
    info.entry_count = info.longest_list = 0;
    info.cell_count = (uint32_t)cells;
    info.list_starts = starts;
    int status = put_texture(s, to, "background", &info, texture);
    free(starts);
    return status;
}

static int write_memory(storing *s, make_store *to, uint32_t textures[2]) {
    int status = CMD_OK;
    make_size *sizes = calloc(s->store->scene->texture_count, sizeof *sizes);
    if (!sizes)
        status = cmd_fail(CMD_INTERNAL, "out of memory");
    if (status == CMD_OK && shows_textures(s->texture->umbrellas))
        status = make_store_textures(to, s->index, sizes);
    free(sizes);
    if (status == CMD_OK)
        status = put_sources(s, to);
    if (status == CMD_OK)
        status = put_texture(s, to, "level 0", &s->umbrellas.info, &textures[0]);
    if (status == CMD_OK)
        status = put_bare(s, to, &textures[1]);
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = status == CMD_OK ? zt_writer_finish(to->writer, &diag) : ZT_OK;
    return result == ZT_OK ? status : fail(s, result, &diag);
}

/* Level 0 as texture 0 and the background as texture 1 of textures. */
static int open_memory(storing *s, bytes *m, uint32_t textures[2], zt_file **file) {
    make_store to = {.args = s->store->args, .scene = s->store->scene};
    zt_sink sink = {m, append};
    zt_writer_options how = {.size = sizeof how,
                             .parallel = cmd_parallel(s->store->args),
                             .limits = cmd_limits(s->store->args),
                             .effort = 1};
    zt_open_options open = {.size = sizeof open, .limits = cmd_limits(s->store->args)};
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = zt_writer_open_sink(&sink, &how, &diag, &to.writer);
    if (result != ZT_OK)
        return fail(s, result, &diag);
    int status = write_memory(s, &to, textures);
    zt_writer_close(to.writer);
    make_store_release(&to);
    if (status != CMD_OK)
        return status;
    result = zt_open_memory(m->data, m->size, &open, &diag, file);
    return result == ZT_OK ? CMD_OK : fail(s, result, &diag);
}

/* ---- levels ------------------------------------------------------------------------------------------------ */

static uint32_t cells_at(uint32_t cells, uint32_t level) {
    return cells >> level ? cells >> level : 1;
}

static int check_memory(const storing *s, uint32_t width, uint32_t height) {
    uint64_t memory = cmd_limits(s->store->args)->memory ? cmd_limits(s->store->args)->memory : UINT64_C(1) << 30;
    char text[32];
    /* The truth, what is seen of each umbrella, and what is fitted: some 12 times the first. */
    if ((uint64_t)width * height * 4 * sizeof(float) <= memory / 12)
        return CMD_OK;
    return make_complain(s->store->scene, s->texture->pointer,
                         "the levels of so many cells need more memory than %s: see --memory, or \"levels\": "
                         "{\"count\": 1}",
                         cmd_bytes_text(text, sizeof text, memory));
}

static int fit(storing *s, author_run *run, const author_picture *truth, const author_picture *background,
               author_level_report *reports) {
    author_levels how = s->texture->umbrellas->levels;
    how.repeat_x = s->texture->wrap[0] == ZT_WRAP_REPEAT;
    how.repeat_y = s->texture->wrap[1] == ZT_WRAP_REPEAT;
    how.truth = truth;
    how.background = background;
    how.level_count = s->level_count;
    how.seed = s->texture->umbrellas->seed;
    return make_author_status(author_umbrella_levels(run, &s->umbrellas, &how, reports), run);
}

static int look(storing *s, author_run *run, author_picture *truth, author_picture *background) {
    bytes m = {0};
    zt_file *file = NULL;
    uint32_t textures[2], first = s->level_count > 1, x = s->umbrellas.info.grid_x, y = s->umbrellas.info.grid_y;
    uint32_t fine = first ? UMBRELLAS_FINE : UMBRELLAS_PIXELS;
    umbrellas_view view = {fine * cells_at(x, first), fine * cells_at(y, first), first ? SAMPLES : MEAN_SAMPLES, NULL,
                           0};
    int status = check_memory(s, view.width, view.height);
    if (status == CMD_OK)
        status = open_memory(s, &m, textures, &file);
    if (status == CMD_OK)
        status = umbrellas_look(run, file, textures[0], &view, truth);
    for (uint32_t l = 1; status == CMD_OK && l < s->level_count; l++) {
        double step[2];
        umbrellas_step(x, y, l, step);
        view = (umbrellas_view){UMBRELLAS_PHASES * cells_at(x, l), UMBRELLAS_PHASES * cells_at(y, l), 1, step, 1};
        status = umbrellas_look(run, file, textures[1], &view, &background[l - 1]);
    }
    zt_close(file);
    free(m.data);
    return status;
}

static int make_levels(storing *s, author_run *run) {
    author_picture truth = {0}, background[UMBRELLAS_LEVELS] = {{0}};
    author_level_report reports[UMBRELLAS_LEVELS] = {{0}};
    umbrellas_made *made = s->texture->umbrellas->made;
    zt_umbrella_info before = s->umbrellas.info;
    int status = look(s, run, &truth, background);
    if (status == CMD_OK)
        status = fit(s, run, &truth, background, reports);
    for (uint32_t l = 0; l < UMBRELLAS_LEVELS; l++)
        author_picture_release(&background[l]);
    for (uint32_t l = 1; status == CMD_OK && l < s->level_count; l++)
        cmd_verbose(s->store->args, "%s: level %u: %u umbrellas, longest list %u, %.2f dB, between pixels %.2f",
                    s->texture->name, l, reports[l - 1].umbrellas, reports[l - 1].longest, reports[l - 1].psnr,
                    reports[l - 1].between_psnr);
    if (status != CMD_OK || !made) {
        author_picture_release(&truth);
        return status;
    }
    *made = (umbrellas_made){.name = s->texture->name,
                             .grid_x = before.grid_x,
                             .grid_y = before.grid_y,
                             .bases = before.base_count,
                             .umbrellas = before.umbrella_count,
                             .vertices = before.base_vertex_count + before.explicit_vertex_count,
                             .longest = before.longest_list,
                             .entries = before.entry_count,
                             .level_count = s->level_count,
                             .repeat = {s->texture->wrap[0] == ZT_WRAP_REPEAT, s->texture->wrap[1] == ZT_WRAP_REPEAT},
                             .truth = truth};
    memcpy(made->levels, reports, sizeof reports);
    return CMD_OK;
}

/* ---- all together ------------------------------------------------------------------------------------------ */

static int arrange(storing *s, author_run *run) {
    const make_umbrellas *u = s->texture->umbrellas;
    author_arrangement how = u->arrangement;
    author_species *species = malloc(u->base_count * sizeof *species);
    if (!species)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    for (uint32_t i = 0; i < u->base_count; i++)
        species[i] = u->bases[i].species;
    how.species = species;
    how.species_count = u->base_count;
    how.seed = u->seed;
    author_result result = author_umbrella_arrange(run, s->bases, u->base_count, &how, &s->umbrellas);
    free(species);
    if (result == AUTHOR_BAD_INPUT)
        return make_complain(s->store->scene, s->texture->pointer, "%s", run->error);
    s->umbrellas.info.colour_mode = u->colour_mode;
    s->umbrellas.info.taper_start = (float)u->taper[0];
    s->umbrellas.info.taper_end = (float)u->taper[1];
    return make_author_status(result, run);
}

static void choose_levels(storing *s) {
    const zt_umbrella_info *info = &s->umbrellas.info;
    uint32_t longer = info->grid_x > info->grid_y ? info->grid_x : info->grid_y, most = 1;
    while (longer >> most)
        most++;
    uint32_t wanted = s->texture->umbrellas->level_count;
    s->level_count = wanted && wanted < most ? wanted : most;
}

int make_store_umbrellas(make_store *store, const make_texture *texture, make_size *sizes) {
    storing s = {.store = store, .texture = texture, .sizes = sizes};
    make_stages stages;
    author_run run = make_author_run(store->args, &stages);
    s.index = (uint32_t)(texture - store->scene->textures);
    int status = umbrellas_make_bases(store, texture, sizes, &run, &s.bases);
    if (status == CMD_OK)
        status = arrange(&s, &run);
    if (status == CMD_OK) {
        choose_levels(&s);
        status = make_levels(&s, &run);
    }
    if (status == CMD_OK)
        status = put_sources(&s, store);
    if (status == CMD_OK)
        status = put_texture(&s, store, texture->name, &s.umbrellas.info, NULL);
    make_stages_end(&stages);
    sizes[s.index] = (make_size){s.umbrellas.info.grid_x * UMBRELLAS_NOMINAL,
                                 s.umbrellas.info.grid_y * UMBRELLAS_NOMINAL};
    for (uint32_t i = 0; s.bases && i < texture->umbrellas->base_count; i++)
        author_base_release(&s.bases[i]);
    free(s.bases);
    author_umbrellas_release(&s.umbrellas);
    return status;
}

void umbrellas_made_release(umbrellas_made *made) {
    author_picture_release(&made->truth);
    *made = (umbrellas_made){0};
}
