/* SPDX-License-Identifier: Apache-2.0 */
/* Umbrellas in a scene: the member "umbrellas" of a texture, all but its bases. */
#include "scene_umbrellas.h"

#include <math.h>
#include <string.h>

/* ---- members of an object -------------------------------------------------------------------------------------- */

int scene_real(make_scene *scene, const json_t *object, const char *pointer, const char *name, double low, double high,
               double *out) {
    const json_t *value;
    const char *at;
    int status = scene_member(scene, object, pointer, name, &value, &at);
    if (status != CMD_OK || !value)
        return status;
    if (!json_is_number(value))
        return scene_wrong_type(scene, at, value, "a number");
    double number = json_number_value(value);
    if (!(number >= low && number <= high))
        return make_complain(scene, at, "%g is not from %g to %g", number, low, high);
    *out = number;
    return CMD_OK;
}

int scene_count(make_scene *scene, const json_t *object, const char *pointer, const char *name, uint32_t low,
                uint32_t high, uint32_t *out) {
    const json_t *value;
    const char *at;
    int status = scene_member(scene, object, pointer, name, &value, &at);
    if (status != CMD_OK || !value)
        return status;
    return scene_whole(scene, value, at, low, high, out);
}

int scene_range(make_scene *scene, const json_t *object, const char *pointer, const char *name, author_range bounds,
                author_range *out) {
    const json_t *value;
    const char *at;
    double pair[2];
    int status = scene_member(scene, object, pointer, name, &value, &at);
    if (status != CMD_OK || !value)
        return status;
    if (json_is_number(value)) {
        status = scene_real(scene, object, pointer, name, bounds.low, bounds.high, pair);
        pair[1] = pair[0];
    } else {
        status = scene_reals(scene, value, at, 2, pair);
    }
    if (status != CMD_OK)
        return status;
    if (!(pair[0] >= bounds.low && pair[0] <= pair[1] && pair[1] <= bounds.high))
        return make_complain(scene, at, "%g to %g is no range from %g to %g, the lesser number first", pair[0], pair[1],
                             bounds.low, bounds.high);
    *out = (author_range){pair[0], pair[1]};
    return CMD_OK;
}

int scene_colour(make_scene *scene, const json_t *value, const char *pointer, float out[3]) {
    const char *text;
    double rgb[3];
    if (json_is_array(value)) {
        int status = scene_reals(scene, value, pointer, 3, rgb);
        for (int c = 0; status == CMD_OK && c < 3; c++) {
            out[c] = (float)rgb[c];
            if (!(rgb[c] >= 0 && rgb[c] <= 1))
                return make_complain(scene, pointer, "%g is not from 0 to 1 of linear light", rgb[c]);
        }
        return status;
    }
    int status = scene_text(scene, value, pointer, &text);
    if (status != CMD_OK)
        return status;
    if (text[0] != '#' || strlen(text) != 7 || strspn(text + 1, "0123456789abcdefABCDEF") != 6)
        return make_complain(scene, pointer, "'%s' is no colour such as #8a5a2b, or three numbers of linear light",
                             text);
    for (int c = 0; c < 3; c++) {
        char pair[3] = {text[1 + 2 * c], text[2 + 2 * c], 0};
        out[c] = zt_transfer_decode(ZT_TRANSFER_SRGB, (float)strtoul(pair, NULL, 16) / 255.0f);
    }
    return CMD_OK;
}

/* ---- background ---------------------------------------------------------------------------------------------- */

static int read_background(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                           const make_texture *texture, make_umbrellas *u) {
    static const char *const known[] = {"image", "texture", NULL};
    const json_t *value, *image, *shown;
    const char *at, *image_at, *shown_at;
    u->background[3] = 1.0f;
    int status = scene_member(scene, object, pointer, "background", &value, &at);
    if (status != CMD_OK || !value)
        return status;
    if (!json_is_object(value)) {
        int none = json_is_string(value) && strcmp(json_string_value(value), "none") == 0;
        u->background[3] = none ? 0.0f : 1.0f;
        return none ? CMD_OK : scene_colour(scene, value, at, u->background);
    }
    status = scene_check_keys(scene, value, at, known);
    if (status == CMD_OK)
        status = scene_member(scene, value, at, "image", &image, &image_at);
    if (status == CMD_OK)
        status = scene_member(scene, value, at, "texture", &shown, &shown_at);
    if (status != CMD_OK)
        return status;
    if (!image == !shown)
        return make_complain(scene, at,
                             "either 'image' or 'texture' is wanted here, or a colour instead of the object");
    u->background[3] = 0.0f;
    u->background_kind = image ? ZT_BACKGROUND_IMAGE : ZT_BACKGROUND_TEXTURE;
    return image ? scene_image(scene, image, image_at, defaults, &u->background_image)
                 : scene_earlier(scene, shown, shown_at, texture, &u->background_texture);
}

/* ---- places -------------------------------------------------------------------------------------------------- */

/* A base by its name or its number in the list. */
static int read_place_base(make_scene *scene, const json_t *object, const char *pointer, const make_umbrellas *u,
                           author_place *place) {
    const json_t *value;
    const char *at;
    int status = scene_member(scene, object, pointer, "base", &value, &at);
    if (status != CMD_OK)
        return status;
    if (!value)
        return make_complain(scene, pointer, "'base' is missing: the name or the number of one");
    if (!json_is_string(value))
        return scene_whole(scene, value, at, 0, u->base_count - 1, &place->species);
    for (uint32_t i = 0; i < u->base_count; i++)
        if (strcmp(u->bases[i].name, json_string_value(value)) == 0) {
            place->species = i;
            return CMD_OK;
        }
    return make_complain(scene, at, "no base is named '%s'", json_string_value(value));
}

static int read_place(make_scene *scene, const json_t *object, const char *pointer, const make_umbrellas *u,
                      author_place *place) {
    static const char *const known[] = {"base",  "at",   "size",   "rotation", "mirrored",
                                        "morph", "lift", "height", "variant",  NULL};
    const json_t *spot, *mirrored;
    const char *spot_at, *mirrored_at;
    double pair[2], turn = NAN;
    uint32_t variant = UINT32_MAX;
    *place = (author_place){0, 0, 0, NAN, NAN, NAN, NAN, NAN, -1, -1};
    if (!json_is_object(object))
        return scene_wrong_type(scene, pointer, object, "an object");
    int status = scene_check_keys(scene, object, pointer, known);
    if (status == CMD_OK)
        status = read_place_base(scene, object, pointer, u, place);
    if (status == CMD_OK)
        status = scene_member(scene, object, pointer, "at", &spot, &spot_at);
    if (status == CMD_OK)
        status = scene_reals(scene, spot, spot_at, 2, pair);
    if (status == CMD_OK)
        status = scene_real(scene, object, pointer, "size", 1e-6, 16000, &place->size);
    if (status == CMD_OK)
        status = scene_real(scene, object, pointer, "rotation", -1e6, 1e6, &turn);
    if (status == CMD_OK)
        status = scene_real(scene, object, pointer, "morph", 0, 1, &place->morph);
    if (status == CMD_OK)
        status = scene_real(scene, object, pointer, "lift", 0, 16000, &place->lift);
    if (status == CMD_OK)
        status = scene_real(scene, object, pointer, "height", 0, 100, &place->height);
    if (status == CMD_OK)
        status = scene_count(scene, object, pointer, "variant", 0, 254, &variant);
    if (status == CMD_OK)
        status = scene_member(scene, object, pointer, "mirrored", &mirrored, &mirrored_at);
    if (status == CMD_OK && mirrored)
        status = scene_flag(scene, mirrored, mirrored_at, &place->mirrored);
    if (status != CMD_OK)
        return status;
    place->x = pair[0];
    place->y = pair[1];
    place->rotation = turn / 360;
    place->variant = variant == UINT32_MAX ? -1 : (int)variant;
    return CMD_OK;
}

static int read_places(make_scene *scene, const json_t *object, const char *pointer, make_umbrellas *u) {
    const json_t *list;
    const char *at;
    int status = scene_member(scene, object, pointer, "places", &list, &at);
    if (status != CMD_OK)
        return status;
    size_t count = json_array_size(list);
    if (!json_is_array(list) || count > 1u << 24)
        return make_complain(scene, at, "a list of places is wanted here: {\"base\": ..., \"at\": [x, y]}");
    author_place *places = make_alloc(scene, count + 1, sizeof *places);
    if (!places)
        return CMD_INTERNAL;
    for (size_t i = 0; status == CMD_OK && i < count; i++) {
        const char *one = make_string(scene, "%s/%u", at, (unsigned)i);
        status = one ? read_place(scene, json_array_get(list, i), one, u, &places[i]) : CMD_INTERNAL;
    }
    u->arrangement.places = places;
    u->arrangement.place_count = count;
    return status;
}

/* ---- arrangement --------------------------------------------------------------------------------------------- */

static int read_method(make_scene *scene, const json_t *value, const char *at, make_umbrellas *u) {
    author_arrangement *a = &u->arrangement;
    int method = AUTHOR_POISSON, order = -1;
    int status = scene_member_word(scene, value, at, "method", "poisson|jittered|tiling|places", &method);
    if (status == CMD_OK)
        status = scene_member_word(scene, value, at, "order", "random|size|given", &order);
    a->method = (author_method)method;
    a->order = order >= 0 ? (author_order)order : method < AUTHOR_TILING ? AUTHOR_ORDER_RANDOM : AUTHOR_ORDER_GIVEN;
    return status;
}

static int read_arrangement(make_scene *scene, const json_t *object, const char *pointer, make_umbrellas *u) {
    static const char *const known[] = {"method", "order",     "density", "jitter", "columns",
                                        "rows",   "row_shift", "places",  NULL};
    author_arrangement *a = &u->arrangement;
    const json_t *value;
    const char *at;
    int status = scene_member(scene, object, pointer, "arrangement", &value, &at);
    if (status != CMD_OK)
        return status;
    if (!value)
        return make_complain(scene, pointer, "'arrangement' is missing: {\"density\": 4} would do");
    if (!json_is_object(value))
        return scene_wrong_type(scene, at, value, "an object");
    a->density = 4;
    a->jitter = 1;
    a->columns = a->grid_x;
    a->rows = a->grid_y;
    status = scene_check_keys(scene, value, at, known);
    if (status == CMD_OK)
        status = read_method(scene, value, at, u);
    if (status == CMD_OK)
        status = scene_real(scene, value, at, "density", 1e-6, 10000, &a->density);
    if (status == CMD_OK)
        status = scene_real(scene, value, at, "jitter", 0, 1, &a->jitter);
    if (status == CMD_OK)
        status = scene_count(scene, value, at, "columns", 1, 65536, &a->columns);
    if (status == CMD_OK)
        status = scene_count(scene, value, at, "rows", 1, 65536, &a->rows);
    if (status == CMD_OK)
        status = scene_real(scene, value, at, "row_shift", -1, 1, &a->row_shift);
    return status == CMD_OK && a->method == AUTHOR_PLACES ? read_places(scene, value, at, u) : status;
}

/* ---- the rest ------------------------------------------------------------------------------------------------ */

static int read_grid(make_scene *scene, const json_t *object, const char *pointer, make_umbrellas *u) {
    const json_t *value;
    const char *at;
    uint32_t pair[2];
    int status = scene_member(scene, object, pointer, "grid", &value, &at);
    if (status != CMD_OK)
        return status;
    if (!value)
        return make_complain(scene, pointer, "'grid' is missing: how many cells along x and y, such as [64, 24]");
    status = scene_wholes(scene, value, at, 2, 8192, pair);
    if (status == CMD_OK && (pair[0] == 0 || pair[1] == 0))
        return make_complain(scene, at, "no cells are too few");
    u->arrangement.grid_x = status == CMD_OK ? pair[0] : 0;
    u->arrangement.grid_y = status == CMD_OK ? pair[1] : 0;
    return status;
}

static int read_levels(make_scene *scene, const json_t *object, const char *pointer, make_umbrellas *u) {
    static const char *const known[] = {"count", "longest", "vertices", "quality", "bits", NULL};
    const json_t *value, *count;
    const char *at, *count_at;
    int status = scene_member(scene, object, pointer, "levels", &value, &at);
    if (status != CMD_OK || !value)
        return status;
    if (!json_is_object(value))
        return scene_wrong_type(scene, at, value, "an object");
    status = scene_check_keys(scene, value, at, known);
    if (status == CMD_OK)
        status = scene_member(scene, value, at, "count", &count, &count_at);
    if (status == CMD_OK && count && !(json_is_string(count) && strcmp(json_string_value(count), "all") == 0))
        status = scene_whole(scene, count, count_at, 1, UMBRELLAS_LEVELS, &u->level_count);
    if (status == CMD_OK)
        status = scene_count(scene, value, at, "longest", 4, 4096, &u->levels.longest);
    if (status == CMD_OK)
        status = scene_count(scene, value, at, "vertices", 3, 64, &u->levels.most_vertices);
    if (status == CMD_OK)
        status = scene_real(scene, value, at, "quality", 1, 100, &u->levels.quality);
    return status == CMD_OK ? scene_count(scene, value, at, "bits", 4, 16, &u->levels.bits) : status;
}

static int read_look(make_scene *scene, const json_t *object, const char *pointer, make_umbrellas *u) {
    int mode = 0;
    const json_t *value;
    const char *at;
    u->taper[0] = 0.0625;
    u->taper[1] = 0.125;
    int status = scene_member_word(scene, object, pointer, "colour_mode", "barycentric|inverse_distance", &mode);
    u->colour_mode = (zt_umbrella_colour_mode)mode;
    if (status == CMD_OK)
        status = scene_member_word(scene, object, pointer, "form", "parametric|explicit", &u->arrangement.is_explicit);
    if (status == CMD_OK)
        status = scene_real(scene, object, pointer, "vertex_jitter", 0, 0.9, &u->arrangement.vertex_jitter);
    if (status == CMD_OK)
        status = scene_real(scene, object, pointer, "colour_jitter", 0, 1, &u->arrangement.colour_jitter);
    if (status == CMD_OK)
        status = scene_real(scene, object, pointer, "prism_height", 0, 16000, &u->arrangement.prism_height);
    if (status == CMD_OK)
        status = scene_member(scene, object, pointer, "taper", &value, &at);
    if (status == CMD_OK && value)
        status = scene_reals(scene, value, at, 2, u->taper);
    if (status == CMD_OK && !(u->taper[0] >= 0 && u->taper[0] < u->taper[1] && u->taper[1] <= 0.125))
        return make_complain(scene, at, "heights taper between two sizes of a pixel, in cells, of 0 to 0.125");
    if (status == CMD_OK && !u->arrangement.is_explicit &&
        (u->arrangement.vertex_jitter > 0 || u->arrangement.colour_jitter > 0))
        return make_complain(scene, pointer, "'vertex_jitter' and 'colour_jitter' go with \"form\": \"explicit\"");
    return status;
}

static int read_seed(make_scene *scene, const json_t *object, const char *pointer, make_umbrellas *u) {
    const json_t *value;
    const char *at;
    int status = scene_member(scene, object, pointer, "seed", &value, &at);
    if (status != CMD_OK || !value)
        return status;
    if (!json_is_integer(value) || json_integer_value(value) < 0)
        return scene_wrong_type(scene, at, value, "a whole number from 0 on");
    u->seed = (uint64_t)json_integer_value(value);
    return CMD_OK;
}

int scene_umbrellas(make_scene *scene, const json_t *value, const char *pointer, const make_options *defaults,
                    make_texture *texture) {
    static const char *const known[] = {
        "comment", "seed",          "grid",          "colour_mode",  "background", "bases",  "arrangement",
        "form",    "vertex_jitter", "colour_jitter", "prism_height", "taper",      "levels", NULL};
    make_umbrellas *u = make_alloc(scene, 1, sizeof *u);
    if (!u)
        return CMD_INTERNAL;
    if (!json_is_object(value))
        return scene_wrong_type(scene, pointer, value, "an object");
    u->seed = 1;
    texture->umbrellas = u;
    texture->layer_count = 1;
    texture->semantics[0] = ZT_SEMANTIC_BASE_COLOUR;
    for (int i = 0; i < 2; i++)
        if (texture->wrap[i] == ZT_WRAP_MIRROR)
            return make_complain(scene, pointer,
                                 "umbrellas are not mirrored at the texture's sides: wrap repeat, clamp or border");
    u->arrangement.repeat_x = texture->wrap[0] == ZT_WRAP_REPEAT;
    u->arrangement.repeat_y = texture->wrap[1] == ZT_WRAP_REPEAT;
    int status = scene_check_keys(scene, value, pointer, known);
    if (status == CMD_OK)
        status = read_seed(scene, value, pointer, u);
    if (status == CMD_OK)
        status = read_grid(scene, value, pointer, u);
    if (status == CMD_OK)
        status = read_look(scene, value, pointer, u);
    if (status == CMD_OK)
        status = read_background(scene, value, pointer, defaults, texture, u);
    if (status == CMD_OK)
        status = scene_bases(scene, value, pointer, defaults, texture, u);
    if (status == CMD_OK)
        status = read_arrangement(scene, value, pointer, u);
    return status == CMD_OK ? read_levels(scene, value, pointer, u) : status;
}
