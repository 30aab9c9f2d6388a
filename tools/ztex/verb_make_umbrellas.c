/* SPDX-License-Identifier: Apache-2.0 */
/* ztex make umbrellas: a scene with an umbrella texture, its seed and its report. */
#include <stdlib.h>
#include <string.h>

#include "make_args.h"
#include "umbrellas.h"

static const cmd_option options[] = {
    WRITE_OPTION_OUTPUT,
    {.name = "seed",
     .metavar = "N",
     .kind = CMD_INTEGER,
     .help = "Instead of the scene's seed: another arrangement of the same elements."},
    {.name = "report",
     .metavar = "FILE",
     .kind = CMD_FILE,
     .help = "Write how good the coarser levels are, as .html with pictures or as .json."},
    {.name = "json", .letter = 'j', .help = "Print the figures of the report as JSON."},
    MAKE_OPTION_META,
    MAKE_OPTION_LICENSE,
    MAKE_OPTION_WRITER,
    MAKE_OPTION_EFFORT,
    WRITE_OPTION_RAW,
    WRITE_OPTION_NO_FSYNC,
    {0}};

static const cmd_example examples[] = {{"ztex make umbrellas leaves.json -o leaves.ztex", "What the scene says."},
                                       {"ztex make umbrellas leaves.json --seed 7 --report leaves.html -o leaves.ztex",
                                        "Another arrangement, and a page that shows its levels."},
                                       {0}};

static const char text[] =
    "An umbrella texture stores a few elements, such as leaves, stones or flowers, and an arrangement of many varied "
    "copies of them; the picture comes about when it is looked up. So a ground of thousands of leaves, none like "
    "another, takes a fraction of what its picture would, and stays sharp from near.\n"
    "\n"
    "SCENE.json is a scene as 'ztex make' takes it, in which one texture has the member 'umbrellas': the pictures of "
    "the elements, how copies vary, how they lie, and how many coarser levels there are, whose colours are fitted to "
    "what the finest one shows. Chance comes from the seed alone: equal scenes give equal bytes on every machine, with "
    "any number of threads.\n"
    "\n"
    "A first word 'umbrellas' always means this verb: a picture of this name is './umbrellas'.";

/* The one texture that has umbrellas; the scene is the caller's own. */
static int find_umbrellas(const make_scene *scene, make_umbrellas **out) {
    uint32_t count = 0;
    for (uint32_t t = 0; t < scene->texture_count; t++)
        if (scene->textures[t].umbrellas) {
            *out = scene->textures[t].umbrellas;
            count++;
        }
    if (count == 1)
        return CMD_OK;
    return make_complain(scene, "/textures",
                         "%u textures have 'umbrellas': here there must be one ('ztex make' takes any number)", count);
}

static int read_scene(const cmd_args *args, make_scene *scene, void **data) {
    const char *path = args->operands[0], *slash = strrchr(path, '/');
    size_t size = 0;
    scene->defaults = (make_options){
        .alpha = MAKE_UNSET, .transfer = MAKE_UNSET, .primaries = MAKE_UNSET, .mip_filter = MAKE_UNSET};
    scene->name = cmd_input_name(path);
    scene->folder = slash ? make_string(scene, "%.*s", (int)(slash - path + 1), path) : "";
    int status = scene->folder ? make_add_metadata(args, scene) : CMD_INTERNAL;
    if (status == CMD_OK)
        status = cmd_read_all(args, path, 0, data, &size);
    return status == CMD_OK ? make_scene_parse(scene, *data, size) : status;
}

static int run(cmd_args *args) {
    const char *output = cmd_text(args, "output"), *report = cmd_text(args, "report");
    make_scene scene = {.folder = ""};
    make_umbrellas *umbrellas = NULL;
    umbrellas_made made = {0};
    void *data = NULL;
    if (!output)
        return cmd_usage(args, "-o FILE is missing: where shall the texture go?");
    if (strcmp(output, "-") == 0 && (report || cmd_given(args, "json")))
        return cmd_usage(args, "--report and --json look at the file that was made: give it a name with -o");
    int status = cmd_check_output(output, args->operands, 1);
    if (status == CMD_OK && report)
        status = cmd_check_output(report, args->operands, 1);
    if (status == CMD_OK)
        status = read_scene(args, &scene, &data);
    if (status == CMD_OK)
        status = find_umbrellas(&scene, &umbrellas);
    if (status == CMD_OK) {
        umbrellas->made = &made;
        umbrellas->seed = cmd_given(args, "seed") ? cmd_integer(args, "seed") : umbrellas->seed;
        status = make_file_of(args, &scene, output, report);
    }
    if (status == CMD_OK && (report || cmd_given(args, "json")))
        status = umbrellas_measure(args, &made, output);
    if (status == CMD_OK && report)
        status = umbrellas_write_report(args, &made, output, report);
    if (status == CMD_OK && cmd_given(args, "json"))
        status = umbrellas_print(&made, output);
    umbrellas_made_release(&made);
    make_scene_release(&scene);
    free(data);
    return status;
}

const cmd_verb verb_make_umbrellas = {
    .name = "make umbrellas",
    .summary = "Make a texture of many varied copies of a few elements, such as leaves or stones",
    .synopsis = "[OPTION]... SCENE.json -o OUT.ztex",
    .text = text,
    .options = options,
    .examples = examples,
    .operand = CMD_FILE,
    .min_operands = 1,
    .max_operands = 1,
    .common = CMD_WITH_THREADS | CMD_WITH_MEMORY,
    .run = run,
};
