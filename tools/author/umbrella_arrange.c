/* SPDX-License-Identifier: Apache-2.0 */
/* Level 0: many varied copies of the bases, in their places, in the file's integers. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "umbrella_scatter.h"

#define MOST (UINT32_C(1) << 24) /* umbrellas, the format's limit */
#define EXPLICIT_BITS 12         /* of a cell: vertices of explicit umbrellas */
#define TAPER_START 0.0625f
#define TAPER_END 0.125f
#define FARTHEST 16000.0 /* cells: what 1/65536 of a cell leaves in 2^30 */
#define TRIES 8          /* to move the vertices of an explicit umbrella, each time half as far */

enum { STREAM_PLACES = 1, STREAM_ORDER = 2, STREAM_LOOKS = 3, STREAM_VERTICES = 4 };

/* A copy before it is coded. */
typedef struct copy {
    author_place place;
    const author_species *species;
    double height, lift; /* cells */
    double curvature;
} copy;

typedef struct arranging {
    author_run *run;
    const author_base *bases;
    const author_arrangement *how;
    copy *copies;
    size_t count;
    double weights; /* of all species */
    author_random random;
    author_umbrellas *out;
} arranging;

/* ---- what is asked for ------------------------------------------------------------------------------------- */

static int in_range(author_range r, double low, double high) {
    return r.low >= low && r.high <= high && r.low <= r.high;
}

static const char *wrong_species(const author_species *s, uint32_t base_count) {
    if (s->base >= base_count)
        return "names a base that is not there";
    if (!(s->weight >= 0 && s->weight < 1e9))
        return "has a weight that is none";
    if (!(in_range(s->size, 0, FARTHEST) && s->size.low > 0))
        return "has a size that is none: cells above 0, the lesser first";
    if (!in_range(s->rotation, -1e6, 1e6) || !in_range(s->morph, 0, 1) || !in_range(s->strength, 0, 1))
        return "has a rotation, morph or strength out of range";
    if (!in_range(s->height, 0, 100) || !in_range(s->lift, 0, FARTHEST))
        return "has a height or lift out of range";
    if (s->ellipsoid != ZT_ELLIPSOID_FLAT && !(in_range(s->curvature, 0, 1) && s->curvature.low > 0))
        return "has a curvature out of range: above 0, up to 1";
    return NULL;
}

static author_result check(arranging *a, uint32_t base_count) {
    const author_arrangement *how = a->how;
    for (uint32_t i = 0; i < how->species_count; i++) {
        const char *wrong = wrong_species(&how->species[i], base_count);
        if (wrong)
            return author_fail(a->run, AUTHOR_BAD_INPUT, "base %u %s", how->species[i].base, wrong);
        a->weights += how->species[i].weight;
    }
    if (how->grid_x == 0 || how->grid_y == 0 || how->grid_x > 8192 || how->grid_y > 8192)
        return author_fail(a->run, AUTHOR_BAD_INPUT, "a grid has 1 to 8192 cells along a side");
    if (how->method != AUTHOR_PLACES && !(a->weights > 0))
        return author_fail(a->run, AUTHOR_BAD_INPUT, "no base has a weight above 0: nothing could be placed");
    return AUTHOR_OK;
}

/* ---- places -------------------------------------------------------------------------------------------------- */

/* How far an element may reach beyond its centre, in cells. */
static double reach_of(const arranging *a) {
    double most = 0;
    for (uint32_t i = 0; i < a->how->species_count; i++) {
        const author_species *s = &a->how->species[i];
        const author_base *base = &a->bases[s->base];
        most = fmax(most, s->size.high * base->radius / fmax(base->box_width, base->box_height));
    }
    return most;
}

/* Where the texture does not repeat, elements lie beyond its sides, too, so that these look like the rest. */
static umb_field field_of(const arranging *a) {
    const author_arrangement *how = a->how;
    double reach = reach_of(a), mx = how->repeat_x ? 0 : reach, my = how->repeat_y ? 0 : reach;
    return (umb_field){-mx, -my, how->grid_x + 2 * mx, how->grid_y + 2 * my, how->repeat_x, how->repeat_y};
}

static author_result count_places(arranging *a, const umb_field *field, uint32_t *columns, uint32_t *rows) {
    const author_arrangement *how = a->how;
    double area = field->width * field->height, wanted = how->density * area;
    if (how->method == AUTHOR_PLACES) {
        wanted = (double)how->place_count;
    } else if (how->method == AUTHOR_TILING) {
        *columns = how->columns;
        *rows = how->rows;
        wanted = (double)how->columns * how->rows;
    } else if (how->method == AUTHOR_JITTERED) {
        *columns = (uint32_t)fmax(1, floor(fmin(field->width * sqrt(how->density), MOST) + 0.5));
        *rows = (uint32_t)fmax(1, floor(fmin(field->height * sqrt(how->density), MOST) + 0.5));
        wanted = (double)*columns * *rows;
    }
    if (!(wanted >= 0 && wanted <= MOST))
        return author_fail(a->run, AUTHOR_BAD_INPUT, "%.0f umbrellas are too many: at most %u", wanted, MOST);
    a->count = (size_t)floor(wanted + 0.5);
    a->copies = author_alloc(a->run, a->count, sizeof *a->copies);
    return a->copies ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

static author_result place_all(arranging *a) {
    const author_arrangement *how = a->how;
    umb_field field = field_of(a), whole = {0, 0, how->grid_x, how->grid_y, 0, 0};
    uint32_t columns = 0, rows = 0;
    author_xy *points = NULL;
    author_result result = count_places(a, &field, &columns, &rows);
    if (result == AUTHOR_OK)
        points = author_alloc(a->run, a->count, sizeof *points);
    if (result != AUTHOR_OK || !points)
        return AUTHOR_NO_MEMORY == result || result == AUTHOR_OK ? AUTHOR_NO_MEMORY : result;
    author_random_seed(&a->random, how->seed, STREAM_PLACES);
    if (how->method == AUTHOR_POISSON)
        result = umb_scatter_discs(a->run, &field, a->count, &a->random, points);
    else if (how->method != AUTHOR_PLACES)
        umb_scatter_lattice(how->method == AUTHOR_TILING ? &whole : &field, columns, rows,
                            how->method == AUTHOR_TILING ? 0 : how->jitter,
                            how->method == AUTHOR_TILING ? how->row_shift : 0, &a->random, points);
    for (size_t i = 0; i < a->count; i++)
        a->copies[i].place = how->method == AUTHOR_PLACES
                                 ? how->places[i]
                                 : (author_place){UINT32_MAX, points[i].x, points[i].y, NAN, NAN,
                                                  NAN,        NAN,         NAN,         -1,  -1};
    free(points);
    return result;
}

/* ---- looks ---------------------------------------------------------------------------------------------------- */

static uint32_t draw_species(arranging *a) {
    double at = author_random_unit(&a->random) * a->weights;
    uint32_t i = 0;
    while (i + 1 < a->how->species_count && at >= a->how->species[i].weight)
        at -= a->how->species[i++].weight;
    return i;
}

/* Every copy takes as many numbers, so that giving one value leaves those of the others. */
static void draw(double *value, author_random *random, author_range range) {
    double drawn = umb_range(random, range);
    if (!isfinite(*value))
        *value = drawn;
}

static author_result draw_looks(arranging *a, copy *c) {
    author_place *p = &c->place;
    uint32_t species = draw_species(a);
    if (p->species == UINT32_MAX)
        p->species = species;
    if (p->species >= a->how->species_count)
        return author_fail(a->run, AUTHOR_BAD_INPUT, "a place names a base that is not there");
    const author_species *s = c->species = &a->how->species[p->species];
    const author_base *base = &a->bases[s->base];
    draw(&p->size, &a->random, s->size);
    draw(&p->rotation, &a->random, s->rotation);
    draw(&p->morph, &a->random, s->morph);
    draw(&p->lift, &a->random, s->lift);
    draw(&p->height, &a->random, s->height);
    c->curvature = umb_range(&a->random, s->curvature);
    double side = author_random_unit(&a->random);
    if (p->mirrored < 0)
        p->mirrored = side < s->mirrored;
    if (a->how->is_explicit) /* their vertices are those of the base, one by one, and go round as these do */
        p->mirrored = 0;
    double radius = base->radius * p->size / fmax(base->box_width, base->box_height);
    c->height = s->ellipsoid == ZT_ELLIPSOID_FLAT ? 0 : p->height * radius;
    c->lift = p->lift;
    if (!(p->size > 0 && p->size <= FARTHEST && fabs(p->x) <= FARTHEST && fabs(p->y) <= FARTHEST && p->morph >= 0 &&
          p->morph <= 1 && c->height >= 0 && c->lift >= 0))
        return author_fail(a->run, AUTHOR_BAD_INPUT, "the place %.3f, %.3f has a value that is out of range", p->x,
                           p->y);
    return AUTHOR_OK;
}

static int by_size(const void *left, const void *right) {
    const copy *a = left, *b = right;
    double d = b->place.size - a->place.size;
    if (d == 0)
        d = a->place.y - b->place.y;
    if (d == 0)
        d = a->place.x - b->place.x;
    return d < 0 ? -1 : d > 0;
}

static void shuffle(arranging *a) {
    author_random_seed(&a->random, a->how->seed, STREAM_ORDER);
    for (size_t i = a->count; i > 1; i--) {
        size_t k = author_random_below(&a->random, (uint32_t)i);
        copy swap = a->copies[i - 1];
        a->copies[i - 1] = a->copies[k];
        a->copies[k] = swap;
    }
}

static author_result dress_all(arranging *a) {
    author_result result = AUTHOR_OK;
    if (a->how->order == AUTHOR_ORDER_RANDOM)
        shuffle(a);
    author_random_seed(&a->random, a->how->seed, STREAM_LOOKS);
    for (size_t i = 0; result == AUTHOR_OK && i < a->count; i++)
        result = draw_looks(a, &a->copies[i]);
    if (result == AUTHOR_OK && a->how->order == AUTHOR_ORDER_SIZE)
        qsort(a->copies, a->count, sizeof *a->copies, by_size);
    return result;
}

/* ---- into the file's integers ---------------------------------------------------------------------------------- */

static author_result join_bases(arranging *a, uint32_t base_count) {
    author_umbrellas *out = a->out;
    zt_umbrella_info *info = &out->info;
    info->base_count = base_count;
    for (uint32_t i = 0; i < base_count; i++) {
        uint32_t count = a->bases[i].record.vertex_count;
        info->base_vertex_count += count;
        info->morph_vertex_count += a->bases[i].morph ? count : 0;
        info->variant_colour_count += a->bases[i].record.variant_count * (count + 1);
    }
    out->bases = author_alloc(a->run, base_count, sizeof *out->bases);
    out->base_vertices = author_alloc(a->run, info->base_vertex_count, sizeof *out->base_vertices);
    out->morph_vertices = author_alloc(a->run, info->morph_vertex_count, sizeof *out->morph_vertices);
    out->variant_colours = author_alloc(a->run, info->variant_colour_count, sizeof *out->variant_colours);
    if (!out->bases || !out->base_vertices || !out->morph_vertices || !out->variant_colours)
        return AUTHOR_NO_MEMORY;
    uint32_t vertex = 0, morph = 0, colour = 0;
    for (uint32_t i = 0; i < base_count; i++) {
        const author_base *base = &a->bases[i];
        uint32_t count = base->record.vertex_count, colours = base->record.variant_count * (count + 1);
        out->bases[i] = base->record;
        out->bases[i].first_vertex = vertex;
        out->bases[i].first_morph = base->morph ? morph : ZT_NONE;
        out->bases[i].first_colour = colour;
        memcpy(out->base_vertices + vertex, base->vertices, count * sizeof *base->vertices);
        if (base->morph)
            memcpy(out->morph_vertices + morph, base->morph, count * sizeof *base->morph);
        memcpy(out->variant_colours + colour, base->colours, colours * sizeof *base->colours);
        vertex += count;
        morph += base->morph ? count : 0;
        colour += colours;
    }
    return AUTHOR_OK;
}

static double wrapped(double value, double length, int repeat) {
    return repeat ? value - length * floor(value / length) : value;
}

static int32_t code_centre(double value, uint32_t cells, int repeat) {
    int64_t code = umb_round(wrapped(value, cells, repeat) * 65536);
    return (int32_t)(repeat && code >= (int64_t)cells * 65536 ? 0 : code);
}

static void code_variants(arranging *a, const copy *c, zt_umbrella *u) {
    uint32_t count = a->bases[c->species->base].record.variant_count;
    uint32_t first = author_random_below(&a->random, count ? count : 1);
    uint32_t second = author_random_below(&a->random, count ? count : 1);
    uint32_t weight = author_random_below(&a->random, 256);
    double strength = umb_range(&a->random, c->species->strength);
    if (count == 0)
        return;
    if (c->place.variant >= 0) {
        first = second = (uint32_t)c->place.variant < count ? (uint32_t)c->place.variant : count - 1;
        weight = 0;
    }
    u->variant_0 = (uint8_t)first;
    u->variant_1 = (uint8_t)second;
    u->variant_weight = (uint8_t)weight;
    u->strength = (uint8_t)umb_round(strength * 255);
}

static void code_ellipsoid(const copy *c, double prism, zt_umbrella *u) {
    double height = prism > 0 ? c->height / prism : 0, lift = prism > 0 ? c->lift / prism : 0;
    u->lift = (uint16_t)umb_round(fmin(lift, 1) * 65535);
    int64_t code = umb_round(fmin(height, 1) * 65535);
    u->height = (uint16_t)(code > 65535 - u->lift ? 65535 - u->lift : code);
    if (u->height == 0)
        return;
    u->ellipsoid = (uint8_t)c->species->ellipsoid;
    u->curvature = (uint16_t)umb_round(fmax(c->curvature * 65536 - 1, 0));
}

static void code_copy(arranging *a, const copy *c, double prism, zt_umbrella *u) {
    const author_base *base = &a->bases[c->species->base];
    const author_arrangement *how = a->how;
    double scale = c->place.size / fmax(base->box_width, base->box_height), cosine, sine;
    umb_turn(c->place.rotation, &cosine, &sine);
    *u = (zt_umbrella){.x = code_centre(c->place.x, how->grid_x, how->repeat_x),
                       .y = code_centre(c->place.y, how->grid_y, how->repeat_y),
                       .a = (int32_t)umb_round(scale * cosine * 65536),
                       .b = (int32_t)umb_round(scale * sine * 65536),
                       .base = (uint16_t)c->species->base,
                       .mirrored = (uint8_t)(c->place.mirrored > 0),
                       .morph = base->morph ? (uint8_t)umb_round(c->place.morph * 255) : 0};
    if (u->a == 0 && u->b == 0)
        u->a = 1;
    code_variants(a, c, u);
    code_ellipsoid(c, prism, u);
}

static author_result code_all(arranging *a) {
    author_umbrellas *out = a->out;
    double prism = a->how->prism_height;
    out->umbrellas = author_alloc(a->run, a->count, sizeof *out->umbrellas);
    out->levels = author_alloc(a->run, 1, sizeof *out->levels);
    if (!out->umbrellas || !out->levels)
        return AUTHOR_NO_MEMORY;
    for (size_t i = 0; i < a->count; i++)
        if (a->how->prism_height <= 0)
            prism = fmax(prism, a->copies[i].height + a->copies[i].lift);
    out->info.prism_height = (float)fmax(prism, 0);
    for (size_t i = 0; i < a->count; i++)
        code_copy(a, &a->copies[i], (double)out->info.prism_height, &out->umbrellas[i]);
    out->levels[0] = (zt_umbrella_level){
        .width = a->how->grid_x, .height = a->how->grid_y, .umbrella_count = (uint32_t)a->count};
    return AUTHOR_OK;
}

/* ---- explicit umbrellas ----------------------------------------------------------------------------------------- */

/* Vertices move along their rays, so that nothing folds; a turned or tiny one may yet, once it is rounded. */
static author_result code_vertices(arranging *a, const zt_umbrella *u, const author_xy *polygon, size_t count,
                                   zt_umbrella_offset *out) {
    double jitter = a->how->vertex_jitter, scale = 1 << EXPLICIT_BITS;
    for (int i = 0; i < TRIES; i++, jitter = i + 1 == TRIES ? 0 : jitter / 2) {
        for (size_t k = 0; k < count; k++) {
            double far = (1 + jitter * umb_signed(&a->random)) * scale;
            out[k] = (zt_umbrella_offset){(int32_t)umb_round(polygon[k].x * far),
                                          (int32_t)umb_round(polygon[k].y * far)};
        }
        if (umb_bad_offset(out, count) == count)
            return AUTHOR_OK;
    }
    return author_fail(a->run, AUTHOR_BAD_INPUT,
                       "a copy of base %u is too small for explicit vertices, which are in 1/%d of a cell", u->base,
                       1 << EXPLICIT_BITS);
}

static void code_offsets(arranging *a, const zt_umbrella *u, size_t count, zt_umbrella_colour *out) {
    const zt_umbrella_base *base = &a->out->bases[u->base];
    const zt_umbrella_colour *own = a->out->variant_colours + base->first_colour;
    double weight = u->variant_weight / 255.0;
    for (size_t i = 0; i <= count; i++) {
        double offset[3] = {0, 0, 0}, jitter = a->how->colour_jitter * umb_signed(&a->random);
        if (base->variant_count) {
            const zt_umbrella_colour *p = own + u->variant_0 * (count + 1) + i;
            const zt_umbrella_colour *q = own + u->variant_1 * (count + 1) + i;
            offset[0] = (1 - weight) * umb_offset(p->r) + weight * umb_offset(q->r);
            offset[1] = (1 - weight) * umb_offset(p->g) + weight * umb_offset(q->g);
            offset[2] = (1 - weight) * umb_offset(p->b) + weight * umb_offset(q->b);
        }
        out[i] = (zt_umbrella_colour){umb_offset_code(offset[0] + jitter), umb_offset_code(offset[1] + jitter),
                                      umb_offset_code(offset[2] + jitter), 0};
    }
}

static author_result make_explicit(arranging *a) {
    author_umbrellas *out = a->out;
    zt_umbrella_info *info = &out->info;
    size_t vertices = 0;
    for (size_t i = 0; i < a->count; i++)
        vertices += out->bases[out->umbrellas[i].base].vertex_count;
    if (vertices > UINT32_MAX / 4)
        return author_fail(a->run, AUTHOR_BAD_INPUT, "%zu explicit vertices are too many", vertices);
    author_xy *polygon = author_alloc(a->run, AUTHOR_VERTICES, sizeof *polygon);
    out->explicit_vertices = author_alloc(a->run, vertices, sizeof *out->explicit_vertices);
    out->explicit_colours = author_alloc(a->run, vertices + a->count, sizeof *out->explicit_colours);
    author_result result = polygon && out->explicit_vertices && out->explicit_colours ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    author_random_seed(&a->random, a->how->seed, STREAM_VERTICES);
    for (size_t i = 0; result == AUTHOR_OK && i < a->count; i++) {
        zt_umbrella *u = &out->umbrellas[i];
        size_t count = umb_polygon(info, u, 0, polygon);
        result = code_vertices(a, u, polygon, count, out->explicit_vertices + info->explicit_vertex_count);
        code_offsets(a, u, count, out->explicit_colours + info->explicit_colour_count);
        u->form = ZT_UMBRELLA_EXPLICIT;
        u->first_vertex = info->explicit_vertex_count;
        u->first_colour = info->explicit_colour_count;
        u->vertex_count = (uint16_t)count;
        u->a = u->b = 0;
        u->morph = u->variant_0 = u->variant_1 = u->variant_weight = 0;
        u->strength = u->strength ? u->strength : 255;
        info->explicit_vertex_count += (uint32_t)count;
        info->explicit_colour_count += (uint32_t)count + 1;
    }
    out->levels[0].bits = EXPLICIT_BITS;
    free(polygon);
    return result;
}

/* ---- all together ------------------------------------------------------------------------------------------------ */

void umb_show(author_umbrellas *umbrellas) {
    umbrellas->info.levels = umbrellas->levels;
    umbrellas->info.bases = umbrellas->bases;
    umbrellas->info.base_vertices = umbrellas->base_vertices;
    umbrellas->info.morph_vertices = umbrellas->morph_vertices;
    umbrellas->info.variant_colours = umbrellas->variant_colours;
    umbrellas->info.umbrellas = umbrellas->umbrellas;
    umbrellas->info.explicit_vertices = umbrellas->explicit_vertices;
    umbrellas->info.explicit_colours = umbrellas->explicit_colours;
    umbrellas->info.list_starts = umbrellas->list_starts;
    umbrellas->info.entries = umbrellas->entries;
}

static author_result list_cells(arranging *a) {
    author_umbrellas *out = a->out;
    const int repeat[2] = {a->how->repeat_x, a->how->repeat_y};
    size_t cells = (size_t)a->how->grid_x * a->how->grid_y;
    out->list_starts = author_alloc(a->run, cells + 1, sizeof *out->list_starts);
    if (!out->list_starts)
        return AUTHOR_NO_MEMORY;
    author_result result = umb_lists(a->run, &out->info, 0, repeat, out->list_starts, &out->entries,
                                     &out->info.longest_list);
    out->info.cell_count = (uint32_t)cells;
    out->info.entry_count = out->list_starts[cells];
    umb_show(out);
    return result;
}

author_result author_umbrella_arrange(author_run *run, const author_base *bases, uint32_t base_count,
                                      const author_arrangement *how, author_umbrellas *out) {
    arranging a = {.run = run, .bases = bases, .how = how, .out = out};
    *out = (author_umbrellas){.info = {.grid_x = how->grid_x,
                                       .grid_y = how->grid_y,
                                       .level_count = 1,
                                       .background_source = ZT_NONE,
                                       .taper_start = TAPER_START,
                                       .taper_end = TAPER_END}};
    author_result result = check(&a, base_count);
    if (result == AUTHOR_OK)
        result = place_all(&a);
    if (result == AUTHOR_OK)
        result = dress_all(&a);
    if (result == AUTHOR_OK)
        result = join_bases(&a, base_count);
    if (result == AUTHOR_OK)
        result = code_all(&a);
    out->info.umbrella_count = (uint32_t)a.count;
    umb_show(out);
    if (result == AUTHOR_OK && how->is_explicit)
        result = make_explicit(&a);
    umb_show(out);
    if (result == AUTHOR_OK)
        result = list_cells(&a);
    free(a.copies);
    if (result != AUTHOR_OK)
        author_umbrellas_release(out);
    return result;
}

void author_umbrellas_release(author_umbrellas *u) {
    free(u->levels);
    free(u->bases);
    free(u->base_vertices);
    free(u->morph_vertices);
    free(u->variant_colours);
    free(u->umbrellas);
    free(u->explicit_vertices);
    free(u->explicit_colours);
    free(u->list_starts);
    free(u->entries);
    *u = (author_umbrellas){0};
}
