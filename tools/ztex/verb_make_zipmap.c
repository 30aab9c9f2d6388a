/* SPDX-License-Identifier: Apache-2.0 */
/* ztex make zipmap: a heap of photographs, in no order, into a zipmap. */
#include <stdlib.h>
#include <string.h>

#include "heap_report.h"
#include "make_args.h"

static const cmd_option options[] = {
    WRITE_OPTION_OUTPUT,
    {.name = "name",
     .letter = 'n',
     .metavar = "NAME",
     .kind = CMD_TEXT,
     .help = "Name of the texture. Default: that of its coarsest photograph."},
    {.name = "colour",
     .letter = 'c',
     .metavar = "HOW",
     .kind = CMD_CHOICE,
     .choices = "none|gain|poisson",
     .fallback = "poisson",
     .help = "How the colours of a photograph are led to those of the one around it: not at all, by one factor for "
             "each channel, or by "
             "a Poisson equation that keeps its gradients and takes the colours of its border."},
    {.name = "mask",
     .metavar = "HOW",
     .kind = CMD_CHOICE,
     .choices = "auto|none",
     .fallback = "auto",
     .help = "How a photograph's edge is hidden: where the picture is busy, or not at all."},
    {.name = "tau",
     .metavar = "X",
     .kind = CMD_REAL,
     .help = "With --mask auto: sum of gradients, colours going from 0 to 1, behind which a photograph is opaque. "
             "Default: chosen "
             "for each."},
    {.name = "ramp",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .min = 1,
     .max = 65536,
     .help = "Texels over which a photograph's edge fades in, whatever the mask says. Default: as many as three of the "
             "photograph around it are wide, and at least 8."},
    {.name = "normals",
     .metavar = "FRAME",
     .kind = CMD_CHOICE,
     .choices = "y_up|y_down|keep",
     .help = "Normals of --layer normal=... are in the frame of their photograph, their y as in OpenGL (y_up, the "
             "default) or "
             "as in Direct3D, and are turned into the root's; keep: they are in the root's already."},
    {.name = "prune", .help = "Drop texels that lie under opaque ones of finer photographs."},
    {.name = "bake-affine",
     .help = "Resample photographs taken from the side, so that their matrices are affine. For readers that know no "
             "perspective."},
    {.name = "allow-many",
     .help = "Photographs of several things: one texture for each group. Without it they are an error."},
    {.name = "candidates",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .min = 1,
     .max = 4096,
     .help =
         "Photographs that each one is compared with: the N that look most alike at a quick look. Default: all, and "
         "12 when there are more than 40 photographs."},
    {.name = "max-size",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .min = 16,
     .max = 65536,
     .help = "Make photographs smaller that are wider or higher than N pixels."},
    {.name = "layer",
     .metavar = "SEMANTIC=PATTERN",
     .kind = CMD_TEXT,
     .repeat = 1,
     .help = "Maps that go with the photographs: --layer normal=%_normal.png, where % is the photograph's name without "
             "folder and "
             "extension, or --layer normal=FOLDER. A pattern without a folder is looked for beside the photograph."},
    {.name = "report",
     .metavar = "FILE",
     .kind = CMD_FILE,
     .help = "Write what was found, as .html with pictures or as .json: the graph, matches, residuals, refused pairs, "
             "seams before and "
             "after, masks."},
    {.name = "scene-out",
     .metavar = "FILE",
     .kind = CMD_FILE,
     .help = "Write the scene, to be edited by hand: 'ztex make FILE -o OUT.ztex' makes the same texture of it."},
    MAKE_OPTION_WRAP("clamp", ""),
    MAKE_OPTION_FORMAT,
    MAKE_OPTION_LEVELS,
    MAKE_OPTION_MIP_FILTER,
    MAKE_OPTION_META,
    MAKE_OPTION_LICENSE,
    MAKE_OPTION_WRITER,
    MAKE_OPTION_TILE_EDGE,
    MAKE_OPTION_EFFORT,
    WRITE_OPTION_RAW,
    WRITE_OPTION_NO_FSYNC,
    {0}};

static const cmd_example examples[] = {
    {"ztex make zipmap photos/*.jpg -o wall.ztex", "Find out how the photographs belong together, and make a zipmap."},
    {"ztex make zipmap photos/*.jpg -o wall.ztex --report wall.html --scene-out wall.json",
     "Also say why each lies where it lies, and write a scene to be edited by hand."},
    {"ztex make wall.json -o wall.ztex", "Make the edited scene."},
    {"ztex make zipmap photos/*.jpg --layer normal=%_normal.png -o wall.ztex",
     "A material: photos/IMG_7.jpg has its normals in photos/IMG_7_normal.png."},
    {0}};

static const char text[] =
    "Takes photographs of one plane thing, such as a wall, a painting or a page, from near and from far, in no order. "
    "It finds which one is a zoom into which, and where; the coarsest becomes the root and every other a patch of the "
    "photograph around it. Their colours are adjusted, their edges hidden, and all goes into one zipmap.\n"
    "\n"
    "A photograph must show at least a twelfth of the width of the next coarser one; chains of photographs reach "
    "further. The thing should be flat, or far away: what moves against its background when the camera moves is "
    "refused.\n"
    "\n"
    "A photograph that fits nowhere is left out with a warning that gives the reason; the exit code stays 0. "
    "Photographs of several things are an error that lists the groups, unless --allow-many makes a texture of each; so "
    "is a "
    "heap in which no two photographs fit.\n"
    "\n"
    "A first word 'zipmap' always means this verb: a picture of this name is './zipmap'.";

/* ---- what was found ---------------------------------------------------------------------------------------- */

static void warn_of_unplaced(const heap *h) {
    for (size_t i = 0; i < h->count; i++)
        if (h->found.placings[i].state == AUTHOR_UNPLACED)
            cmd_warn(h->args, "%s is left out: %s", h->photos[i].path, h->found.placings[i].text);
}

static int list_groups(const heap *h) {
    cmd_error("the photographs are of %u things that do not fit together", (unsigned)h->found.group_count);
    for (uint32_t group = 0; group < h->found.group_count; group++) {
        char *line = NULL;
        size_t size = 0;
        FILE *stream = open_memstream(&line, &size);
        for (size_t i = 0; stream && i < h->found.order_count; i++) {
            uint32_t index = h->found.order[i];
            if (h->found.placings[index].group == group)
                fprintf(stream, " %s", h->photos[index].path);
        }
        if (stream && fclose(stream) == 0)
            cmd_hint("group %u:%s", (unsigned)group + 1, line);
        free(line);
    }
    cmd_hint("Make them one by one, or give --allow-many for one texture each in the same file.");
    return CMD_USAGE;
}

static int check_groups(const heap *h) {
    if (h->found.group_count == 0) {
        for (size_t i = 0; i < h->count; i++)
            cmd_error("%s: %s", h->photos[i].path, h->found.placings[i].text);
        return cmd_fail(CMD_USAGE, "no two of the photographs fit together");
    }
    warn_of_unplaced(h);
    if (h->found.group_count == 1)
        return CMD_OK;
    if (!cmd_given(h->args, "allow-many"))
        return list_groups(h);
    if (cmd_given(h->args, "name"))
        return cmd_usage(h->args, "--name is for one texture, and these photographs make %u",
                         (unsigned)h->found.group_count);
    return CMD_OK;
}

static void tell_places(const heap *h) {
    for (size_t i = 0; i < h->found.order_count; i++) {
        uint32_t index = h->found.order[i];
        const author_placing *p = &h->found.placings[index];
        if (p->state == AUTHOR_ROOT)
            cmd_verbose(h->args, "%s is a root", h->photos[index].path);
        else
            cmd_verbose(h->args,
                        "%s lies in %s: %.2f times as fine, %u of %u matches, residual %.2f pixels, correlation %.3f",
                        h->photos[index].path, h->photos[p->parent].path, p->ratio, (unsigned)p->inliers,
                        (unsigned)p->matches, p->residual, p->correlation);
    }
}

/* ---- output -------------------------------------------------------------------------------------------------- */

int heap_store(cmd_args *args, const json_t *scene, const char *output, zt_writer_options *how, const char *label) {
    make_scene made = {.folder = "",
                       .defaults = {.alpha = MAKE_UNSET, .transfer = MAKE_UNSET, .primaries = MAKE_UNSET}};
    cmd_progress progress;
    char *json = json_dumps(scene, JSON_REAL_PRECISION(17));
    int status = json ? make_scene_parse(&made, json, strlen(json)) : cmd_fail(CMD_INTERNAL, "out of memory");
    free(json);
    cmd_progress_begin(&progress, args, label);
    how->user = &progress;
    how->progress = cmd_progress_step;
    if (status == CMD_OK)
        status = make_store_scene(args, &made, output, how, &progress);
    cmd_progress_end(&progress);
    make_scene_release(&made);
    return status;
}

/* The folder of the file, absolute and with its slash; malloc'd. */
static char *folder_of(const char *path) {
    char *copy = strdup(path);
    char *slash = copy ? strrchr(copy, '/') : NULL;
    if (slash)
        slash[1] = '\0';
    char *whole = copy ? realpath(slash ? copy : ".", NULL) : NULL;
    size_t length = whole ? strlen(whole) : 0;
    char *grown = whole ? realloc(whole, length + 2) : NULL;
    free(copy);
    if (!grown)
        return NULL;
    if (grown[length - 1] != '/')
        memcpy(grown + length, "/", 2);
    return grown;
}

static int write_scene(const heap *h) {
    const char *path = cmd_text(h->args, "scene-out");
    json_t *scene = NULL;
    if (!path)
        return CMD_OK;
    char *folder = folder_of(strcmp(path, "-") == 0 ? "" : path);
    int status = folder ? heap_scene(h, HEAP_RESULT, folder, &scene)
                        : cmd_fail(CMD_IO, "%s: the folder is not there", path);
    if (status == CMD_OK)
        status = cmd_json_write(path, scene);
    json_decref(scene);
    free(folder);
    return status;
}

static int make_all(heap *h, const char *output) {
    json_t *scene = NULL;
    int status = heap_open_photos(h);
    if (status == CMD_OK)
        status = heap_register(h);
    if (status == CMD_OK)
        status = check_groups(h);
    if (status != CMD_OK)
        return status;
    tell_places(h);
    status = heap_find_layers(h);
    if (status == CMD_OK)
        status = make_copy_authorship(&h->memory, h->photos[h->found.roots[0]].path);
    if (status == CMD_OK)
        status = make_add_metadata(h->args, &h->memory);
    if (status == CMD_OK)
        status = heap_scene(h, HEAP_RESULT, "", &scene);
    zt_writer_options writer = write_options(h->args, NULL);
    if (status == CMD_OK)
        status = heap_store(h->args, scene, output, &writer, "making");
    json_decref(scene);
    if (status == CMD_OK)
        status = write_scene(h);
    if (status == CMD_OK && cmd_given(h->args, "report"))
        status = heap_write_report(h, output, cmd_text(h->args, "report"));
    return status;
}

static int check_outputs(cmd_args *args) {
    static const char *const names[] = {"output", "scene-out", "report"};
    for (size_t i = 0; i < 3; i++) {
        const char *path = cmd_text(args, names[i]);
        int status = path ? cmd_check_output(path, args->operands, args->operand_count) : CMD_OK;
        for (size_t k = 0; path && status == CMD_OK && k < i; k++)
            if (cmd_text(args, names[k]) && strcmp(cmd_text(args, names[k]), path) == 0)
                status = cmd_usage(args, "--%s and --%s have one name: %s", names[k], names[i], path);
        if (status != CMD_OK)
            return status;
    }
    return CMD_OK;
}

static int run(cmd_args *args) {
    const char *output = cmd_text(args, "output");
    heap h = {.args = args, .memory = {.folder = ""}};
    if (!output)
        return cmd_usage(args, "-o FILE is missing: where shall the texture go?");
    if (args->operand_count < 2)
        return cmd_usage(args, "one photograph is no heap: give several, or 'ztex make' for one");
    if (strcmp(output, "-") == 0 && cmd_given(args, "report"))
        return cmd_usage(args, "--report looks at the file that was made: give it a name with -o");
    int status = check_outputs(args);
    if (status == CMD_OK)
        status = make_all(&h, output);
    author_registration_release(&h.found);
    make_scene_release(&h.memory);
    return status;
}

const cmd_verb verb_make_zipmap = {
    .name = "make zipmap",
    .summary = "Make a zipmap from a heap of photographs",
    .synopsis = "[OPTION]... PHOTO... -o OUT.ztex",
    .text = text,
    .options = options,
    .examples = examples,
    .operand = CMD_FILE,
    .min_operands = 1,
    .max_operands = 0,
    .common = CMD_WITH_THREADS | CMD_WITH_MEMORY,
    .run = run,
};
