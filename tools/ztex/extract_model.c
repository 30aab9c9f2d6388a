/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A level of umbrellas as glTF 2.0: each is a fan of triangles, in rings where it is curved; those of a base share a
 * primitive with the base's picture as material. Lengths are cells of level 0: x to the right, y up, z down in the
 * texture.
 */
#include "elements.h"
#include "extract.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define RINGS 4    /* of a curved umbrella */
#define LAYER 0.01 /* cells: the whole depth of those that lie flat, so that they do not meet in one plane */
#define GROUND -0.002
#define MEMORY (UINT64_C(1) << 30) /* when nobody says */
#define FLOATS 11                  /* of a vertex: position, normal, picture, colour */

typedef struct part {
    float *vertices; /* FLOATS each */
    uint32_t *indices;
    size_t vertex_count, vertex_room, index_count, index_room;
} part;

typedef struct model {
    cmd_args *args;
    const cmd_input *input;
    const zt_umbrella_info *info;
    uint32_t level;
    const char *path;
    part *parts; /* of each base, those without a base, the ground */
    uint32_t part_count;
    float (*means)[3];
    element *e;
    size_t size; /* bytes of the .bin */
    json_t *views, *accessors, *primitives, *materials, *textures, *images;
} model;

/* ---- triangles ---------------------------------------------------------------------------------------------- */

static int grow(void **array, size_t *room, size_t wanted, size_t size) {
    if (wanted <= *room)
        return 0;
    size_t larger = wanted * 2;
    void *now = realloc(*array, larger * size);
    if (!now)
        return -1;
    *array = now;
    *room = larger;
    return 0;
}

static int reserve(part *p, size_t vertices, size_t indices) {
    void *v = p->vertices, *i = p->indices;
    int bad = grow(&v, &p->vertex_room, p->vertex_count + vertices, FLOATS * sizeof *p->vertices);
    bad |= grow(&i, &p->index_room, p->index_count + indices, sizeof *p->indices);
    p->vertices = v;
    p->indices = i;
    return bad || p->vertex_count + vertices > UINT32_MAX ? -1 : 0;
}

/* The surface of section 6: a point of the flat polygon, less the centre, in cells of level 0, becomes a point and a
 * normal in space. */
static void bend(const element *e, double reach, const double q[2], double out[3], double normal[3]) {
    double k = e->curvature, c = e->height / k, from = hypot(q[0], q[1]);
    out[0] = q[0];
    out[1] = q[1];
    out[2] = e->lift;
    normal[0] = normal[1] = 0;
    normal[2] = 1;
    if (!(e->height > 0))
        return;
    double phi = acos(1 - k) * from / reach, a = reach / sqrt(k * (2 - k));
    double r = a * sin(phi), z = c * cos(phi), scale = from > 0 ? r / from : 1;
    double sign = e->concave ? -1 : 1,
           n[3] = {sign * q[0] * scale / (a * a), sign * q[1] * scale / (a * a), z / (c * c)};
    double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    out[0] = q[0] * scale;
    out[1] = q[1] * scale;
    z += e->height - c;
    out[2] += e->concave ? e->height - z : z;
    for (int i = 0; i < 3; i++)
        normal[i] = n[i] / length;
}

/* Colours are factors of the picture where there is one. */
static void colour_of(const model *m, const element *e, uint32_t corner, double share, float out[3]) {
    for (int c = 0; c < 3; c++) {
        float value = (1.0f - (float)share) * e->colours[0][c] + (float)share * e->colours[corner][c];
        if (e->base) {
            float mean = m->means[e->base - m->info->bases][c];
            value = e->base->shows_texture ? value + mean : mean > 0.0f ? (value + mean) / mean : 1.0f;
        }
        out[c] = value < 0.0f ? 0.0f : value > 1.0f ? 1.0f : value;
    }
}

/* A vertex on the spoke to vertex `corner` (from 1 on), at a share of its length. */
static void put_vertex(const model *m, part *p, double reach, double raise, uint32_t corner, double share) {
    const element *e = m->e;
    double scale = (double)m->info->grid_x / m->info->levels[m->level].width;
    double q[2], at[3], normal[3], down = (double)m->info->grid_y / m->info->levels[m->level].height;
    q[0] = e->points[corner - 1][0] * scale * share;
    q[1] = e->points[corner - 1][1] * down * share;
    bend(e, reach, q, at, normal);
    float *v = p->vertices + FLOATS * p->vertex_count++;
    const double place[6] = {e->x * scale + at[0], at[2] + raise, e->y * down + at[1], normal[0], normal[2], normal[1]};
    for (int i = 0; i < 6; i++)
        v[i] = (float)place[i];
    for (int c = 0; c < 2; c++)
        v[6 + c] = e->base ? (float)((1 - share) * e->picture[0][c] + share * e->picture[corner][c]) : 0.0f;
    colour_of(m, e, corner, share, v + 8);
}

static void put_triangle(part *p, size_t a, size_t b, size_t c) {
    p->indices[p->index_count++] = (uint32_t)a;
    p->indices[p->index_count++] = (uint32_t)b;
    p->indices[p->index_count++] = (uint32_t)c;
}

static int put_element(const model *m, part *p, uint32_t index) {
    const element *e = m->e;
    const zt_umbrella_level *l = &m->info->levels[m->level];
    size_t first = p->vertex_count, count = e->count, rings = e->height > 0 ? RINGS : 1;
    double reach = 0, scale = (double)m->info->grid_x / l->width, raise = LAYER * (index + 1.0) / l->umbrella_count;
    if (reserve(p, 1 + rings * count, 3 * count * (2 * rings - 1)))
        return -1;
    for (size_t i = 0; i < count; i++)
        reach = fmax(reach, scale * hypot(e->points[i][0], e->points[i][1]));
    put_vertex(m, p, reach, raise, 1, 0);
    for (size_t r = 1; r <= rings; r++)
        for (uint32_t i = 1; i <= count; i++)
            put_vertex(m, p, reach, raise, i, (double)r / (double)rings);
    /* Seen from above, glTF's triangles turn the other way than the spec's; a mirrored umbrella's own turn as they
     * do. */
    for (size_t i = 0; i < count; i++) {
        size_t next = (i + 1) % count, a = first + 1 + (e->record->mirrored ? next : i);
        size_t b = first + 1 + (e->record->mirrored ? i : next);
        put_triangle(p, first, b, a);
        for (size_t r = 1; r < rings; r++, a += count, b += count) {
            put_triangle(p, a, b, b + count);
            put_triangle(p, a, b + count, a + count);
        }
    }
    return 0;
}

static int put_ground(const model *m, part *p) {
    if (reserve(p, 4, 6))
        return -1;
    for (int i = 0; i < 4; i++) {
        float x = (float)(i & 1), y = (float)(i >> 1);
        const float v[FLOATS] = {
            x * (float)m->info->grid_x, (float)GROUND, y * (float)m->info->grid_y, 0, 1, 0, x, y, 1, 1, 1};
        memcpy(p->vertices + FLOATS * p->vertex_count++, v, sizeof v);
    }
    put_triangle(p, 0, 2, 1);
    put_triangle(p, 1, 2, 3);
    return 0;
}

/* A file of a few kilobytes can ask for more vertices than there is memory. */
static int check_size(const model *m) {
    uint64_t vertices = element_all_vertices(m->info, m->level) * RINGS, limit = cmd_limits(m->args)->memory;
    limit = limit ? limit : MEMORY;
    if (vertices <= limit / (2 * FLOATS * sizeof(float)))
        return CMD_OK;
    return cmd_fail(CMD_LIMIT, "%s: the model would have up to %.0f vertices: more than --memory allows",
                    m->input->name, (double)vertices);
}

static int collect(model *m) {
    const zt_umbrella_level *l = &m->info->levels[m->level];
    int status = check_size(m);
    if (status != CMD_OK)
        return status;
    for (uint32_t i = 0; i < l->umbrella_count; i++) {
        element_of(m->info, m->level, i, m->e);
        uint32_t group = m->e->base ? (uint32_t)(m->e->base - m->info->bases) : m->info->base_count;
        if (put_element(m, &m->parts[group], i))
            return cmd_fail(CMD_INTERNAL, "out of memory");
        if (cmd_interrupted())
            return cmd_cancelled();
    }
    return put_ground(m, &m->parts[m->part_count - 1]) ? cmd_fail(CMD_INTERNAL, "out of memory") : CMD_OK;
}

/* ---- the .bin ----------------------------------------------------------------------------------------------- */

/* As glTF wants them on every machine. */
static void put_words(FILE *stream, const void *words, size_t count) {
    const unsigned char *from = words;
    for (size_t i = 0; i < count; i++, from += 4) {
        uint32_t word;
        memcpy(&word, from, 4);
        const unsigned char bytes[4] = {(unsigned char)word, (unsigned char)(word >> 8), (unsigned char)(word >> 16),
                                        (unsigned char)(word >> 24)};
        fwrite(bytes, 1, 4, stream);
    }
}

static json_int_t add_view(model *m, size_t size, int stride, int target) {
    json_t *view = json_pack("{si sI sI si}", "buffer", 0, "byteOffset", (json_int_t)m->size, "byteLength",
                             (json_int_t)size, "target", target);
    if (stride)
        json_object_set_new(view, "byteStride", json_integer(stride));
    json_array_append_new(m->views, view);
    m->size += size;
    return (json_int_t)json_array_size(m->views) - 1;
}

static json_int_t add_accessor(model *m, json_int_t view, int offset, int type, size_t count, const char *shape) {
    json_array_append_new(m->accessors, json_pack("{sI si si sI ss}", "bufferView", view, "byteOffset", offset,
                                                  "componentType", type, "count", (json_int_t)count, "type", shape));
    return (json_int_t)json_array_size(m->accessors) - 1;
}

/* Positions have to say how far they reach. */
static void add_bounds(model *m, json_int_t accessor, const part *p) {
    json_t *low = json_array(), *high = json_array(), *row = json_array_get(m->accessors, (size_t)accessor);
    for (int c = 0; c < 3; c++) {
        float least = INFINITY, most = -INFINITY;
        for (size_t i = 0; i < p->vertex_count; i++) {
            least = fminf(least, p->vertices[FLOATS * i + (size_t)c]);
            most = fmaxf(most, p->vertices[FLOATS * i + (size_t)c]);
        }
        json_array_append_new(low, json_real((double)least));
        json_array_append_new(high, json_real((double)most));
    }
    json_object_set_new(row, "min", low);
    json_object_set_new(row, "max", high);
}

enum { FLOAT = 5126, UNSIGNED = 5125, VERTICES = 34962, INDICES = 34963 };

static void add_part(model *m, const part *p, json_int_t material, FILE *stream) {
    json_int_t view = add_view(m, p->vertex_count * FLOATS * 4, FLOATS * 4, VERTICES);
    json_int_t at = add_accessor(m, view, 0, FLOAT, p->vertex_count, "VEC3");
    json_t *attributes = json_pack("{sI sI sI sI}", "POSITION", at, "NORMAL",
                                   add_accessor(m, view, 12, FLOAT, p->vertex_count, "VEC3"), "TEXCOORD_0",
                                   add_accessor(m, view, 24, FLOAT, p->vertex_count, "VEC2"), "COLOR_0",
                                   add_accessor(m, view, 32, FLOAT, p->vertex_count, "VEC3"));
    add_bounds(m, at, p);
    put_words(stream, p->vertices, p->vertex_count * FLOATS);
    view = add_view(m, p->index_count * 4, 0, INDICES);
    put_words(stream, p->indices, p->index_count);
    json_array_append_new(m->primitives, json_pack("{so sI sI}", "attributes", attributes, "indices",
                                                   add_accessor(m, view, 0, UNSIGNED, p->index_count, "SCALAR"),
                                                   "material", material));
}

/* ---- materials ---------------------------------------------------------------------------------------------- */

/* A file beside the model: its path (malloc'd) and, as glTF wants it, its escaped name. NULL: no memory. */
static char *name_beside(const model *m, const char *end, json_t **uri) {
    const char *slash = strrchr(m->path, '/'), *name = slash ? slash + 1 : m->path;
    size_t stem = strlen(m->path) - strlen(".gltf"), size = stem + strlen(end) + 1, at = 0;
    char *path = malloc(size), *escaped = malloc(3 * size);
    if (!path || !escaped) {
        free(path);
        free(escaped);
        return NULL;
    }
    snprintf(path, size, "%.*s%s", (int)stem, m->path, end);
    for (const char *c = path + (name - m->path); *c; c++) {
        int plain = (*c >= 'a' && *c <= 'z') || (*c >= 'A' && *c <= 'Z') || (*c >= '0' && *c <= '9') ||
                    strchr("-_.~", *c);
        at += (size_t)snprintf(escaped + at, 4, plain ? "%c" : "%%%02X", (unsigned char)*c);
    }
    escaped[at] = '\0';
    *uri = json_string(escaped);
    free(escaped);
    return path;
}

/* The picture of an image beside the model; *texture gets its number. */
static int add_picture(model *m, uint32_t image, const char *end, json_int_t *texture, cmd_progress *progress) {
    extract_part shown;
    json_t *uri = NULL;
    int status = extract_part_of(m->input->file, m->input->name, image, 0, &shown);
    if (status != CMD_OK)
        return status;
    char *path = name_beside(m, end, &uri);
    status = path ? extract_picture(m->args, &shown, path, progress) : cmd_fail(CMD_INTERNAL, "out of memory");
    json_array_append_new(m->images, json_pack("{so}", "uri", uri));
    json_array_append_new(m->textures,
                          json_pack("{sI si}", "source", (json_int_t)json_array_size(m->images) - 1, "sampler", 0));
    *texture = (json_int_t)json_array_size(m->textures) - 1;
    free(path);
    return status;
}

static int add_material(model *m, uint32_t group, json_int_t *material, cmd_progress *progress) {
    const zt_umbrella_info *info = m->info;
    int ground = group == m->part_count - 1, status = CMD_OK;
    uint32_t image = ZT_NONE;
    char end[32];
    json_int_t texture = 0;
    if (group < info->base_count && !info->bases[group].shows_texture)
        image = info->bases[group].source;
    if (ground && info->background_kind == ZT_BACKGROUND_IMAGE)
        image = info->background_source;
    json_t *surface = json_pack("{si sf}", "metallicFactor", 0, "roughnessFactor", 0.8);
    json_t *row = json_pack("{so sb ss}", "pbrMetallicRoughness", surface, "doubleSided", 1, "alphaMode",
                            ground || image == ZT_NONE ? "OPAQUE" : "MASK");
    json_array_append_new(m->materials, row);
    *material = (json_int_t)json_array_size(m->materials) - 1;
    if (ground && image == ZT_NONE)
        json_object_set_new(surface, "baseColorFactor",
                            json_pack("[f,f,f,i]", fmin(1, (double)info->background[0]),
                                      fmin(1, (double)info->background[1]), fmin(1, (double)info->background[2]), 1));
    if (image == ZT_NONE)
        return CMD_OK;
    snprintf(end, sizeof end, ground ? "_ground.png" : "_base%03u.png", (unsigned)group);
    status = add_picture(m, image, end, &texture, progress);
    json_object_set_new(surface, "baseColorTexture", json_pack("{sI}", "index", texture));
    return status;
}

/* ---- the model ---------------------------------------------------------------------------------------------- */

static json_t *root_of(const model *m, json_t *uri) {
    json_t *sampler = json_pack("{si si si si}", "magFilter", 9729, "minFilter", 9987, "wrapS", 33071, "wrapT", 33071);
    json_t *root = json_pack("{s{ss ss} si s[{s[i] ss}] s[{si ss}] s[{sO}]}", "asset", "version", "2.0", "generator",
                             "ztex", "scene", 0, "scenes", "nodes", 0, "name", "umbrellas", "nodes", "mesh", 0, "name",
                             "arrangement", "meshes", "primitives", m->primitives);
    json_object_set(root, "materials", m->materials);
    if (json_array_size(m->textures) > 0) {
        json_object_set(root, "textures", m->textures);
        json_object_set(root, "images", m->images);
        json_object_set_new(root, "samplers", json_pack("[o]", sampler));
    } else {
        json_decref(sampler);
    }
    json_object_set(root, "accessors", m->accessors);
    json_object_set(root, "bufferViews", m->views);
    json_object_set_new(root, "buffers", json_pack("[{so sI}]", "uri", uri, "byteLength", (json_int_t)m->size));
    return root;
}

static int write_parts(model *m, FILE *stream, cmd_progress *progress) {
    int status = CMD_OK;
    for (uint32_t i = 0; i < m->part_count && status == CMD_OK; i++) {
        json_int_t material;
        if (m->parts[i].index_count == 0)
            continue;
        status = add_material(m, i, &material, progress);
        if (status == CMD_OK)
            add_part(m, &m->parts[i], material, stream);
    }
    return status;
}

/* The model itself comes last: it names the others. */
static int write_model(model *m, cmd_progress *progress) {
    cmd_output bin = {0};
    json_t *uri = NULL;
    char *path = name_beside(m, ".bin", &uri);
    int status = path ? cmd_output_open(&bin, path, 1) : cmd_fail(CMD_INTERNAL, "out of memory");
    if (status == CMD_OK)
        status = write_parts(m, bin.stream, progress);
    status = cmd_output_end(&bin, status);
    if (status == CMD_OK) {
        json_t *root = root_of(m, json_incref(uri));
        status = cmd_json_write(m->path, root);
        json_decref(root);
    }
    json_decref(uri);
    free(path);
    return status;
}

static int fill(model *m, cmd_progress *progress) {
    zt_diag diag = {.offset = UINT64_MAX};
    m->part_count = m->info->base_count + 2;
    m->parts = calloc(m->part_count, sizeof *m->parts);
    m->means = calloc(m->info->base_count + (size_t)1, sizeof *m->means);
    m->e = malloc(sizeof *m->e);
    zt_result result = m->parts && m->means && m->e ? ZT_OK : ZT_NO_MEMORY;
    for (uint32_t i = 0; result == ZT_OK && i < m->info->base_count; i++)
        result = element_mean(m->input->file, &m->info->bases[i], m->means[i], &diag);
    if (result != ZT_OK)
        return cmd_fail_result(m->input->name, result, &diag);
    int status = collect(m);
    return status == CMD_OK ? write_model(m, progress) : status;
}

int extract_model(cmd_args *args, const cmd_input *input, uint32_t texture, uint32_t level, const char *path) {
    zt_umbrella_info info;
    cmd_progress progress;
    if (zt_get_umbrellas(input->file, texture, &info) != ZT_OK)
        return cmd_fail(CMD_USAGE, "%s: texture %u has no umbrellas", input->name, (unsigned)texture);
    if (level >= info.level_count)
        return cmd_fail(CMD_USAGE, "%s: there are %u levels, from 0 on", input->name, (unsigned)info.level_count);
    model m = {.args = args, .input = input, .info = &info, .level = level, .path = path};
    json_t **lists[] = {&m.views, &m.accessors, &m.primitives, &m.materials, &m.textures, &m.images};
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++)
        *lists[i] = json_array();
    cmd_progress_begin(&progress, args, "extracting");
    int status = fill(&m, &progress);
    cmd_progress_end(&progress);
    for (size_t i = 0; i < sizeof lists / sizeof lists[0]; i++)
        json_decref(*lists[i]);
    for (uint32_t i = 0; m.parts && i < m.part_count; i++) {
        free(m.parts[i].vertices);
        free(m.parts[i].indices);
    }
    free(m.parts);
    free(m.means);
    free(m.e);
    return status;
}
