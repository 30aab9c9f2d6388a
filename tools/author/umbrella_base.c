/* SPDX-License-Identifier: Apache-2.0 */
/* A base out of a picture: outline, centre, morph, cut-out, all in the file's integers. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "umbrella_private.h"

#define THRESHOLD 0.1
#define TOLERANCE 0.1
#define VERTICES 48
#define TEXELS 256
#define SPLITS 16       /* a morph splits sides that are longer than this part of the outline */
#define HARMONICS 3     /* of a generated morph */
#define MARGIN 2        /* texels around what is cut out */
#define FULL 65535.0    /* of a position in the picture */
#define SHRINK 0.8      /* a morph that folds */
#define LARGEST 1048576 /* texels along a side of what is cut out */

typedef struct building {
    author_run *run;
    const author_base_input *input;
    author_picture coverage; /* no texels: none is known */
    author_outline outline;  /* texels of the picture */
    author_outline morph;    /* likewise; empty: none */
    author_xy centre;
    double x0, y0, width, height; /* what the base's picture shows of that */
    author_base *out;
} building;

author_result umb_coverage(author_run *run, const author_picture *picture, const author_base_input *input,
                           author_picture *coverage) {
    double tolerance = input->tolerance > 0 ? input->tolerance : TOLERANCE;
    if (input->keyed)
        return author_umbrella_key(run, picture, input->key, tolerance, coverage);
    author_result result = author_picture_create(run, picture->width, picture->height, 1, coverage);
    size_t count = (size_t)picture->width * picture->height, n = picture->channels;
    for (size_t i = 0; result == AUTHOR_OK && i < count; i++)
        coverage->texels[i] = n == 2 || n == 4 ? picture->texels[i * n + n - 1] : 1.0f;
    return result;
}

/* ---- outline and centre ------------------------------------------------------------------------------------- */

static author_result copy_outline(author_run *run, const author_outline *from, author_outline *to) {
    to->points = author_alloc(run, from->count, sizeof *to->points);
    if (!to->points)
        return AUTHOR_NO_MEMORY;
    memcpy(to->points, from->points, from->count * sizeof *to->points);
    to->count = from->count;
    return AUTHOR_OK;
}

static void turn_round(author_outline *o) {
    for (size_t i = 0; i < o->count / 2; i++) {
        author_xy point = o->points[i];
        o->points[i] = o->points[o->count - 1 - i];
        o->points[o->count - 1 - i] = point;
    }
}

static uint32_t most_vertices(const author_base_input *input) {
    return input->most_vertices ? input->most_vertices : VERTICES;
}

static author_result given_outline(building *b) {
    const author_base_input *input = b->input;
    size_t count = input->outline->count;
    if (count < 3)
        return author_fail(b->run, AUTHOR_BAD_INPUT, "an outline has at least 3 vertices, not %zu", count);
    if (input->morph && input->morph->count != count)
        return author_fail(b->run, AUTHOR_BAD_INPUT,
                           "the morph has %zu vertices and the outline %zu: each vertex needs a second position",
                           input->morph->count, count);
    author_result result = copy_outline(b->run, input->outline, &b->outline);
    if (result == AUTHOR_OK && input->morph)
        result = copy_outline(b->run, input->morph, &b->morph);
    if (result == AUTHOR_OK && author_outline_area(&b->outline) < 0) {
        turn_round(&b->outline);
        turn_round(&b->morph);
    }
    /* Curves that were drawn have been flattened into many vertices; with second positions they belong together and
     * stay. */
    if (result == AUTHOR_OK && !input->morph)
        result = author_umbrella_simplify(b->run, &b->outline, most_vertices(input));
    return result;
}

static author_result find_outline(building *b) {
    const author_base_input *input = b->input;
    author_result result = AUTHOR_OK;
    if (input->picture && (!input->outline || input->keyed))
        result = umb_coverage(b->run, input->picture, input, &b->coverage);
    if (result != AUTHOR_OK)
        return result;
    if (input->outline)
        return given_outline(b);
    if (!input->picture)
        return author_fail(b->run, AUTHOR_BAD_INPUT, "a base that shows a texture needs an outline");
    result = author_umbrella_trace(b->run, &b->coverage, input->threshold > 0 ? input->threshold : THRESHOLD,
                                   &b->outline);
    return result == AUTHOR_OK ? author_umbrella_simplify(b->run, &b->outline, most_vertices(input)) : result;
}

static author_result fail_star(const building *b, const author_outline *outline, size_t bad, const char *what) {
    author_xy p = outline->points[bad < outline->count ? bad : 0];
    return author_fail(
        b->run, AUTHOR_BAD_INPUT,
        "the %s is not star-shaped: vertex %zu at %.1f, %.1f is not seen from the centre %.1f, %.1f. Give "
        "another centre, draw the outline anew, or let it be repaired",
        what, bad, p.x, p.y, b->centre.x, b->centre.y);
}

static author_result find_centre(building *b) {
    const author_base_input *input = b->input;
    author_xy kernel;
    int seen = author_outline_kernel(&b->outline, &kernel) > 0;
    b->centre = author_outline_centroid(&b->outline);
    if (input->centre_kind == AUTHOR_CENTRE_GIVEN)
        b->centre = input->centre;
    else if (input->centre_kind == AUTHOR_CENTRE_KERNEL && seen)
        b->centre = kernel;
    size_t bad = author_outline_bad_vertex(&b->outline, b->centre);
    if (bad == b->outline.count)
        return AUTHOR_OK;
    if (!input->repair || b->morph.count)
        return fail_star(b, &b->outline, bad, "outline");
    author_result result = author_outline_repair(b->run, &b->outline, b->centre);
    return result == AUTHOR_OK ? author_umbrella_simplify(b->run, &b->outline, most_vertices(input)) : result;
}

/* ---- morph -------------------------------------------------------------------------------------------------- */

static double side_length(const author_outline *o, size_t i) {
    author_xy d = umb_less(o->points[(i + 1) % o->count], o->points[i]);
    return sqrt(d.x * d.x + d.y * d.y);
}

/* Long straight sides get vertices, so that they can bend. */
static author_result split_sides(building *b) {
    author_outline *o = &b->outline;
    double all = 0;
    for (size_t i = 0; i < o->count; i++)
        all += side_length(o, i);
    author_xy *points = author_alloc(b->run, o->count + SPLITS + 1, sizeof *points);
    if (!points)
        return AUTHOR_NO_MEMORY;
    size_t count = 0;
    for (size_t i = 0; i < o->count; i++) {
        size_t pieces = 1 + (size_t)(side_length(o, i) * SPLITS / all);
        for (size_t k = 0; k < pieces; k++)
            points[count++] = umb_mix(o->points[i], o->points[(i + 1) % o->count], (double)k / (double)pieces);
    }
    free(o->points);
    *o = (author_outline){points, count};
    return AUTHOR_OK;
}

/* Waves around the outline, in and out and along it. */
static author_result generate_morph(building *b) {
    author_random random;
    double waves[HARMONICS][4], amount = b->input->morph_amount;
    author_result result = split_sides(b);
    if (result == AUTHOR_OK)
        result = copy_outline(b->run, &b->outline, &b->morph);
    if (result != AUTHOR_OK)
        return result;
    author_random_seed(&random, b->input->seed, b->input->stream);
    for (int h = 0; h < HARMONICS; h++)
        for (int k = 0; k < 4; k++)
            waves[h][k] = umb_signed(&random) / (h + 1);
    for (size_t i = 0; i < b->outline.count; i++) {
        author_xy d = umb_less(b->outline.points[i], b->centre);
        double out = 0, along = 0, c, s;
        for (int h = 0; h < HARMONICS; h++) {
            umb_turn((h + 1) * (double)i / (double)b->outline.count, &c, &s);
            out += waves[h][0] * c + waves[h][1] * s;
            along += waves[h][2] * c + waves[h][3] * s;
        }
        out *= amount;
        along *= amount / 2;
        b->morph.points[i] = (author_xy){b->centre.x + d.x * (1 + out) - d.y * along,
                                         b->centre.y + d.y * (1 + out) + d.x * along};
    }
    return AUTHOR_OK;
}

/* ---- the file's integers ------------------------------------------------------------------------------------- */

static void widen(const author_outline *o, author_xy box[2]) {
    for (size_t i = 0; i < o->count; i++) {
        box[0] = (author_xy){fmin(box[0].x, o->points[i].x), fmin(box[0].y, o->points[i].y)};
        box[1] = (author_xy){fmax(box[1].x, o->points[i].x), fmax(box[1].y, o->points[i].y)};
    }
}

static author_result cut_picture(building *b) {
    const author_base_input *input = b->input;
    author_xy box[2] = {b->centre, b->centre};
    widen(&b->outline, box);
    widen(&b->morph, box);
    double longer = fmax(box[1].x - box[0].x, box[1].y - box[0].y);
    uint32_t texels = input->texels ? input->texels : TEXELS;
    if (!(longer > 0 && longer < LARGEST && fabs(box[0].x) < LARGEST && fabs(box[0].y) < LARGEST))
        return author_fail(b->run, AUTHOR_BAD_INPUT, "the outline is empty, or far too large");
    uint32_t factor = (uint32_t)ceil(longer / texels), margin = MARGIN * factor;
    umb_cut cut = {(int64_t)floor(box[0].x) - margin, (int64_t)floor(box[0].y) - margin, 0, 0, factor};
    cut.width = (uint32_t)((int64_t)ceil(box[1].x) + margin - cut.x0 + factor - 1) / factor;
    cut.height = (uint32_t)((int64_t)ceil(box[1].y) + margin - cut.y0 + factor - 1) / factor;
    b->x0 = (double)cut.x0;
    b->y0 = (double)cut.y0;
    b->width = (double)cut.width * factor;
    b->height = (double)cut.height * factor;
    return umb_cut_out(b->run, input->picture, b->coverage.texels ? &b->coverage : NULL, &cut, &b->out->picture);
}

static author_result place_picture(building *b) {
    const author_base_input *input = b->input;
    if (input->picture)
        return cut_picture(b);
    author_xy box[2] = {b->centre, b->centre};
    widen(&b->outline, box);
    widen(&b->morph, box);
    b->width = input->width;
    b->height = input->height;
    if (box[0].x < 0 || box[0].y < 0 || box[1].x > b->width || box[1].y > b->height)
        return author_fail(b->run, AUTHOR_BAD_INPUT, "the outline reaches beyond the texture that the base shows");
    return AUTHOR_OK;
}

static zt_umbrella_texel code_point(const building *b, author_xy p) {
    double x = (p.x - b->x0) / b->width * FULL, y = (p.y - b->y0) / b->height * FULL;
    return (zt_umbrella_texel){(uint16_t)umb_round(fmin(fmax(x, 0), FULL)),
                               (uint16_t)umb_round(fmin(fmax(y, 0), FULL))};
}

static void offsets_of(const zt_umbrella_texel *points, size_t count, zt_umbrella_texel centre,
                       zt_umbrella_offset *out) {
    for (size_t i = 0; i < count; i++)
        out[i] = (zt_umbrella_offset){(int32_t)points[i].x - (int32_t)centre.x,
                                      (int32_t)points[i].y - (int32_t)centre.y};
}

static int64_t cross_of(zt_umbrella_offset a, zt_umbrella_offset b) {
    return (int64_t)a.x * b.y - (int64_t)a.y * b.x;
}

/* Rule 8308. Returns the first bad vertex, or count. */
static size_t bad_mixture(const zt_umbrella_offset *d, const zt_umbrella_offset *e, size_t count) {
    size_t bad = umb_bad_offset(e, count);
    for (size_t i = 0; i < bad; i++) {
        size_t j = i + 1 < count ? i + 1 : 0;
        if (cross_of(d[i], e[j]) + cross_of(e[i], d[j]) < 0)
            return i;
    }
    return bad;
}

static void code_points(building *b) {
    author_base *out = b->out;
    out->record.centre = code_point(b, b->centre);
    for (size_t i = 0; i < b->outline.count; i++) {
        out->vertices[i] = code_point(b, b->outline.points[i]);
        if (out->morph)
            out->morph[i] = code_point(b, b->morph.points[i]);
    }
}

static void drop_vertex(author_outline *o, size_t index) {
    memmove(o->points + index, o->points + index + 1, (o->count - index - 1) * sizeof *o->points);
    o->count--;
}

/* Rounding may take the star shape from sectors that are thinner than a step; such a vertex can go. */
static author_result code_outline(building *b, zt_umbrella_offset *d) {
    for (;;) {
        code_points(b);
        offsets_of(b->out->vertices, b->outline.count, b->out->record.centre, d);
        size_t bad = umb_bad_offset(d, b->outline.count);
        if (bad == b->outline.count)
            return AUTHOR_OK;
        if (b->input->morph || b->outline.count <= 3)
            return fail_star(b, &b->outline, bad, "outline");
        drop_vertex(&b->outline, bad);
        if (b->morph.count)
            drop_vertex(&b->morph, bad);
    }
}

static author_result code_morph(building *b, const zt_umbrella_offset *d, zt_umbrella_offset *e) {
    size_t count = b->outline.count, bad = 0;
    for (int i = 0; i < 40; i++) {
        offsets_of(b->out->morph, count, b->out->record.centre, e);
        bad = bad_mixture(d, e, count);
        if (bad == count)
            return AUTHOR_OK;
        if (b->input->morph)
            break;
        for (size_t k = 0; k < count; k++)
            b->morph.points[k] = umb_mix(b->outline.points[k], b->morph.points[k], SHRINK);
        code_points(b);
    }
    return fail_star(b, &b->morph, bad, "morph, or a mixture of outline and morph,");
}

static author_result code_base(building *b) {
    author_base *out = b->out;
    size_t room = b->outline.count;
    zt_umbrella_offset *d = author_alloc(b->run, 2 * room, sizeof *d);
    out->vertices = author_alloc(b->run, room, sizeof *out->vertices);
    if (b->morph.count)
        out->morph = author_alloc(b->run, room, sizeof *out->morph);
    author_result result = d && out->vertices && (out->morph || !b->morph.count) ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    if (result == AUTHOR_OK && room > AUTHOR_VERTICES)
        result = author_fail(b->run, AUTHOR_BAD_INPUT, "%zu vertices are too many: at most %d", room, AUTHOR_VERTICES);
    if (result == AUTHOR_OK)
        result = code_outline(b, d);
    if (result == AUTHOR_OK && out->morph)
        result = code_morph(b, d, d + room);
    free(d);
    out->record.vertex_count = (uint16_t)b->outline.count;
    out->record.first_morph = out->morph ? 0 : ZT_NONE;
    double aspect = b->height / b->width * 65536;
    if (result == AUTHOR_OK && !(aspect >= 0.5 && aspect <= 0x1p24))
        result = author_fail(b->run, AUTHOR_BAD_INPUT, "the picture is too long and narrow");
    out->record.aspect = (uint32_t)umb_round(fmax(aspect, 1));
    return result;
}

/* ---- figures ------------------------------------------------------------------------------------------------- */

static void measure(building *b) {
    author_base *out = b->out;
    author_xy box[2] = {b->outline.points[0], b->outline.points[0]};
    widen(&b->outline, box);
    out->box_width = (box[1].x - box[0].x) / b->width;
    out->box_height = (box[1].y - box[0].y) / b->width;
    out->clearance = INFINITY;
    for (size_t i = 0; i < b->outline.count; i++) {
        author_xy d = umb_less(b->outline.points[i], b->centre);
        author_xy e = umb_less(b->outline.points[(i + 1) % b->outline.count], b->centre);
        author_xy m = b->morph.count ? umb_less(b->morph.points[i], b->centre) : d;
        double far = fmax(d.x * d.x + d.y * d.y, m.x * m.x + m.y * m.y);
        out->radius = fmax(out->radius, sqrt(far) / b->width);
        out->clearance = fmin(out->clearance, umb_cross(d, e) / side_length(&b->outline, i) / b->width);
    }
    double sum[4] = {0, 0, 0, 0};
    for (size_t i = 0; i < (size_t)out->picture.width * out->picture.height; i++)
        for (int c = 0; c < 4; c++)
            sum[c] += (c < 3 ? (double)out->picture.texels[4 * i + (size_t)c] : 1) *
                      (double)out->picture.texels[4 * i + 3];
    for (int c = 0; c < 3; c++)
        out->mean[c] = sum[3] > 0 ? (float)(sum[c] / sum[3]) : 0.5f;
}

author_result author_umbrella_base(author_run *run, const author_base_input *input, author_base *out) {
    building b = {.run = run, .input = input, .out = out};
    *out = (author_base){0};
    author_result result = find_outline(&b);
    if (result == AUTHOR_OK)
        result = find_centre(&b);
    if (result == AUTHOR_OK && input->morph_amount > 0 && !b.morph.count)
        result = generate_morph(&b);
    if (result == AUTHOR_OK)
        result = place_picture(&b);
    if (result == AUTHOR_OK)
        result = code_base(&b);
    if (result == AUTHOR_OK) {
        measure(&b);
        result = umb_variants(run, input, b.coverage.texels ? &b.coverage : NULL, &b.outline, b.centre, out);
    }
    author_picture_release(&b.coverage);
    author_outline_release(&b.outline);
    author_outline_release(&b.morph);
    if (result != AUTHOR_OK)
        author_base_release(out);
    return result;
}

void author_base_release(author_base *base) {
    author_picture_release(&base->picture);
    free(base->vertices);
    free(base->morph);
    free(base->colours);
    *base = (author_base){0};
}
