/* SPDX-License-Identifier: Apache-2.0 */
/* ztex render: a texture as a sampler sees it, as pictures. */
#include "pick.h"
#include "render.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define BAND_BYTES (UINT64_C(16) << 20) /* of float pixels that are held at once */
#define LONGEST 4096                    /* pixels a side, when nobody gives a size */
#define LONGEST_FRAME 1024              /* of several pictures */
#define SCREEN_WIDTH 960                /* pixels of --3d, when nobody gives a size */
#define SCREEN_HEIGHT 540
#define FRAMES_MOST 100000
#define SHEET_GAP 4 /* pixels */

static const cmd_option options[] = {
    {.name = "output",
     .letter = 'o',
     .metavar = "PICTURE",
     .kind = CMD_FILE,
     .help = "Where the picture goes; the extension says its type. For several pictures without --sheet the name "
             "holds %04d or the like, which becomes the number, from 1 on."},
    {.name = "texture", .letter = 't', .metavar = "NAME|INDEX", .kind = CMD_TEXT, .help = "Texture; default: 0."},
    {.name = "layer",
     .letter = 'l',
     .metavar = "SEMANTIC|INDEX",
     .kind = CMD_TEXT,
     .help = "Layer of the texture: base_colour, normal, ...; default: the first."},
    {.name = "view",
     .metavar = "U0,V0,U1,V1",
     .kind = CMD_TEXT,
     .fallback = "0,0,1,1",
     .repeat = 1,
     .help = "Rectangle of texture coordinates that fills the picture; several give several "
             "pictures."},
    {.name = "zoom-path",
     .metavar = "FROM;TO",
     .kind = CMD_TEXT,
     .help = "Two rectangles as in --view: a series of pictures from one to the other, each enlarging by the same "
             "factor."},
    {.name = "frames",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .fallback = "8",
     .min = 1,
     .max = FRAMES_MOST,
     .help = "Number of pictures of --zoom-path, or of --play."},
    {.name = "play",
     .help = "The frames of an animation, one a picture, from --frame on and round again, along --zoom-path or in one "
             "--view."},
    {.name = "sheet",
     .metavar = "COLUMNS",
     .kind = CMD_INTEGER,
     .min = 1,
     .max = 1000,
     .help = "Several pictures on one sheet with so many columns."},
    {.name = "size",
     .letter = 's',
     .metavar = "WxH",
     .kind = CMD_TEXT,
     .help = "Pixels; 'W' or 'xH' alone gives square pixels. Default: a pixel a texel of the root, at most 4096 (or "
             "1024 for each of several pictures) a side."},
    {.name = "supersample",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .fallback = "1",
     .min = 1,
     .max = 16,
     .help = "N x N lookups a pixel."},
    {.name = "filter",
     .metavar = "FILTER",
     .kind = CMD_CHOICE,
     .choices = "trilinear|bilinear|nearest",
     .fallback = "trilinear",
     .help = "How texels are filtered."},
    {.name = "anisotropy",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .fallback = "1",
     .min = 1,
     .max = 16,
     .help = "Most probes a lookup, with the filter trilinear."},
    {.name = "root-only", .help = "Leave the patches of a zipmap out."},
    {.name = "frame",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .max = 65535,
     .help = "Frame of an animation, from 0 on (the same as --array-layer)."},
    {.name = "array-layer", .metavar = "N", .kind = CMD_INTEGER, .max = 65535, .help = "Array layer or cube face."},
    {.name = "slice", .metavar = "W", .kind = CMD_INTEGER, .max = 16383, .help = "Slice of a volume."},
    {.name = "light",
     .metavar = "X,Y,Z",
     .kind = CMD_TEXT,
     .fallback = "-0.15,-0.2,0.35",
     .help = "Of umbrellas: towards the light, in cells of the grid, x to the right, y down, z up. Shadows fall X, Y "
             "away; the direction is that of the shading of --3d."},
    {.name = "shadow",
     .metavar = "Q",
     .kind = CMD_REAL,
     .fallback = "0",
     .help = "Of umbrellas: how dark shadows are, from 0 to 1. Default with --3d: 0.3."},
    {.name = "3d",
     .help = "In perspective: the view is the ground, which a camera sees; umbrellas stand up from it as they are. "
             "Around it is the background."},
    {.name = "eye",
     .metavar = "X,Y,Z",
     .kind = CMD_TEXT,
     .help = "Of --3d: where the camera is, in widths of the view from its corner, x to the right, y down, z up. "
             "Default: above the near side."},
    {.name = "target", .metavar = "X,Y,Z", .kind = CMD_TEXT, .help = "Of --3d: where it looks. Default: the middle."},
    {.name = "up", .metavar = "X,Y,Z", .kind = CMD_TEXT, .help = "Of --3d: what is up in the picture. Default: z."},
    {.name = "fov",
     .metavar = "DEGREES",
     .kind = CMD_REAL,
     .help = "Of --3d: field of view of the picture's height. Default: 38."},
    {.name = "ambient",
     .metavar = "A",
     .kind = CMD_REAL,
     .fallback = "0.35",
     .help = "Of --3d: the share of light that comes from everywhere, from 0 to 1: 1 is without shading."},
    {.name = "background",
     .letter = 'b',
     .metavar = "R,G,B|checker",
     .kind = CMD_TEXT,
     .choices = "checker",
     .help = "What shows through transparent parts: an sRGB colour, each 0 to 255, or a checkerboard. Default: the "
             "picture keeps the alpha where its type can."},
    {.name = "exposure",
     .metavar = "EV",
     .kind = CMD_REAL,
     .fallback = "0",
     .help = "Multiply the light by 2 to this power."},
    {.name = "bits",
     .metavar = "BITS",
     .kind = CMD_CHOICE,
     .choices = "8|16|32",
     .help = "Bits a channel; default: 8, and 32 for exr and hdr (where 16 is half)."},
    {.name = "quality",
     .metavar = "Q",
     .kind = CMD_INTEGER,
     .fallback = "95",
     .min = 1,
     .max = 100,
     .help = "Of JPEG and WebP."},
    {0}};

static const cmd_example examples[] = {
    {"ztex render brick.ztex -o brick.png", "The whole texture, a pixel a texel."},
    {"ztex render face.ztex -o eye.png --view 0.4,0.3,0.5,0.4 --size 800", "A detail, 800 pixels wide."},
    {"ztex render face.ztex -o zoom%04d.png --zoom-path '0,0,1,1;0.44,0.34,0.46,0.36' --frames 120",
     "The frames of a film that zooms in."},
    {"ztex render leaves.ztex --3d -o leaves.png --view 0,0,0.25,0.4 --background 170,190,215 --supersample 3",
     "Umbrellas in perspective, a part of the texture as the ground."},
    {"ztex render walk.ztex -o film%04d.png --play --frames 48", "An animation, as pictures for a film."},
    {"ztex render face.ztex -o sheet.png --zoom-path '0,0,1,1;0.44,0.34,0.46,0.36' --frames 12 --sheet 4 --size 400",
     "The same on one sheet."},
    {0}};

typedef struct render_job {
    cmd_args *args;
    cmd_input input;
    uint32_t texture, layer;
    zt_image_info root;
    zt_sampler *sampler;
    render_style style;
    render_space space;
    render_view *views;
    uint32_t view_count;
    uint32_t columns; /* 0: each view has its own picture */
    int plays;        /* each view shows the frame behind that of the view before */
    int is_colour;
    uint32_t channels; /* of the pictures: 1, 3 or 4 */
    img_type type;
    cmd_progress progress;
    uint64_t rows_done, rows_total;
} render_job;

/* ---- the command line ---------------------------------------------------------------------------------- */

static int read_views(render_job *job) {
    const char *zoom = cmd_text(job->args, "zoom-path");
    render_view path[2];
    int given = cmd_given(job->args, "view");
    if (zoom && given)
        return cmd_usage(job->args, "--view and --zoom-path exclude each other");
    job->plays = cmd_given(job->args, "play") > 0;
    if (!zoom && !job->plays && cmd_given(job->args, "frames"))
        return cmd_usage(job->args, "--frames goes with --zoom-path or --play");
    if (job->plays && given > 1)
        return cmd_usage(job->args, "--play goes with one --view");
    if (zoom && render_path_parse(zoom, path))
        return cmd_usage(job->args, "--zoom-path '%s': two rectangles 'u0,v0,u1,v1;u0,v0,u1,v1' are wanted", zoom);
    job->view_count = zoom || job->plays ? (uint32_t)cmd_integer(job->args, "frames") : given ? (uint32_t)given : 1;
    job->views = calloc(job->view_count, sizeof *job->views);
    if (!job->views)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    for (uint32_t i = 0; i < job->view_count; i++) {
        const char *text = given > 1 ? cmd_text_at(job->args, "view", i) : cmd_text(job->args, "view");
        if (zoom)
            job->views[i] = render_path_at(path, job->view_count > 1 ? (double)i / (job->view_count - 1) : 0.0);
        else if (render_view_parse(text, &job->views[i], NULL))
            return cmd_usage(job->args, "--view '%s': four numbers u0,v0,u1,v1 of a rectangle are wanted", text);
    }
    return CMD_OK;
}

static int read_size(render_job *job) {
    const char *text = cmd_text(job->args, "size");
    render_style *style = &job->style;
    if (text && render_size_parse(text, &style->width, &style->height))
        return cmd_usage(job->args, "--size '%s': pixels are wanted, as in 800x600, 800 or x600", text);
    if (style->space) {
        const render_view screen = {0, 0, 1, 1};
        render_size_complete(&screen, SCREEN_WIDTH, SCREEN_HEIGHT, SCREEN_WIDTH, &style->width, &style->height);
        return CMD_OK;
    }
    render_size_complete(&job->views[0], job->root.width, job->root.height,
                         job->view_count > 1 ? LONGEST_FRAME : LONGEST, &style->width, &style->height);
    return CMD_OK;
}

static int read_background(render_job *job) {
    const char *text = cmd_text(job->args, "background");
    double rgb[3];
    if (!text || !job->is_colour)
        return CMD_OK;
    if (strcmp(text, "checker") == 0) {
        job->style.background = BACKGROUND_CHECKER;
        return CMD_OK;
    }
    if (pick_numbers(text, rgb, 3, NULL))
        return cmd_usage(job->args, "--background '%s': three numbers R,G,B from 0 to 255 or 'checker' are wanted",
                         text);
    job->style.background = BACKGROUND_PLAIN;
    for (int c = 0; c < 3; c++)
        job->style.plain[c] = zt_transfer_decode(ZT_TRANSFER_SRGB, (float)(rgb[c] / 255.0));
    return CMD_OK;
}

static int read_places(render_job *job) {
    uint64_t slice = cmd_integer(job->args, "slice"), layer = cmd_integer(job->args, "array-layer");
    if (cmd_given(job->args, "frame"))
        layer = cmd_integer(job->args, "frame");
    if (slice >= job->root.depth)
        return cmd_usage(job->args, "--slice %u: there are %u, from 0 on", (unsigned)slice, (unsigned)job->root.depth);
    if (layer >= job->root.layers)
        return cmd_usage(job->args, "--array-layer %u: there are %u, from 0 on", (unsigned)layer,
                         (unsigned)job->root.layers);
    job->style.w = ((double)slice + 0.5) / job->root.depth;
    job->style.array_layer = (uint32_t)layer;
    return CMD_OK;
}

/* Which channels, of which type, coded how. */
static int read_kind(render_job *job, const char *path) {
    const zt_format_info *format = zt_find_format(job->root.format);
    int linear = pick_is_linear(path), bits = cmd_choice(job->args, "bits");
    if (!linear && bits == 2)
        return cmd_usage(job->args, "32 bits are for the linear light of exr and hdr");
    if (linear && bits == 0)
        return cmd_usage(job->args, "pictures with linear light have 16 or 32 bits");
    job->type = linear ? (bits == 1 ? IMG_HALF : IMG_FLOAT) : bits == 1 ? IMG_U16 : IMG_U8;
    /* Data stay as they are: a roughness of 0.5 shall not become another number in the picture. */
    job->style.transfer = job->is_colour && !linear ? ZT_TRANSFER_SRGB : ZT_TRANSFER_LINEAR;
    job->style.gain = job->is_colour ? (float)exp2(cmd_real(job->args, "exposure")) : 1.0f;
    job->channels = format && format->channels == 1 ? 1 : 3;
    int alpha = job->root.alpha_mode != ZT_ALPHA_NONE || job->style.space;
    if (job->is_colour && alpha && job->style.background == BACKGROUND_NONE)
        job->channels = 4;
    if (job->style.background != BACKGROUND_NONE)
        job->channels = 3;
    job->style.straight = job->channels == 4 && !linear;
    return CMD_OK;
}

static int open_texture(render_job *job) {
    uint32_t semantic;
    int status = pick_texture(&job->input, cmd_text(job->args, "texture"), &job->texture);
    if (status == CMD_OK)
        status = pick_layer(&job->input, job->texture, cmd_text(job->args, "layer"), &job->layer);
    if (status != CMD_OK)
        return status;
    if (pick_image_of(job->input.file, job->texture, job->layer, NULL, &semantic, &job->root) != 0)
        return cmd_fail(CMD_INTERNAL, "%s: the texture has no image", job->input.name);
    /* A first layer of no declared meaning is shown as the picture that it probably is. */
    job->is_colour = pick_is_colour(semantic);
    zt_sampler_options how = {.size = sizeof how,
                              .filter = (zt_filter)cmd_choice(job->args, "filter"),
                              .max_anisotropy = (uint32_t)cmd_integer(job->args, "anisotropy"),
                              .layer = job->layer,
                              .first_patch_only = cmd_given(job->args, "root-only") != 0};
    zt_diag diag = {.offset = UINT64_MAX};
    if (how.max_anisotropy > 1 && how.filter != ZT_FILTER_TRILINEAR)
        return cmd_usage(job->args, "--anisotropy goes with the filter trilinear");
    status = render_space_read(job->args, job->input.file, job->texture, &job->root, &job->space);
    if (status == CMD_OK)
        status = render_light_read(job->args, &how, &job->space);
    if (status != CMD_OK)
        return status;
    job->style.space = cmd_given(job->args, "3d") ? &job->space : NULL;
    zt_result result = zt_sampler_open(job->input.file, job->texture, &how, &diag, &job->sampler);
    return result == ZT_OK ? CMD_OK : cmd_fail_result(job->input.name, result, &diag);
}

/* ---- pictures ------------------------------------------------------------------------------------------ */

typedef struct sheet {
    const char *path;
    const render_view *views;
    uint32_t count, columns, gap;
    uint32_t width;
    float *rgba;
    unsigned char *packed;
    img_writer *writer;
} sheet;

static img_writer *create_picture(render_job *job, const sheet *s, uint32_t height, char *error) {
    img_text texts[PICK_TEXTS];
    img_create_options how = {.width = s->width,
                              .height = height,
                              .channels = job->channels,
                              .type = job->type,
                              .alpha = job->channels < 4     ? IMG_ALPHA_NONE
                                       : job->style.straight ? IMG_ALPHA_STRAIGHT
                                                             : IMG_ALPHA_PREMULTIPLIED,
                              .transfer = (uint8_t)job->style.transfer,
                              .quality = (int)cmd_integer(job->args, "quality"),
                              .texts = texts};
    how.text_count = pick_texts(job->input.file, texts);
    how.primaries = job->root.primaries;
    img_writer *writer = img_create(s->path, &how, error);
    if (writer || job->channels < 4)
        return writer;
    /* A type without alpha: as on a black background. */
    job->channels = how.channels = 3;
    job->style.straight = 0;
    how.alpha = IMG_ALPHA_NONE;
    return img_create(s->path, &how, error);
}

static zt_result render_band(render_job *job, const sheet *s, uint32_t sheet_row, uint32_t y, uint32_t count,
                             zt_diag *diag) {
    size_t pitch = 4 * (size_t)s->width;
    /* White between the pictures, and where the last row is not full. */
    for (size_t i = 0; s->columns > 1 && i < pitch * count; i++)
        s->rgba[i] = 1.0f;
    for (uint32_t c = 0; c < s->columns && sheet_row * s->columns + c < s->count; c++) {
        float *at = s->rgba + 4 * (size_t)c * (job->style.width + s->gap);
        const render_view *view = &s->views[sheet_row * s->columns + c];
        render_style style = job->style;
        if (job->plays)
            style.array_layer = (uint32_t)((style.array_layer + (uint64_t)(view - job->views)) % job->root.layers);
        zt_result result = render_rows(job->sampler, &style, view, y, count, at, pitch, cmd_parallel(job->args), diag);
        if (result != ZT_OK)
            return result;
    }
    return ZT_OK;
}

/* Rounds to integers here and not in the picture library: nearest, as the texture's own formats do. */
static int write_band(const render_job *job, const sheet *s, uint32_t count, char *error) {
    static const uint32_t formats[2][5] = {{0, 9, 0, 23, 37}, {0, 70, 0, 84, 91}};
    size_t pixels = (size_t)s->width * count;
    img_type type = job->type;
    if (type == IMG_U8 || type == IMG_U16) {
        if (zt_pack_texels(formats[type == IMG_U16][job->channels], s->rgba, pixels, s->packed) != ZT_OK) {
            snprintf(error, IMG_ERROR, "pixels cannot be packed");
            return -1;
        }
        return img_write_rows(s->writer, count, type, s->packed, 0, error);
    }
    for (size_t i = 0; job->channels < 4 && i < pixels; i++)
        memmove(s->rgba + i * job->channels, s->rgba + 4 * i, job->channels * sizeof *s->rgba);
    return img_write_rows(s->writer, count, IMG_FLOAT, s->rgba, 0, error);
}

static int write_gap(const render_job *job, const sheet *s, char *error) {
    for (size_t i = 0; i < 4 * (size_t)s->width * s->gap; i++)
        s->rgba[i] = 1.0f;
    return write_band(job, s, s->gap, error);
}

static int write_sheet_row(render_job *job, const sheet *s, uint32_t sheet_row, uint32_t band) {
    char error[IMG_ERROR];
    uint32_t height = job->style.height;
    if (sheet_row > 0 && s->gap > 0 && write_gap(job, s, error))
        return cmd_fail(CMD_IO, "%s: %s", s->path, error);
    for (uint32_t y = 0; y < height; y += band) {
        uint32_t count = height - y < band ? height - y : band;
        zt_diag diag = {.offset = UINT64_MAX};
        zt_result result = render_band(job, s, sheet_row, y, count, &diag);
        if (result != ZT_OK)
            return cmd_fail_result(job->input.name, result, &diag);
        if (write_band(job, s, count, error))
            return cmd_fail(CMD_IO, "%s: %s", s->path, error);
        job->rows_done += count;
        if (cmd_progress_step(&job->progress, (double)job->rows_done / (double)job->rows_total))
            return cmd_cancelled();
    }
    return CMD_OK;
}

static int write_sheet(render_job *job, sheet *s) {
    char error[IMG_ERROR];
    uint32_t rows = (s->count + s->columns - 1) / s->columns;
    uint64_t width = (uint64_t)s->columns * job->style.width + (uint64_t)(s->columns - 1) * s->gap;
    uint64_t height = (uint64_t)rows * job->style.height + (uint64_t)(rows - 1) * s->gap;
    if (width > INT32_MAX || height > INT32_MAX)
        return cmd_fail(CMD_USAGE, "%s: the sheet would be too large", s->path);
    s->width = (uint32_t)width;
    uint64_t fit = BAND_BYTES / (width * 4 * sizeof(float));
    uint32_t band = fit < SHEET_GAP ? SHEET_GAP : fit > 256 ? 256 : (uint32_t)fit;
    s->rgba = malloc((size_t)(band * width) * 4 * sizeof(float));
    s->packed = malloc((size_t)(band * width) * 8);
    int status = CMD_OK;
    if (!s->rgba || !s->packed)
        status = cmd_fail(CMD_INTERNAL, "%s: out of memory", s->path);
    if (status == CMD_OK) {
        s->writer = create_picture(job, s, (uint32_t)height, error);
        if (!s->writer)
            status = cmd_fail(CMD_IO, "%s: %s", s->path, error);
    }
    for (uint32_t row = 0; status == CMD_OK && row < rows; row++)
        status = write_sheet_row(job, s, row, band);
    if (status != CMD_OK)
        img_discard(s->writer);
    else if (img_finish(s->writer, error))
        status = cmd_fail(CMD_IO, "%s: %s", s->path, error);
    free(s->rgba);
    free(s->packed);
    return status;
}

/* The name with its %d or %04d replaced; malloc'd. NULL when there is not exactly one such place. */
static char *numbered(const char *pattern, uint32_t number) {
    const char *percent = strchr(pattern, '%');
    if (!percent || strchr(percent + 1, '%'))
        return NULL;
    int digits = 0;
    const char *end = percent + 1;
    for (; *end >= '0' && *end <= '9' && digits < 10; end++)
        digits = 10 * digits + (*end - '0');
    if (*end != 'd' || digits > 9)
        return NULL;
    size_t size = strlen(pattern) + 16;
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s%0*u%s", (int)(percent - pattern), pattern, digits, (unsigned)number, end + 1);
    return name;
}

static int render_pictures(render_job *job, const char *path) {
    int status = CMD_OK;
    cmd_progress_begin(&job->progress, job->args, "rendering");
    uint32_t per_row = job->columns ? job->columns : 1;
    job->rows_total = (uint64_t)job->style.height * ((job->view_count + per_row - 1) / per_row);
    if (job->columns || job->view_count == 1) {
        uint32_t columns = job->columns ? job->columns : 1;
        sheet s = {.path = path, .views = job->views, .count = job->view_count, .columns = columns};
        s.columns = columns < job->view_count ? columns : job->view_count;
        s.gap = job->view_count > 1 ? SHEET_GAP : 0;
        status = write_sheet(job, &s);
    }
    for (uint32_t i = 0; !job->columns && job->view_count > 1 && status == CMD_OK && i < job->view_count; i++) {
        char *name = numbered(path, i + 1);
        sheet s = {.path = name, .views = &job->views[i], .count = 1, .columns = 1};
        if (!name)
            status = cmd_fail(CMD_INTERNAL, "out of memory");
        else
            status = write_sheet(job, &s);
        free(name);
    }
    cmd_progress_end(&job->progress);
    return status;
}

static int check_output(const render_job *job, const char *path) {
    if (!path)
        return cmd_usage(job->args, "where to? Give the picture's name with --output");
    if (strcmp(path, "-") == 0)
        return cmd_usage(job->args, "a picture needs a name: its extension says the type");
    if (!job->columns && job->view_count > 1) {
        char *name = numbered(path, 1);
        free(name);
        if (!name)
            return cmd_usage(job->args, "%u pictures need a name with one %%04d, or --sheet COLUMNS",
                             (unsigned)job->view_count);
    }
    return cmd_check_output(path, job->args->operands, 1);
}

/* Every view has a camera. */
static int check_scenes(const render_job *job) {
    for (uint32_t i = 0; job->style.space && i < job->view_count; i++) {
        render_scene scene;
        const char *wrong = render_scene_open(&job->style, &job->views[i], &scene);
        if (wrong)
            return cmd_usage(job->args, "--3d: %s", wrong);
    }
    return CMD_OK;
}

static int prepare(render_job *job, const char *path) {
    int status = read_views(job);
    job->columns = (uint32_t)cmd_integer(job->args, "sheet");
    job->style.supersample = (uint32_t)cmd_integer(job->args, "supersample");
    if (status == CMD_OK)
        status = check_output(job, path);
    if (status == CMD_OK)
        status = cmd_open(job->args, job->args->operands[0], 0, &job->input);
    if (status == CMD_OK)
        status = open_texture(job);
    if (status == CMD_OK)
        status = read_size(job);
    if (status == CMD_OK)
        status = check_scenes(job);
    if (status == CMD_OK)
        status = read_places(job);
    if (status == CMD_OK)
        status = read_background(job);
    return status == CMD_OK ? read_kind(job, path) : status;
}

static int run(cmd_args *args) {
    render_job job = {.args = args};
    const char *path = cmd_text(args, "output");
    int status = prepare(&job, path);
    if (status == CMD_OK)
        status = render_pictures(&job, path);
    zt_sampler_close(job.sampler);
    cmd_close(&job.input);
    free(job.views);
    return status;
}

const cmd_verb verb_render = {
    .name = "render",
    .summary = "Draw a texture, or a part of it, as a picture",
    .synopsis = "[OPTION]... FILE -o PICTURE",
    .text = "Looks the texture up as a renderer would, with its patches, mip levels and filter, and writes a picture: "
            "png, jpg and others with 8 or 16 bits in sRGB, exr and hdr with linear light. Layers that are not "
            "colours keep their numbers.\n\n"
            "With --3d the picture shows the rectangle in perspective, and nothing around it.\n\n"
            "Rectangles are in texture coordinates of the root: 0 to 1, u to the right, v down. Beyond that the "
            "texture goes on as its wrap modes say.",
    .options = options,
    .examples = examples,
    .operand = CMD_TEXTURE,
    .min_operands = 1,
    .max_operands = 1,
    .common = CMD_WITH_THREADS | CMD_WITH_MEMORY,
    .run = run,
};
