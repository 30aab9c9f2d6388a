/* SPDX-License-Identifier: Apache-2.0 */
/* The bases of umbrellas in a scene: pictures, outlines, colour variants, and how copies vary. */
#include <math.h>
#include <string.h>

#include "scene_umbrellas.h"

#define MOST_BASES 65536
#define MOST_VARIANTS 255

static const author_range any_turn = {-1e6, 1e6}, unit = {0, 1};

/* ---- outlines -------------------------------------------------------------------------------------------------- */

static int read_points(make_scene *scene, const json_t *list, const char *pointer, make_outline *out) {
    size_t count = json_array_size(list);
    if (count < 3 || count > AUTHOR_VERTICES)
        return make_complain(scene, pointer, "3 to %d points [x, y] are wanted here", AUTHOR_VERTICES);
    out->points = make_alloc(scene, count, sizeof *out->points);
    if (!out->points)
        return CMD_INTERNAL;
    for (size_t i = 0; i < count; i++) {
        const char *at = make_string(scene, "%s/%u", pointer, (unsigned)i);
        double pair[2];
        int status = at ? scene_reals(scene, json_array_get(list, i), at, 2, pair) : CMD_INTERNAL;
        if (status == CMD_OK && !(fabs(pair[0]) <= 16 && fabs(pair[1]) <= 16))
            status = make_complain(scene, at, "%g, %g lies far outside of the picture, whose corners are 0, 0 and 1, 1",
                                   pair[0], pair[1]);
        if (status != CMD_OK)
            return status;
        out->points[i] = (author_xy){pair[0], pair[1]};
    }
    out->count = count;
    return CMD_OK;
}

/* A list of points, or the name of a drawing. */
static int read_outline(make_scene *scene, const json_t *value, const char *pointer, const make_options *defaults,
                        make_outline *out) {
    const make_image *image = NULL;
    if (json_is_array(value))
        return read_points(scene, value, pointer, out);
    if (!json_is_string(value))
        return scene_wrong_type(scene, pointer, value, "the name of a drawing, or a list of points");
    int status = scene_image(scene, value, pointer, defaults, &image);
    out->drawing = status == CMD_OK ? image->files[0].path : NULL;
    return status;
}

static int read_morph(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                      make_umbrella_base *base) {
    static const char *const known[] = {"amount", "outline", NULL};
    const json_t *value, *outline;
    const char *at, *outline_at;
    int status = scene_member(scene, object, pointer, "morph", &value, &at);
    if (status != CMD_OK || !value)
        return status;
    if (!json_is_object(value))
        return scene_wrong_type(scene, at, value, "an object with 'amount' or 'outline'");
    status = scene_check_keys(scene, value, at, known);
    if (status == CMD_OK)
        status = scene_member(scene, value, at, "outline", &outline, &outline_at);
    if (status == CMD_OK && !outline == !json_object_get(value, "amount"))
        return make_complain(scene, at, "either 'amount' or 'outline' is wanted here");
    if (status == CMD_OK && outline && !base->outline.drawing && !base->outline.count)
        return make_complain(scene, at, "a second outline goes with a first one: 'outline' is missing in %s", pointer);
    if (status == CMD_OK && outline)
        return read_outline(scene, outline, outline_at, defaults, &base->morph);
    return status == CMD_OK ? scene_real(scene, value, at, "amount", 0, 0.9, &base->input.morph_amount) : status;
}

static int read_centre(make_scene *scene, const json_t *object, const char *pointer, make_umbrella_base *base) {
    const json_t *value;
    const char *at;
    double pair[2];
    int kind = AUTHOR_CENTRE_KERNEL;
    int status = scene_member(scene, object, pointer, "centre", &value, &at);
    if (status != CMD_OK || !value)
        return status;
    if (!json_is_array(value)) {
        status = scene_member_word(scene, object, pointer, "centre", "kernel|centroid", &kind);
        base->input.centre_kind = (author_centre)kind;
        return status;
    }
    status = scene_reals(scene, value, at, 2, pair);
    base->input.centre_kind = AUTHOR_CENTRE_GIVEN;
    if (status == CMD_OK)
        base->input.centre = (author_xy){pair[0], pair[1]};
    return status;
}

/* true: the colour of the picture's border. */
static int read_key(make_scene *scene, const json_t *object, const char *pointer, make_umbrella_base *base) {
    const json_t *value;
    const char *at;
    int status = scene_member(scene, object, pointer, "key", &value, &at);
    if (status != CMD_OK || !value)
        return status;
    base->input.keyed = !json_is_false(value);
    if (json_is_boolean(value))
        return CMD_OK;
    base->input.key = base->key;
    return scene_colour(scene, value, at, base->key);
}

/* ---- variants -------------------------------------------------------------------------------------------------- */

static int read_offset(make_scene *scene, const json_t *value, const char *pointer, float out[3]) {
    double rgb[3];
    int status = scene_reals(scene, value, pointer, 3, rgb);
    for (int c = 0; status == CMD_OK && c < 3; c++) {
        out[c] = (float)rgb[c];
        if (!(fabs(rgb[c]) <= 1))
            return make_complain(scene, pointer, "%g is not from -1 to 1 of linear light", rgb[c]);
    }
    return status;
}

/* "tint" or "offset", and "rim" of the same kind. */
static int read_tint(make_scene *scene, const json_t *object, const char *pointer, make_variant *v) {
    const json_t *main, *rim;
    const char *main_at, *rim_at;
    int offsets = json_object_get(object, "offset") != NULL;
    int (*read)(make_scene *, const json_t *, const char *, float *) = offsets ? read_offset : scene_colour;
    int status = scene_member(scene, object, pointer, offsets ? "offset" : "tint", &main, &main_at);
    if (status == CMD_OK)
        status = scene_member(scene, object, pointer, "rim", &rim, &rim_at);
    if (status == CMD_OK)
        status = read(scene, main, main_at, v->variant.centre);
    v->variant.offsets = offsets;
    memcpy(v->variant.rim, v->variant.centre, sizeof v->variant.rim);
    if (status == CMD_OK && rim)
        status = read(scene, rim, rim_at, v->variant.rim);
    return status == CMD_OK ? scene_real(scene, object, pointer, "spread", 0, 1, &v->variant.spread) : status;
}

static int read_variant(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                        make_variant *v) {
    static const char *const known[] = {"image", "tint", "offset", "rim", "spread", NULL};
    const json_t *image;
    const char *at;
    if (!json_is_object(object))
        return scene_wrong_type(scene, pointer, object, "an object");
    int status = scene_check_keys(scene, object, pointer, known);
    if (status == CMD_OK)
        status = scene_member(scene, object, pointer, "image", &image, &at);
    if (status != CMD_OK)
        return status;
    int ways = (image != NULL) + (json_object_get(object, "tint") != NULL) +
               (json_object_get(object, "offset") != NULL);
    if (ways != 1)
        return make_complain(scene, pointer, "one of 'image', 'tint' and 'offset' is wanted here");
    return image ? scene_image(scene, image, at, defaults, &v->image) : read_tint(scene, object, pointer, v);
}

static int read_variants(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                         make_umbrella_base *base) {
    const json_t *list;
    const char *at;
    int status = scene_member(scene, object, pointer, "variants", &list, &at);
    if (status != CMD_OK || !list)
        return status;
    size_t count = json_array_size(list);
    if (!json_is_array(list) || count > MOST_VARIANTS)
        return make_complain(scene, at, "a list of at most %d variants is wanted here", MOST_VARIANTS);
    base->variants = make_alloc(scene, count + 1, sizeof *base->variants);
    if (!base->variants)
        return CMD_INTERNAL;
    for (size_t i = 0; status == CMD_OK && i < count; i++) {
        const char *one = make_string(scene, "%s/%u", at, (unsigned)i);
        status = one ? read_variant(scene, json_array_get(list, i), one, defaults, &base->variants[i]) : CMD_INTERNAL;
    }
    base->input.variant_count = (uint32_t)count;
    return status;
}

/* ---- copies ---------------------------------------------------------------------------------------------------- */

static int read_solid(make_scene *scene, const json_t *object, const char *pointer, author_species *s) {
    const author_range heights = {0, 100}, curvatures = {1.0 / 65536, 1}, lifts = {0, 16000};
    int shape = ZT_ELLIPSOID_FLAT;
    s->height = (author_range){0.3, 0.3};
    s->curvature = (author_range){0.5, 0.5};
    int status = scene_member_word(scene, object, pointer, "ellipsoid", "flat|convex|concave", &shape);
    s->ellipsoid = (zt_umbrella_ellipsoid)shape;
    if (status == CMD_OK && shape == ZT_ELLIPSOID_FLAT &&
        (json_object_get(object, "height") || json_object_get(object, "curvature")))
        return make_complain(scene, pointer, "'height' and 'curvature' go with 'ellipsoid': convex or concave");
    if (status == CMD_OK)
        status = scene_range(scene, object, pointer, "height", heights, &s->height);
    if (status == CMD_OK)
        status = scene_range(scene, object, pointer, "curvature", curvatures, &s->curvature);
    return status == CMD_OK ? scene_range(scene, object, pointer, "lift", lifts, &s->lift) : status;
}

static int read_species(make_scene *scene, const json_t *object, const char *pointer, author_species *s) {
    const author_range sizes = {1e-3, 16000};
    author_range degrees = {0, 360};
    s->weight = 1;
    s->size = (author_range){1, 1};
    s->morph = s->strength = unit;
    int status = scene_real(scene, object, pointer, "weight", 0, 1e6, &s->weight);
    if (status == CMD_OK)
        status = scene_range(scene, object, pointer, "size", sizes, &s->size);
    if (status == CMD_OK)
        status = scene_range(scene, object, pointer, "rotation", any_turn, &degrees);
    if (status == CMD_OK)
        status = scene_range(scene, object, pointer, "morph_weight", unit, &s->morph);
    if (status == CMD_OK)
        status = scene_range(scene, object, pointer, "strength", unit, &s->strength);
    if (status == CMD_OK)
        status = scene_real(scene, object, pointer, "mirrored", 0, 1, &s->mirrored);
    s->rotation = (author_range){degrees.low / 360, degrees.high / 360};
    return status == CMD_OK ? read_solid(scene, object, pointer, s) : status;
}

/* ---- a base ---------------------------------------------------------------------------------------------------- */

static int read_source(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                       const make_texture *texture, make_umbrella_base *base) {
    const json_t *name, *image, *shown, *outline;
    const char *name_at, *image_at, *shown_at, *outline_at;
    base->name = "";
    base->texture = ZT_NONE;
    int status = scene_member(scene, object, pointer, "name", &name, &name_at);
    if (status == CMD_OK && name)
        status = scene_text(scene, name, name_at, &base->name);
    if (status == CMD_OK)
        status = scene_member(scene, object, pointer, "image", &image, &image_at);
    if (status == CMD_OK)
        status = scene_member(scene, object, pointer, "texture", &shown, &shown_at);
    if (status == CMD_OK)
        status = scene_member(scene, object, pointer, "outline", &outline, &outline_at);
    if (status != CMD_OK)
        return status;
    if (!image == !shown)
        return make_complain(scene, pointer, "either 'image' or 'texture' is wanted here");
    if (shown && !outline)
        return make_complain(scene, pointer, "a base that shows a texture needs an 'outline'");
    status = image ? scene_image(scene, image, image_at, defaults, &base->image)
                   : scene_earlier(scene, shown, shown_at, texture, &base->texture);
    return status == CMD_OK && outline ? read_outline(scene, outline, outline_at, defaults, &base->outline) : status;
}

static int read_shape(make_scene *scene, const json_t *object, const char *pointer, make_umbrella_base *base) {
    author_base_input *input = &base->input;
    const json_t *repair;
    const char *at;
    int status = read_key(scene, object, pointer, base);
    if (status == CMD_OK)
        status = scene_real(scene, object, pointer, "tolerance", 0.001, 1, &input->tolerance);
    if (status == CMD_OK)
        status = scene_real(scene, object, pointer, "threshold", 0.001, 1, &input->threshold);
    if (status == CMD_OK)
        status = scene_count(scene, object, pointer, "vertices", 3, AUTHOR_VERTICES - 64, &input->most_vertices);
    if (status == CMD_OK)
        status = scene_count(scene, object, pointer, "texels", 8, 8192, &input->texels);
    if (status == CMD_OK)
        status = read_centre(scene, object, pointer, base);
    if (status == CMD_OK)
        status = scene_member(scene, object, pointer, "repair", &repair, &at);
    return status == CMD_OK && repair ? scene_flag(scene, repair, at, &input->repair) : status;
}

static int read_base(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                     const make_texture *texture, make_umbrella_base *base) {
    static const char *const known[] = {"name",      "image",     "texture",  "outline",   "morph",        "key",
                                        "tolerance", "threshold", "vertices", "texels",    "centre",       "repair",
                                        "variants",  "weight",    "size",     "rotation",  "morph_weight", "strength",
                                        "mirrored",  "ellipsoid", "height",   "curvature", "lift",         NULL};
    base->pointer = pointer;
    if (!json_is_object(object))
        return scene_wrong_type(scene, pointer, object, "an object");
    int status = scene_check_keys(scene, object, pointer, known);
    if (status == CMD_OK)
        status = read_source(scene, object, pointer, defaults, texture, base);
    if (status == CMD_OK)
        status = read_shape(scene, object, pointer, base);
    if (status == CMD_OK)
        status = read_morph(scene, object, pointer, defaults, base);
    if (status == CMD_OK)
        status = read_variants(scene, object, pointer, defaults, base);
    return status == CMD_OK ? read_species(scene, object, pointer, &base->species) : status;
}

int scene_bases(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                const make_texture *texture, make_umbrellas *u) {
    const json_t *list;
    const char *at;
    int status = scene_member(scene, object, pointer, "bases", &list, &at);
    if (status != CMD_OK)
        return status;
    size_t count = json_array_size(list);
    if (!json_is_array(list) || count == 0 || count > MOST_BASES)
        return make_complain(scene, at, "a list of bases is wanted here: {\"image\": \"leaf.png\", \"size\": [1, 2]}");
    u->bases = make_alloc(scene, count, sizeof *u->bases);
    if (!u->bases)
        return CMD_INTERNAL;
    u->base_count = (uint32_t)count;
    for (uint32_t i = 0; status == CMD_OK && i < count; i++) {
        const char *one = make_string(scene, "%s/%u", at, i);
        status = one ? read_base(scene, json_array_get(list, i), one, defaults, texture, &u->bases[i]) : CMD_INTERNAL;
        u->bases[i].species.base = i;
    }
    return status;
}
