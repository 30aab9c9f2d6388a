/* SPDX-License-Identifier: Apache-2.0 */
/* What a silmap is fitted to: a drawing at 16 texels a cell or so, the outline of glyphs, or a picture as it is; and an
 * artist's edges. */
#include "silmap.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "drawing.h"
#include "make_author.h"

#define CELL_TEXELS 16      /* of a drawing, along a side */
#define CELL_TEXELS_LEAST 4 /* when there are many cells */
#define LONGER_TEXELS 4096  /* beyond which cells get fewer texels */
#define FREE_TEXELS 1024    /* the same where quality is wanted, which takes several tries */
#define FREE_MARGIN 64      /* of glyphs then: this part of their longer side */
#define FLAT_PIECES 64      /* of a cell: how far a curve may be off */
#define SHAPE_PIECES 512    /* the same where it is all that is known */
#define MOST_CROSSINGS 8e6  /* of lines with rows of pixels, before drawing them is left to librsvg */
#define RATIO_OFF 0.01      /* of edges and picture, before somebody should know */
#define MOST_CHARACTERS 1024
#define OPAQUE 254 /* of 255: clips that end with the page round */

typedef struct loading {
    make_store *store;
    const make_texture *texture;
    const make_silmap *silmap;
    const make_image *image;
    uint32_t semantic;
    int animated;   /* the picture is one of several */
    int keep_alpha; /* where it is opaque, too */
    int exact;      /* a flat drawing as paths */
    const vector_module *vector;
    silmap_source *out;
    char error[DRAWING_ERROR];
} loading;

static int fail(const loading *l, const char *path) {
    return make_fail_picture(l->store, l->image, path, l->error);
}

/* Values as they are, or colours? */
static int is_plain(const loading *l) {
    return l->silmap->mask != SILMAP_COLOURS || !make_is_colour(l->semantic);
}

/* ---- cells -------------------------------------------------------------------------------------------------- */

int silmap_parse_cells(const char *text, make_silmap *silmap) {
    unsigned long values[2] = {0, 0};
    int count = 0;
    char *end = NULL;
    for (; count < 2 && *text >= '0' && *text <= '9'; count++) {
        values[count] = strtoul(text, &end, 10);
        if (values[count] == 0 || values[count] > SILMAP_CELLS_MOST)
            return -1;
        text = *end == 'x' && count == 0 ? end + 1 : end;
    }
    if (count == 0 || *text || end != text)
        return -1;
    silmap->longer = count == 1 ? (uint32_t)values[0] : 0;
    silmap->cells_x = count == 2 ? (uint32_t)values[0] : 0;
    silmap->cells_y = count == 2 ? (uint32_t)values[1] : 0;
    return 0;
}

/* Cells along the longer side; 0: quality will say. */
static uint32_t longer_cells(const make_silmap *silmap) {
    if (silmap->cells_x)
        return silmap->cells_x > silmap->cells_y ? silmap->cells_x : silmap->cells_y;
    return silmap->longer || silmap->quality > 0 ? silmap->longer : SILMAP_CELLS;
}

static void choose_cells(const make_silmap *silmap, double width, double height, silmap_source *out) {
    double longer = longer_cells(silmap), ratio = width < height ? width / height : height / width;
    uint32_t shorter = (uint32_t)fmax(floor(longer * ratio + 0.5), 1);
    out->cells_x = longer > 0 ? (width < height ? shorter : (uint32_t)longer) : 0;
    out->cells_y = longer > 0 ? (width < height ? (uint32_t)longer : shorter) : 0;
    if (silmap->cells_x) {
        out->cells_x = silmap->cells_x;
        out->cells_y = silmap->cells_y;
    }
}

/* pieces: of a cell. */
static double flatness(const silmap_source *source, int pieces) {
    uint32_t longer = source->cells_x > source->cells_y ? source->cells_x : source->cells_y;
    return 1.0 / ((double)pieces * (longer ? longer : FREE_TEXELS / 2));
}

/* Pixels to draw into: whole ones a cell, or many when the cells are not known. */
static int choose_pixels(const loading *l, double ratio, uint32_t *width, uint32_t *height) {
    uint32_t x = l->out->cells_x, y = l->out->cells_y, longer = x > y ? x : y;
    uint32_t texels = longer ? (l->silmap->quality > 0 ? FREE_TEXELS : LONGER_TEXELS) / longer : 0;
    texels = texels > CELL_TEXELS ? CELL_TEXELS : texels < CELL_TEXELS_LEAST ? CELL_TEXELS_LEAST : texels;
    if (longer > VECTOR_SIDE / CELL_TEXELS_LEAST)
        return make_complain(l->store->scene, l->texture->pointer,
                             "%u x %u cells are too many: a drawing has at most %d along a side", (unsigned)x,
                             (unsigned)y, VECTOR_SIDE / CELL_TEXELS_LEAST);
    *width = longer ? x * texels : (uint32_t)fmax(1, FREE_TEXELS * fmin(1, ratio));
    *height = longer ? y * texels : (uint32_t)fmax(1, FREE_TEXELS * fmin(1, 1 / ratio));
    uint64_t memory = cmd_limits(l->store->args)->memory ? cmd_limits(l->store->args)->memory : UINT64_C(1) << 30;
    char text[32];
    if ((uint64_t)*width * *height > memory / (4 * sizeof(float)))
        return cmd_fail(CMD_LIMIT, "%s: %u x %u cells need more memory than %s: see --memory", l->image->files[0].path,
                        (unsigned)x, (unsigned)y, cmd_bytes_text(text, sizeof text, memory));
    return CMD_OK;
}

static int create(loading *l, uint32_t width, uint32_t height, uint32_t channels) {
    author_run run = {0};
    if (author_picture_create(&run, width, height, channels, &l->out->picture) == AUTHOR_OK)
        return CMD_OK;
    return cmd_fail(CMD_INTERNAL, "%s: out of memory", l->image->files[0].path);
}

/* ---- hinting ------------------------------------------------------------------------------------------------ */

static int check_hint(const loading *l) {
    const char *path = l->image->files[0].path, *why = NULL;
    if (!l->silmap->text && !drawing_is_one(path))
        why = "it moves drawings and glyphs, and this is a picture";
    else if (l->silmap->quality > 0)
        why = "it needs a number of cells, and a quality says something else";
    else if (l->animated)
        why = "frames would move against each other";
    else if (l->texture->wrap[0] == ZT_WRAP_REPEAT || l->texture->wrap[1] == ZT_WRAP_REPEAT)
        why = "it moves the sides of a drawing, which have to meet where the texture repeats";
    if (!why || !l->silmap->hint)
        return CMD_OK;
    return make_complain(l->store->scene, l->texture->pointer, "%s cannot be hinted: %s", path, why);
}

/* ---- drawings ----------------------------------------------------------------------------------------------- */

static float brightness(const float rgb[3]) {
    return 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
}

/* The first channels of each texel, or one value made of all of them; in place. */
static void narrow(author_picture *picture, uint32_t channels, silmap_mask mask) {
    size_t count = (size_t)picture->width * picture->height;
    uint32_t from = picture->channels;
    for (size_t i = 0; i < count; i++) {
        const float *texel = picture->texels + i * from;
        float value = mask == SILMAP_ALPHA || from < 3 ? texel[mask == SILMAP_ALPHA ? from - 1 : 0] : brightness(texel);
        if (mask == SILMAP_BRIGHTNESS && (from == 2 || from == 4))
            value *= texel[from - 1];
        memmove(picture->texels + i * channels, texel, channels * sizeof *texel);
        if (mask != SILMAP_COLOURS)
            picture->texels[i] = value;
    }
    picture->channels = channels;
}

/* One pixel, premultiplied and coded, as the fit wants it. */
static void take_pixel(const loading *l, const uint8_t rgba[4], const float light[256], float *to) {
    uint32_t channels = l->out->picture.channels;
    float alpha = (float)rgba[3] / 255.0f;
    float coded[3] = {(float)rgba[0] / 255.0f, (float)rgba[1] / 255.0f, (float)rgba[2] / 255.0f};
    if (l->silmap->mask != SILMAP_COLOURS) {
        to[0] = l->silmap->mask == SILMAP_ALPHA ? alpha : brightness(coded);
        return;
    }
    for (int c = 0; c < 3; c++) {
        float value = rgba[3] > 0 ? fminf(coded[c] / alpha, 1.0f) : 0.0f;
        to[c] = l->out->plain ? value : rgba[3] == 255 ? light[rgba[c]] : zt_transfer_decode(ZT_TRANSFER_SRGB, value);
    }
    if (channels == 4)
        to[3] = alpha;
}

/* A mask of alpha, if all of the drawing is opaque. */
static int is_no_mask(const loading *l) {
    return l->silmap->mask == SILMAP_ALPHA && !l->animated && !author_silmap_is_moved(&l->out->place);
}

static int complain_opaque(const loading *l) {
    return make_complain(l->store->scene, l->texture->pointer,
                         "%s is opaque all over: a mask of its alpha would be white. Its brightness may be meant",
                         l->image->files[0].path);
}

static int take_pixels(loading *l, const uint8_t *rgba, uint32_t width, uint32_t height) {
    size_t count = (size_t)width * height, clear = 0;
    float light[256];
    for (int i = 0; i < 256; i++)
        light[i] = zt_transfer_decode(ZT_TRANSFER_SRGB, (float)i / 255.0f);
    for (size_t i = 0; i < count; i++)
        clear += rgba[4 * i + 3] < OPAQUE;
    int alpha = (clear || l->keep_alpha) && make_is_colour(l->semantic);
    uint32_t channels = l->silmap->mask != SILMAP_COLOURS ? 1 : alpha ? 4 : 3;
    if (!clear && is_no_mask(l))
        return complain_opaque(l);
    int status = create(l, width, height, channels);
    for (size_t i = 0; status == CMD_OK && i < count; i++)
        take_pixel(l, rgba + 4 * i, light, l->out->picture.texels + i * channels);
    return status;
}

static int open_drawing(loading *l, const char *path, int edges, vector_drawing **out) {
    int status = drawing_open(l->store->args, path, edges, &l->vector, out, l->error);
    return status == CMD_INVALID ? fail(l, path) : status;
}

static int draw(loading *l, const vector_drawing *drawing, uint32_t width, uint32_t height) {
    const char *path = l->image->files[0].path;
    uint8_t *rgba = malloc((size_t)width * height * 4);
    int status = rgba ? CMD_OK : cmd_fail(CMD_INTERNAL, "%s: out of memory", path);
    if (status == CMD_OK && l->vector->drawing_render(drawing, width, height, rgba, l->error))
        status = fail(l, path);
    if (status == CMD_OK)
        status = take_pixels(l, rgba, width, height);
    free(rgba);
    return status;
}

/* Of the picture's channels, for the fit. */
static void take_colour(const loading *l, author_silmap_shape *shape) {
    float coded[3] = {shape->colour[0], shape->colour[1], shape->colour[2]};
    if (l->silmap->mask != SILMAP_COLOURS)
        shape->colour[0] = l->silmap->mask == SILMAP_ALPHA ? 1.0f : brightness(coded);
    for (int c = 0; c < 3 && l->silmap->mask == SILMAP_COLOURS && !l->out->plain; c++)
        shape->colour[c] = zt_transfer_decode(ZT_TRANSFER_SRGB, coded[c]);
}

static int has_clear(const author_picture *picture) {
    size_t count = (size_t)picture->width * picture->height * picture->channels;
    for (size_t i = picture->channels - 1; i < count; i += picture->channels)
        if (picture->texels[i] < OPAQUE / 255.0f)
            return 1;
    return 0;
}

static int draw_shapes(loading *l, uint32_t width, uint32_t height, uint32_t channels) {
    silmap_source *out = l->out;
    author_silmap_input input = {
        .paths = out->paths, .path_count = out->path_count, .shapes = out->shapes, .shape_count = out->shape_count};
    make_stages stages;
    int status = create(l, width, height, channels);
    if (status != CMD_OK)
        return status;
    author_run run = make_author_run(l->store->args, &stages);
    author_result result = author_silmap_draw(&run, &input, out->plain, &out->picture);
    make_stages_end(&stages);
    return make_author_status(result, &run);
}

/* Whether the fit can take the picture of the shapes, without its alpha where that is not wanted. */
static int settle_alpha(loading *l, int *flat) {
    author_picture *picture = &l->out->picture;
    int clear = has_clear(picture), colour = make_is_colour(l->semantic);
    *flat = 1;
    if (!clear && is_no_mask(l))
        return complain_opaque(l);
    if (l->silmap->mask != SILMAP_COLOURS || (colour && (clear || l->keep_alpha)))
        return CMD_OK;
    if (clear)
        author_picture_release(picture);
    else
        narrow(picture, 3, SILMAP_COLOURS);
    *flat = !clear;
    return CMD_OK;
}

static void keep_shapes(silmap_source *source, const vector_shapes *shapes) {
    source->paths = shapes->paths.paths;
    source->points = shapes->paths.points;
    source->path_count = shapes->paths.count;
    source->shapes = shapes->shapes;
    source->shape_count = shapes->count;
}

static void drop_shapes(silmap_source *source) {
    static const vector_shapes none = {0};
    free(source->paths);
    free(source->points);
    free(source->shapes);
    keep_shapes(source, &none);
}

static double count_crossings(const vector_paths *all, uint32_t rows) {
    double count = 0;
    for (size_t p = 0; p < all->count; p++) {
        const author_path *path = &all->paths[p];
        for (size_t i = 0; i < path->count; i++) {
            double y = path->points[2 * i + 1], next = path->points[2 * ((i + 1) % path->count) + 1];
            count += fabs(fmin(fmax(next, 0), 1) - fmin(fmax(y, 0), 1)) * rows;
        }
    }
    return count;
}

/* Takes the drawing as flat shapes, exactly, if it is such a one; *flat 0, and out->not_flat says why: it is not. */
static int load_shapes(loading *l, const vector_drawing *drawing, uint32_t width, uint32_t height, int *flat) {
    silmap_source *out = l->out;
    vector_shapes shapes;
    *flat = 0;
    /* What cannot be drawn at all fails once more when it is drawn as a picture. */
    if (l->vector->drawing_shapes(drawing, flatness(out, SHAPE_PIECES), &shapes, l->error)) {
        snprintf(out->not_flat, sizeof out->not_flat, "%s", l->error);
        return CMD_OK;
    }
    keep_shapes(out, &shapes);
    if (count_crossings(&shapes.paths, height) > MOST_CROSSINGS) {
        drop_shapes(out);
        snprintf(out->not_flat, sizeof out->not_flat, "its lines are too many for %u rows", (unsigned)height);
        return CMD_OK;
    }
    for (size_t i = 0; i < out->shape_count; i++)
        take_colour(l, &out->shapes[i]);
    int status = draw_shapes(l, width, height, l->silmap->mask == SILMAP_COLOURS ? 4 : 1);
    if (status == CMD_OK)
        status = settle_alpha(l, flat);
    if (status == CMD_OK && !*flat) {
        drop_shapes(out);
        snprintf(out->not_flat, sizeof out->not_flat, "its values would be mixed with what is transparent");
    }
    return status;
}

static int draw_any(loading *l, const vector_drawing *drawing) {
    double w, h;
    uint32_t width = 0, height = 0;
    int flat = 0;
    l->vector->drawing_size(drawing, &w, &h);
    int status = choose_pixels(l, w / h, &width, &height);
    if (status == CMD_OK && l->exact)
        status = load_shapes(l, drawing, width, height, &flat);
    if (status != CMD_OK || flat)
        return status;
    if (l->exact)
        cmd_verbose(l->store->args, "%s: drawn supersampled, %u x %u pixels, since %s", l->image->files[0].path,
                    (unsigned)width, (unsigned)height, l->out->not_flat);
    return draw(l, drawing, width, height);
}

static int load_drawing(loading *l) {
    vector_drawing *drawing;
    double w, h;
    int status = open_drawing(l, l->image->files[0].path, 0, &drawing);
    if (status != CMD_OK)
        return status;
    l->vector->drawing_size(drawing, &w, &h);
    if (l->out->cells_x == 0)
        choose_cells(l->silmap, w, h, l->out);
    l->vector->drawing_place(drawing, &l->out->place);
    status = draw_any(l, drawing);
    l->vector->drawing_close(drawing);
    return status;
}

/* ---- glyphs -------------------------------------------------------------------------------------------------- */

static int read_characters(const loading *l, uint32_t *characters, size_t *count) {
    *count = 0;
    for (const char *at = l->silmap->text; *at;) {
        size_t used = cmd_utf8(at, &characters[*count]);
        if (used == 0 || ++*count == MOST_CHARACTERS)
            return make_complain(l->store->scene, l->texture->pointer, "the text is %s",
                                 used ? "too long" : "no valid UTF-8");
        at += used;
    }
    return CMD_OK;
}

/* A cell of background around the ink. */
static void choose_margins(const loading *l, double width, double height, double margin[2]) {
    double longer = width > height ? width : height;
    uint32_t cells = longer_cells(l->silmap);
    double cell = cells > 8 ? longer / (cells - 2) : longer / (cells ? 8 : FREE_MARGIN);
    choose_cells(l->silmap, width + 2 * cell, height + 2 * cell, l->out);
    margin[0] = cell / (width + 2 * cell);
    margin[1] = cell / (height + 2 * cell);
}

static int outline_text(loading *l, const vector_text *text) {
    double w, h, margin[2];
    uint32_t width, height;
    vector_shapes shapes = {.count = 1};
    l->vector->text_size(text, &w, &h);
    choose_margins(l, w, h, margin);
    const author_silmap_place *place = &l->out->place;
    author_silmap_place box = {place->x + place->width * margin[0], place->y + place->height * margin[1],
                               place->width * (1 - 2 * margin[0]), place->height * (1 - 2 * margin[1])};
    l->out->plain = 1;
    int status = choose_pixels(l, w / h, &width, &height);
    if (status != CMD_OK)
        return status;
    if (l->vector->text_paths(text, &box, flatness(l->out, SHAPE_PIECES), &shapes.paths, l->error))
        return fail(l, l->image->files[0].path);
    shapes.shapes = calloc(1, sizeof *shapes.shapes);
    keep_shapes(l->out, &shapes);
    if (!shapes.shapes)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    *shapes.shapes = (author_silmap_shape){.count = shapes.paths.count, .colour = {1}, .opacity = 1};
    return draw_shapes(l, width, height, 1);
}

static int load_text(loading *l) {
    const char *path = l->image->files[0].path;
    uint32_t characters[MOST_CHARACTERS];
    size_t count, size = 0;
    void *font = NULL;
    vector_text *text = NULL;
    l->vector = drawing_module();
    int status = l->vector ? CMD_OK : CMD_IO;
    if (status == CMD_OK)
        status = read_characters(l, characters, &count);
    if (status == CMD_OK)
        status = cmd_read_all(l->store->args, path, 0, &font, &size);
    if (status == CMD_OK && l->vector->text_open(font, size, characters, count, &text, l->error))
        status = make_complain(l->store->scene, l->texture->pointer, "%s: %s", path, l->error);
    if (status == CMD_OK)
        status = outline_text(l, text);
    if (text)
        l->vector->text_close(text);
    free(font);
    return status;
}

/* ---- pictures ------------------------------------------------------------------------------------------------ */

static int is_opaque(const author_picture *picture) {
    size_t count = (size_t)picture->width * picture->height;
    for (size_t i = 0; i < count; i++)
        if (picture->texels[(i + 1) * picture->channels - 1] < 1.0f)
            return 0;
    return 1;
}

/* An alpha of 1 behind the other channels. */
static int add_alpha(loading *l) {
    author_picture opaque = l->out->picture;
    l->out->picture = (author_picture){0};
    int status = create(l, opaque.width, opaque.height, opaque.channels + 1);
    size_t count = status == CMD_OK ? (size_t)opaque.width * opaque.height : 0;
    float *to = l->out->picture.texels;
    for (size_t i = 0; i < count; i++, to += opaque.channels + 1) {
        memcpy(to, opaque.texels + i * opaque.channels, opaque.channels * sizeof *to);
        to[opaque.channels] = 1.0f;
    }
    author_picture_release(&opaque);
    return status;
}

static int load_picture(loading *l) {
    author_picture *picture = &l->out->picture;
    silmap_mask mask = l->silmap->mask;
    img_info info;
    /* Brightness is of values as they are coded. */
    uint32_t semantic = mask == SILMAP_BRIGHTNESS ? ZT_SEMANTIC_OPACITY : l->semantic;
    int status = make_load_picture(l->store, l->image, mask == SILMAP_ALPHA ? 0 : semantic, picture, &info);
    if (status != CMD_OK)
        return status;
    int has_alpha = info.alpha_channel >= 0 && picture->channels != 3 && picture->channels > 1;
    l->out->type = info.type;
    if (mask == SILMAP_ALPHA && !has_alpha)
        return make_complain(l->store->scene, l->texture->pointer,
                             "%s has no alpha to make a mask of. Its brightness may be meant", l->image->files[0].path);
    if (mask != SILMAP_COLOURS)
        narrow(picture, 1, mask);
    else if (has_alpha && !l->keep_alpha && make_is_colour(l->semantic) && is_opaque(picture))
        narrow(picture, picture->channels - 1, mask);
    else if (!has_alpha && l->keep_alpha && picture->channels % 2 == 1)
        status = add_alpha(l);
    if (l->out->cells_x == 0)
        choose_cells(l->silmap, picture->width, picture->height, l->out);
    return status;
}

/* ---- edges --------------------------------------------------------------------------------------------------- */

static int load_edges(loading *l) {
    const char *path = l->silmap->edges;
    vector_drawing *drawing;
    vector_paths paths = {0};
    double w, h;
    int status = open_drawing(l, path, 1, &drawing);
    if (status != CMD_OK)
        return status;
    drop_shapes(l->out);
    l->vector->drawing_size(drawing, &w, &h);
    double ratio = w / h / ((double)l->out->picture.width / l->out->picture.height);
    if (fabs(ratio - 1) > RATIO_OFF)
        cmd_warn(l->store->args, "%s is %g x %g, the picture %u x %u: its lines are stretched to fit", path, w, h,
                 (unsigned)l->out->picture.width, (unsigned)l->out->picture.height);
    l->vector->drawing_place(drawing, &l->out->place);
    if (l->vector->drawing_paths(drawing, flatness(l->out, FLAT_PIECES), &paths, l->error))
        status = fail(l, path);
    l->vector->drawing_close(drawing);
    if (status != CMD_OK)
        return status;
    /* Polygons alone would say what all regions are. Where edges of the picture count, too, a place without a line is
     * put among them. */
    author_path *all = realloc(paths.paths, (paths.count + 1) * sizeof *all);
    l->out->paths = all ? all : paths.paths;
    l->out->points = paths.points;
    l->out->path_count = paths.count;
    if (!all)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    if (paths.count == 0)
        return make_complain(l->store->scene, l->texture->pointer, "%s has no lines", path);
    if (!l->silmap->edges_only)
        all[l->out->path_count++] = (author_path){.points = paths.points, .count = 1};
    return CMD_OK;
}

/* ---- all together --------------------------------------------------------------------------------------------- */

static int load_any(loading *l) {
    cmd_verbose(l->store->args, "reading %s", l->image->files[0].path);
    l->out->type = IMG_U8;
    l->out->plain = is_plain(l);
    if (l->silmap->text)
        return load_text(l);
    return drawing_is_one(l->image->files[0].path) ? load_drawing(l) : load_picture(l);
}

static int load_at(make_store *store, const make_texture *texture, const silmap_pick *pick,
                   const author_silmap_place *place, silmap_source *out) {
    static const make_silmap colours = {0};
    const make_image *all = texture->images[pick->layer];
    make_image image = *all;
    image.files += pick->frame < all->file_count ? pick->frame : 0;
    image.file_count = 1;
    loading l = {.store = store,
                 .texture = texture,
                 .silmap = pick->layer ? &colours : texture->silmap,
                 .image = &image,
                 .semantic = texture->semantics[pick->layer],
                 .animated = all->file_count > 1,
                 .keep_alpha = pick->keep_alpha,
                 .exact = pick->layer == 0 && !texture->silmap->edges,
                 .out = out};
    *out = (silmap_source){.place = *place, .cells_x = pick->cells_x, .cells_y = pick->cells_y};
    int status = check_hint(&l);
    if (status == CMD_OK)
        status = load_any(&l);
    if (status == CMD_OK && l.silmap->edges)
        status = load_edges(&l);
    if (status != CMD_OK)
        silmap_source_release(out);
    return status;
}

int silmap_source_load(make_store *store, const make_texture *texture, const silmap_pick *pick, silmap_source *out) {
    return load_at(store, texture, pick, &(author_silmap_place){0, 0, 1, 1}, out);
}

int silmap_source_hint(make_store *store, const make_texture *texture, const silmap_source *from, silmap_source *out) {
    author_silmap_input input = {.picture = &from->picture,
                                 .paths = from->paths,
                                 .path_count = from->path_count,
                                 .shapes = from->shapes,
                                 .shape_count = from->shape_count};
    author_silmap_place place;
    make_stages stages;
    author_run run = make_author_run(store->args, &stages);
    *out = (silmap_source){0};
    author_result result = author_silmap_hint(&run, &input, from->cells_x, from->cells_y, from->plain, &place);
    make_stages_end(&stages);
    int status = make_author_status(result, &run);
    if (status != CMD_OK || !author_silmap_is_moved(&place))
        return status;
    return load_at(store, texture, &(silmap_pick){0}, &place, out);
}

void silmap_source_release(silmap_source *source) {
    author_picture_release(&source->picture);
    drop_shapes(source);
    *source = (silmap_source){0};
}
