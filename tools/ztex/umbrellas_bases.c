/* SPDX-License-Identifier: Apache-2.0 */
/* Bases out of the pictures, drawings and lists that a scene names. */
#include "umbrellas.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "drawing.h"
#include "make_author.h"

#define DRAWN 4          /* times the texels that a base gets, along each side: a drawing's pixels */
#define DRAWN_MOST 8192  /* pixels along a side */
#define TEXELS 256       /* of a base's longer side, when nobody says */
#define TOLERANCE 0.0005 /* of the unit square: how far curves of drawn outlines may be off */

typedef struct making {
    make_store *store;
    const make_texture *texture;
    const make_size *sizes;
    author_run *run;
    const make_umbrella_base *base;
    author_base_input input;
    author_picture picture;
    author_outline outline, morph; /* in texels */
    author_variant *variants;
    author_picture *references;
} making;

static int load(making *m, const make_image *image, author_picture *out) {
    const char *path = image->files[0].path;
    uint32_t texels = (m->input.texels ? m->input.texels : TEXELS) * DRAWN;
    char error[DRAWING_ERROR];
    img_info info;
    if (!drawing_is_one(path))
        return make_load_picture(m->store, image, ZT_SEMANTIC_BASE_COLOUR, out, &info);
    cmd_verbose(m->store->args, "reading %s", path);
    int status = drawing_picture(m->store->args, path, texels < DRAWN_MOST ? texels : DRAWN_MOST, out, error);
    return status == CMD_INVALID ? make_fail_picture(m->store, image, path, error) : status;
}

/* ---- outlines -------------------------------------------------------------------------------------------------- */

/* Equal neighbours are one vertex; a drawing's closed path ends where it began. */
static void drop_doubles(author_outline *o) {
    size_t kept = 0;
    for (size_t i = 0; i < o->count; i++)
        if (kept == 0 || o->points[i].x != o->points[kept - 1].x || o->points[i].y != o->points[kept - 1].y)
            o->points[kept++] = o->points[i];
    while (kept > 1 && o->points[0].x == o->points[kept - 1].x && o->points[0].y == o->points[kept - 1].y)
        kept--;
    o->count = kept;
}

static int read_drawing(making *m, const make_outline *from, author_outline *out) {
    char error[DRAWING_ERROR];
    double *points;
    int status = drawing_first_path(m->store->args, from->drawing, TOLERANCE, &points, &out->count, error);
    if (status == CMD_INVALID)
        return make_complain(m->store->scene, m->base->pointer, "%s: %s", from->drawing, error);
    if (status != CMD_OK)
        return status;
    if (out->count == 0) {
        free(points);
        return make_complain(m->store->scene, m->base->pointer, "%s has no path that could be an outline",
                             from->drawing);
    }
    out->points = malloc(out->count * sizeof *out->points);
    for (size_t i = 0; out->points && i < out->count; i++)
        out->points[i] = (author_xy){points[2 * i], points[2 * i + 1]};
    free(points);
    return out->points ? CMD_OK : cmd_fail(CMD_INTERNAL, "out of memory");
}

static int load_outline(making *m, const make_outline *from, author_outline *out) {
    int status = CMD_OK;
    if (!from->drawing && !from->count)
        return CMD_OK;
    if (from->drawing) {
        status = read_drawing(m, from, out);
    } else {
        out->points = malloc(from->count * sizeof *out->points);
        out->count = out->points ? from->count : 0;
        if (!out->points)
            return cmd_fail(CMD_INTERNAL, "out of memory");
        memcpy(out->points, from->points, from->count * sizeof *out->points);
    }
    for (size_t i = 0; status == CMD_OK && i < out->count; i++) {
        out->points[i].x *= m->input.width;
        out->points[i].y *= m->input.height;
    }
    drop_doubles(out);
    return status;
}

static int load_outlines(making *m) {
    int status = load_outline(m, &m->base->outline, &m->outline);
    if (status == CMD_OK)
        status = load_outline(m, &m->base->morph, &m->morph);
    if (m->outline.count)
        m->input.outline = &m->outline;
    if (m->morph.count)
        m->input.morph = &m->morph;
    return status;
}

/* ---- variants -------------------------------------------------------------------------------------------------- */

static int load_variants(making *m) {
    uint32_t count = m->input.variant_count;
    m->variants = calloc(count + 1, sizeof *m->variants);
    m->references = calloc(count + 1, sizeof *m->references);
    int status = m->variants && m->references ? CMD_OK : cmd_fail(CMD_INTERNAL, "out of memory");
    for (uint32_t i = 0; status == CMD_OK && i < count; i++) {
        m->variants[i] = m->base->variants[i].variant;
        if (!m->base->variants[i].image)
            continue;
        status = load(m, m->base->variants[i].image, &m->references[i]);
        m->variants[i].picture = &m->references[i];
    }
    m->input.variants = m->variants;
    return status;
}

static void release(making *m) {
    author_picture_release(&m->picture);
    author_outline_release(&m->outline);
    author_outline_release(&m->morph);
    for (uint32_t i = 0; m->references && i < m->input.variant_count; i++)
        author_picture_release(&m->references[i]);
    free(m->references);
    free(m->variants);
}

/* ---- a base ---------------------------------------------------------------------------------------------------- */

static int make_base(making *m, author_base *out) {
    int status = CMD_OK;
    m->input.width = m->base->texture != ZT_NONE ? m->sizes[m->base->texture].width : 0;
    m->input.height = m->base->texture != ZT_NONE ? m->sizes[m->base->texture].height : 0;
    if (m->base->image) {
        status = load(m, m->base->image, &m->picture);
        m->input.picture = &m->picture;
        m->input.width = m->picture.width;
        m->input.height = m->picture.height;
    }
    if (status == CMD_OK)
        status = load_outlines(m);
    if (status == CMD_OK)
        status = load_variants(m);
    if (status != CMD_OK)
        return status;
    m->input.centre.x *= m->input.width;
    m->input.centre.y *= m->input.height;
    author_result result = author_umbrella_base(m->run, &m->input, out);
    if (result == AUTHOR_BAD_INPUT)
        return make_complain(m->store->scene, m->base->pointer, "%s%s%s",
                             m->base->image ? m->base->image->files[0].path : "", m->base->image ? ": " : "",
                             m->run->error);
    return make_author_status(result, m->run);
}

int umbrellas_make_bases(make_store *store, const make_texture *texture, const make_size *sizes, author_run *run,
                         author_base **out) {
    const make_umbrellas *u = texture->umbrellas;
    author_base *bases = calloc(u->base_count, sizeof *bases);
    int status = bases ? CMD_OK : cmd_fail(CMD_INTERNAL, "out of memory");
    for (uint32_t i = 0; status == CMD_OK && i < u->base_count; i++) {
        making m = {store, texture, sizes, run, .base = &u->bases[i], .input = u->bases[i].input};
        m.input.key = u->bases[i].input.key ? u->bases[i].key : NULL;
        m.input.seed = u->seed;
        m.input.stream = 1000 + 2 * (uint64_t)i;
        status = make_base(&m, &bases[i]);
        release(&m);
    }
    *out = bases;
    return status;
}
