/* SPDX-License-Identifier: Apache-2.0 */
/* ztex convert: a texture file into another one, touching no more than was asked for. */
#include "convert.h"
#include "pick.h"
#include "write_args.h"

#include <stdlib.h>
#include <string.h>

static const cmd_option options[] = {
    WRITE_OPTION_OUTPUT,
    {.name = "effort",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .min = 1,
     .max = 9,
     .help = "Compress anew with this effort: 1 is fast, 9 is small."},
    WRITE_OPTION_RAW,
    {.name = "tile-edge",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .min = 16,
     .max = 65536,
     .choices = "16|32|64|128|256|512|1024",
     .help = "Cut the levels into tiles of this edge, a power of two."},
    {.name = "format",
     .letter = 'f',
     .metavar = "FORMAT",
     .kind = CMD_FORMAT,
     .help = "Texel format of the colours (masks and data keep theirs), converted by way of linear light."},
    {.name = "layer",
     .metavar = "SEMANTIC",
     .kind = CMD_TEXT,
     .help = "Which layers --format is for: normal, roughness, ...; default: all colours."},
    {.name = "transfer",
     .metavar = "NAME",
     .kind = CMD_TEXT,
     .choices = "srgb|linear|bt709|gamma22|pq",
     .help = "Coding of the colours in --format. Default: srgb for SRGB formats, linear for floats, else as it is."},
    {.name = "levels",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .min = 1,
     .max = 32,
     .choices = "all|rebuild",
     .help =
         "Keep the first N mip levels; all: make those that are missing; rebuild: make all of them from the first."},
    {.name = "mip-filter",
     .metavar = "FILTER",
     .kind = CMD_CHOICE,
     .choices = "kaiser|mitchell|triangle|box",
     .help = "Make the levels anew with this filter; default: kaiser."},
    {.name = "keep-textures",
     .metavar = "NAME,...",
     .kind = CMD_TEXT,
     .repeat = 1,
     .help = "Keep only these textures, and those that their patches show. Images that nothing shows any more go."},
    {.name = "strip-patches", .help = "Keep only the roots of zipmaps: they become plain images."},
    {.name = "strip", .help = "Leave out the metadata and every chunk that is not needed to show the textures."},
    {.name = "meta",
     .letter = 'm',
     .metavar = "KEY=VALUE",
     .kind = CMD_TEXT,
     .repeat = 1,
     .help = "Set a metadata key."},
    {.name = "unmeta", .metavar = "KEY", .kind = CMD_TEXT, .repeat = 1, .help = "Remove a metadata key."},
    WRITE_OPTION_NO_FSYNC,
    {0}};

static const cmd_example examples[] = {
    {"ztex convert brick.ztex -o small.ztex --effort 9", "Compress as well as it goes."},
    {"ztex convert sky.ztex -o sky16.ztex --format R16G16B16A16_SFLOAT", "Colours as half floats, linear."},
    {"ztex convert all.ztex -o wall.ztex --keep-textures wall --strip", "One texture alone."},
    {"ztex convert wall.ztex -o new.ztex --meta zt.license=CC0-1.0", "Set the licence; texels stay bit for bit."},
    {0}};

/* ---- wishes ----------------------------------------------------------------------------------------------- */

static int read_format(convert_job *job) {
    const char *format = cmd_text(job->args, "format"), *layer = cmd_text(job->args, "layer");
    const char *transfer = cmd_text(job->args, "transfer");
    job->semantic = job->transfer = -1;
    if (!format)
        return layer || transfer ? cmd_usage(job->args, "--layer and --transfer go with --format") : CMD_OK;
    job->format = zt_find_format_name(format);
    if (!job->format || !job->format->is_plain) {
        cmd_error("--format %s: ztex does not compress texels into blocks", format);
        cmd_hint("'ztex help formats' lists the formats; those that are 'stored only' come from other programs.");
        return CMD_UNSUPPORTED;
    }
    if (layer && (job->semantic = cmd_semantic_number(layer)) < 0)
        return cmd_usage(job->args, "--layer: there is no semantic '%s'", layer);
    if (transfer && (job->transfer = cmd_transfer_number(transfer)) < 0)
        return cmd_usage(job->args, "--transfer: there is no '%s'", transfer);
    if (job->format->is_srgb && job->transfer >= 0 && job->transfer != ZT_TRANSFER_SRGB)
        return cmd_usage(job->args, "--transfer: %s is coded as sRGB", job->format->name);
    return CMD_OK;
}

static int read_wishes(convert_job *job) {
    cmd_args *args = job->args;
    const char *levels = cmd_text(args, "levels");
    int filter = cmd_choice(args, "mip-filter"), edge, status = write_read_tile_edge(args, &edge);
    if (status != CMD_OK)
        return status;
    job->tile_edge = (uint32_t)edge;
    job->recode = cmd_given(args, "effort") || cmd_given(args, "raw");
    if (cmd_given(args, "effort") && cmd_given(args, "raw"))
        return cmd_usage(args, "--effort and --raw exclude each other");
    job->all_levels = levels && strcmp(levels, "all") == 0;
    job->rebuild = filter >= 0 || (levels && strcmp(levels, "rebuild") == 0);
    job->levels = levels && levels[0] >= '0' && levels[0] <= '9' ? (uint32_t)cmd_integer(args, "levels") : 0;
    job->mip_filter = filter >= 0 ? (uint8_t)filter : 0;
    job->strip = cmd_given(args, "strip") != 0;
    job->strip_patches = cmd_given(args, "strip-patches") != 0;
    return read_format(job);
}

/* ---- which textures --------------------------------------------------------------------------------------- */

/* Names are divided by commas; a name that has one itself can be given by its index. */
static int keep_named(convert_job *job, const char *list) {
    size_t size = strlen(list) + 1;
    char *words = malloc(size), *rest = NULL;
    if (!words)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    memcpy(words, list, size);
    int status = CMD_OK;
    for (char *word = strtok_r(words, ",", &rest); status == CMD_OK && word; word = strtok_r(NULL, ",", &rest)) {
        uint32_t texture;
        status = pick_texture(&job->input, word, &texture);
        if (status == CMD_OK)
            job->keep[texture] = 1;
    }
    free(words);
    return status;
}

static void keep_shown(convert_job *job, uint32_t texture) {
    zt_texture_info info;
    zt_umbrella_info umbrellas;
    if (zt_get_texture(job->input.file, texture, &info) != ZT_OK)
        return;
    if (zt_get_umbrellas(job->input.file, texture, &umbrellas) == ZT_OK) {
        for (uint32_t i = 0; i < umbrellas.base_count; i++)
            if (umbrellas.bases[i].shows_texture)
                job->keep[umbrellas.bases[i].source] = 1;
        if (umbrellas.background_kind == ZT_BACKGROUND_TEXTURE)
            job->keep[umbrellas.background_source] = 1;
    }
    for (uint32_t p = 0; p < info.patch_count && !job->strip_patches; p++) {
        zt_patch_info patch;
        if (zt_get_patch(job->input.file, texture, p, &patch) == ZT_OK && patch.texture < texture)
            job->keep[patch.texture] = 1;
    }
}

static int choose_textures(convert_job *job) {
    int given = cmd_given(job->args, "keep-textures"), status = CMD_OK;
    for (int i = 0; status == CMD_OK && i < given; i++)
        status = keep_named(job, cmd_text_at(job->args, "keep-textures", (size_t)i));
    if (!given)
        memset(job->keep, 1, job->file.texture_count);
    /* What a patch or a base shows is an earlier texture, so one pass from the end finds all. */
    for (uint32_t t = job->file.texture_count; t-- > 0;)
        if (job->keep[t])
            keep_shown(job, t);
    return status;
}

/* ---- textures --------------------------------------------------------------------------------------------- */

#define LAYERS 32

static int add_zipmap(convert_job *job, uint32_t texture, const zt_texture_info *info, const zt_texture_desc *desc,
                      uint32_t count) {
    zt_patch_desc *patches = calloc(count, sizeof *patches);
    uint32_t *sources = calloc((size_t)count * info->layer_count, sizeof *sources);
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = patches && sources ? ZT_OK : ZT_NO_MEMORY;
    for (uint32_t p = 0; result == ZT_OK && p < count; p++) {
        zt_patch_info from;
        uint32_t *own = sources + (size_t)p * info->layer_count;
        result = zt_get_patch(job->input.file, texture, p, &from);
        if (result != ZT_OK)
            break;
        patches[p] = (zt_patch_desc){.parent = from.parent,
                                     .shows_texture = from.texture != ZT_NONE,
                                     .sources = own,
                                     .mask = from.mask == ZT_NONE ? ZT_NONE : job->images[from.mask]};
        memcpy(patches[p].matrix, from.matrix, sizeof from.matrix);
        for (uint32_t l = 0; l < info->layer_count; l++)
            own[l] = from.texture != ZT_NONE ? job->textures[from.texture]
                                             : job->images[zt_get_patch_image(job->input.file, texture, p, l)];
    }
    if (result == ZT_OK)
        result = zt_writer_add_zipmap(job->writer, desc, patches, count, &diag, &job->textures[texture]);
    free(patches);
    free(sources);
    return result == ZT_OK ? CMD_OK : cmd_fail_result(job->input.name, result, &diag);
}

static int add_silmap(convert_job *job, uint32_t texture, const zt_texture_info *info, const zt_texture_desc *desc) {
    zt_silmap_info from;
    uint32_t samples[LAYERS], minified[LAYERS];
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = zt_get_silmap(job->input.file, texture, &from);
    for (uint32_t l = 0; l < info->layer_count; l++) {
        uint32_t image = zt_get_silmap_minified(job->input.file, texture, l);
        samples[l] = desc->layers[l].image;
        minified[l] = image == ZT_NONE ? ZT_NONE : job->images[image];
    }
    zt_silmap_desc silmap = {.cells_x = from.cells_x,
                             .cells_y = from.cells_y,
                             .cell_layers = from.cell_layers,
                             .filter = from.filter,
                             .cells = from.cells,
                             .samples = samples,
                             .minified = minified};
    if (result == ZT_OK)
        result = zt_writer_add_silmap(job->writer, desc, &silmap, &diag, &job->textures[texture]);
    return result == ZT_OK ? CMD_OK : cmd_fail_result(job->input.name, result, &diag);
}

/* As they are, but for the numbers of images and textures. */
static int add_umbrellas(convert_job *job, uint32_t texture, const zt_texture_desc *desc) {
    zt_umbrella_info info;
    zt_diag diag = {.offset = UINT64_MAX};
    zt_result result = zt_get_umbrellas(job->input.file, texture, &info);
    size_t count = result == ZT_OK ? info.base_count : 0;
    zt_umbrella_base *bases = calloc(count + 1, sizeof *bases);
    if (result == ZT_OK && !bases)
        result = ZT_NO_MEMORY;
    for (size_t i = 0; result == ZT_OK && i < count; i++) {
        bases[i] = info.bases[i];
        bases[i].source = bases[i].shows_texture ? job->textures[bases[i].source] : job->images[bases[i].source];
    }
    info.bases = bases;
    if (result == ZT_OK && info.background_kind != ZT_BACKGROUND_COLOUR)
        info.background_source = info.background_kind == ZT_BACKGROUND_IMAGE ? job->images[info.background_source]
                                                                             : job->textures[info.background_source];
    if (result == ZT_OK)
        result = zt_writer_add_umbrellas(job->writer, desc, &info, &diag, &job->textures[texture]);
    free(bases);
    return result == ZT_OK ? CMD_OK : cmd_fail_result(job->input.name, result, &diag);
}

/* Layers of a texture of kind image have one size; those of a root may differ. */
static int one_size(const convert_job *job, uint32_t texture, uint32_t layer_count) {
    zt_image_info first = {0}, info;
    for (uint32_t l = 0; l < layer_count; l++) {
        zt_layer_info layer;
        if (zt_get_layer(job->input.file, texture, l, &layer) != ZT_OK ||
            zt_get_image(job->input.file, layer.image, &info) != ZT_OK)
            return 0;
        first = l == 0 ? info : first;
        if (info.width != first.width || info.height != first.height || info.layers != first.layers ||
            info.layer_kind != first.layer_kind)
            return 0;
    }
    return 1;
}

static int add_texture(convert_job *job, uint32_t texture) {
    zt_texture_info info;
    zt_layer_desc layers[LAYERS];
    zt_diag diag = {.offset = UINT64_MAX};
    if (zt_get_texture(job->input.file, texture, &info) != ZT_OK || info.layer_count > LAYERS)
        return cmd_fail(CMD_INTERNAL, "%s: texture %u cannot be read", job->input.name, (unsigned)texture);
    for (uint32_t l = 0; l < info.layer_count; l++) {
        zt_layer_info layer = {0};
        zt_get_layer(job->input.file, texture, l, &layer);
        layers[l] = (zt_layer_desc){.semantic = layer.semantic,
                                    .image = layer.image == ZT_NONE ? ZT_NONE : job->images[layer.image]};
    }
    zt_texture_desc desc = {.name = info.name,
                            .wrap_u = info.wrap_u,
                            .wrap_v = info.wrap_v,
                            .wrap_w = info.wrap_w,
                            .layers = layers,
                            .layer_count = info.layer_count};
    if (info.kind == ZT_KIND_SILMAP)
        return add_silmap(job, texture, &info, &desc);
    if (info.kind == ZT_KIND_UMBRELLA)
        return add_umbrellas(job, texture, &desc);
    int flat = info.kind == ZT_KIND_IMAGE || (job->strip_patches && one_size(job, texture, info.layer_count));
    if (!flat)
        return add_zipmap(job, texture, &info, &desc, job->strip_patches ? 1 : info.patch_count);
    zt_result result = zt_writer_add_texture(job->writer, &desc, &diag, &job->textures[texture]);
    return result == ZT_OK ? CMD_OK : cmd_fail_result(job->input.name, result, &diag);
}

/* ---- the rest --------------------------------------------------------------------------------------------- */

static int set_pair(convert_job *job, const char *word) {
    const char *equals = strchr(word, '=');
    zt_diag diag = {.offset = UINT64_MAX};
    if (!equals || equals == word)
        return cmd_usage(job->args, "--meta: '%s' is not KEY=VALUE", word);
    size_t length = (size_t)(equals - word);
    char *key = malloc(length + 1);
    if (!key)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    memcpy(key, word, length);
    key[length] = '\0';
    zt_result result = zt_writer_set_metadata(job->writer, key, equals + 1, &diag);
    free(key);
    return result == ZT_OK ? CMD_OK : cmd_fail_result("--meta", result, &diag);
}

static int copy_rest(convert_job *job) {
    zt_diag diag = {.offset = UINT64_MAX};
    uint32_t dropped = 0;
    int status = CMD_OK;
    zt_result result = job->strip ? ZT_OK : zt_writer_copy_rest(job->writer, job->input.file, &diag, &dropped);
    if (result != ZT_OK)
        return cmd_fail_result(job->input.name, result, &diag);
    if (dropped > 0)
        cmd_note(job->args, "%u chunk%s of unknown type dropped: not marked as safe to copy", (unsigned)dropped,
                 dropped > 1 ? "s" : "");
    for (int i = 0; status == CMD_OK && i < cmd_given(job->args, "unmeta"); i++) {
        result = zt_writer_set_metadata(job->writer, cmd_text_at(job->args, "unmeta", (size_t)i), NULL, &diag);
        status = result == ZT_OK ? CMD_OK : cmd_fail_result("--unmeta", result, &diag);
    }
    for (int i = 0; status == CMD_OK && i < cmd_given(job->args, "meta"); i++)
        status = set_pair(job, cmd_text_at(job->args, "meta", (size_t)i));
    return status;
}

static int copy_everything(convert_job *job) {
    int status = CMD_OK;
    for (uint32_t i = 0; i < job->file.image_count; i++)
        job->bytes_total += job->uses[i].used ? convert_image_size(job, i) : 0;
    for (uint32_t i = 0; status == CMD_OK && i < job->file.image_count; i++)
        if (job->uses[i].used)
            status = convert_copy_image(job, i);
    if (status == CMD_OK && job->format && job->reformatted == 0)
        cmd_warn(job->args, "no image has the meaning that --format is for: all formats stay as they are");
    for (uint32_t t = 0; status == CMD_OK && t < job->file.texture_count; t++)
        if (job->keep[t])
            status = add_texture(job, t);
    return status == CMD_OK ? copy_rest(job) : status;
}

static int convert(convert_job *job, const char *path) {
    zt_writer_options how = write_options(job->args, NULL);
    zt_get_file(job->input.file, &job->file);
    job->keep = calloc(job->file.texture_count, sizeof *job->keep);
    job->textures = calloc(job->file.texture_count, sizeof *job->textures);
    job->uses = calloc(job->file.image_count, sizeof *job->uses);
    job->images = calloc(job->file.image_count, sizeof *job->images);
    if (!job->keep || !job->textures || !job->uses || !job->images)
        return cmd_fail(CMD_INTERNAL, "out of memory");
    int status = choose_textures(job);
    if (status == CMD_OK)
        status = convert_find_uses(job);
    if (status == CMD_OK)
        status = cmd_writer_open(job->args, path, &how, &job->writer);
    if (status != CMD_OK)
        return status;
    cmd_progress_begin(&job->progress, job->args, "converting");
    status = copy_everything(job);
    cmd_progress_end(&job->progress);
    if (status == CMD_OK)
        status = cmd_writer_finish(path, job->writer);
    if (status == CMD_OK)
        cmd_verbose(job->args, "%llu tiles copied as stored", (unsigned long long)job->tiles_copied);
    return status;
}

static int run(cmd_args *args) {
    convert_job job = {.args = args};
    const char *path = cmd_text(args, "output");
    if (!path)
        return cmd_usage(args, "where to? Give the file's name with --output");
    int status = read_wishes(&job);
    if (status == CMD_OK)
        status = cmd_check_output(path, args->operands, 1);
    if (status == CMD_OK)
        status = cmd_open(args, args->operands[0], 0, &job.input);
    if (status == CMD_OK)
        status = convert(&job, path);
    zt_writer_close(job.writer);
    cmd_close(&job.input);
    free(job.keep);
    free(job.textures);
    free(job.uses);
    free(job.images);
    return status;
}

const cmd_verb verb_convert = {
    .name = "convert",
    .summary = "Change how a texture file is stored",
    .synopsis = "[OPTION]... FILE -o FILE",
    .text =
        "Writes a new file with the same textures, patches, metadata and unknown chunks that are safe to copy. What no "
        "option asks to change is copied bit for bit: as long as neither format, tiles, levels nor compression "
        "change, not even the compressed bytes do.",
    .options = options,
    .examples = examples,
    .operand = CMD_TEXTURE,
    .min_operands = 1,
    .max_operands = 1,
    .common = CMD_WITH_THREADS | CMD_WITH_MEMORY,
    .run = run,
};
