/* SPDX-License-Identifier: Apache-2.0 */
/* The payload of zipmaps: rules 8101 to 8111, decoding and encoding (spec/zipmap.md section 2). */
#include "zipmap_payload.h"

#include <math.h>
#include <string.h>

#include "file_format.h"

enum { HEADER_SIZE = 16, MATRIX_ENTRIES = 9 };

/* ---- matrices (spec/zipmap.md, "Order of operations") ------------------------------------------ */

void zt__multiply(const double p[9], const double q[9], double out[9]) {
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++)
            out[3 * r + c] = (p[3 * r] * q[c] + p[3 * r + 1] * q[3 + c]) + p[3 * r + 2] * q[6 + c];
    }
}

double zt__adjugate(const double m[9], double a[9]) {
    for (int r = 0; r < 3; r++) {
        for (int c = 0; c < 3; c++) {
            int i = (c + 1) % 3;
            int j = (c + 2) % 3;
            int x = (r + 1) % 3;
            int y = (r + 2) % 3;
            a[3 * r + c] = m[3 * i + x] * m[3 * j + y] - m[3 * j + x] * m[3 * i + y];
        }
    }
    return (m[0] * a[0] + m[1] * a[3]) + m[2] * a[6];
}

static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

/* ---- memory ------------------------------------------------------------------------------------ */

zt_result zt__zipmap_new(zt__memory *memory, uint32_t patch_count, uint32_t layer_count, zt_diag *diag,
                         zt__zipmap **out) {
    /* Both factors have 32 bits, and the sum stays far below 2^63 for the 2^24 patches and 32 layers of the rules. */
    uint64_t n = patch_count;
    uint64_t size = 0;
    size_t bytes;
    void *block;
    *out = NULL;
    zt__take_part(&size, sizeof(zt__zipmap));
    uint64_t matrices = zt__take_part(&size, n * sizeof(double[9]));
    uint64_t composed = zt__take_part(&size, n * sizeof(double[9]));
    uint64_t parents = zt__take_part(&size, n * 4);
    uint64_t sources = zt__take_part(&size, n * 4 * layer_count);
    uint64_t masks = zt__take_part(&size, n * 4);
    uint64_t kinds = zt__take_part(&size, n);
    if (!zt__to_size(size, &bytes))
        return zt__fail(diag, ZT_NO_MEMORY, 0, ZT__NO_OFFSET, "the zipmap is too large");
    ZT_TRY(zt__alloc(memory, 1, bytes, diag, &block));
    char *base = block;
    zt__zipmap *z = block;
    z->patch_count = patch_count;
    z->layer_count = layer_count;
    z->block_size = size;
    z->matrices = (double(*)[9])(void *)(base + matrices);
    z->composed = (double(*)[9])(void *)(base + composed);
    z->parents = (uint32_t *)(void *)(base + parents);
    z->sources = (uint32_t *)(void *)(base + sources);
    z->masks = (uint32_t *)(void *)(base + masks);
    z->source_kinds = (uint8_t *)(base + kinds);
    *out = z;
    return ZT_OK;
}

/* ---- rules -------------------------------------------------------------------------------------- */

typedef struct checking {
    zt__sink *sink;
    zt__zipmap *zipmap;
    const zt__payload_scope *scope;
    uint64_t offset;
    uint32_t root_layers; /* array layers of the root's first image */
} checking;

/* The path is made only here: a name for each of a million patches that are right would be slow. */
static zt_result broken(const checking *c, uint32_t rule, uint32_t patch, const char *text) {
    zt__enter(c->sink, "ZPMP/texture %u/patch %u", c->scope->texture, patch);
    return zt__report(c->sink, rule, c->offset, "patch %u: %s", patch, text);
}

/* By value: negative zero is left to rule 8109. */
static bool is_identity(const double m[9]) {
    for (int k = 0; k < MATRIX_ENTRIES; k++) {
        if (!(m[k] == identity[k]))
            return false;
    }
    return true;
}

/* Behind a finding the patch is made what it should be, so that nothing later meets the wrong value. */
static zt_result check_root(const checking *c) {
    zt__zipmap *z = c->zipmap;
    if (z->parents[0] != 0 || z->source_kinds[0] != 0 || z->masks[0] != ZT_NONE)
        ZT_TRY(broken(c, 8102, 0, "the root has parent 0, images as its source, and no mask"));
    if (!is_identity(z->matrices[0])) {
        ZT_TRY(broken(c, 8102, 0, "the root's matrix is not the identity"));
        memcpy(z->matrices[0], identity, sizeof identity);
    }
    z->parents[0] = 0;
    z->source_kinds[0] = 0;
    z->masks[0] = ZT_NONE;
    return ZT_OK;
}

static uint32_t source_of(const zt__zipmap *z, uint32_t layer, uint32_t patch) {
    return z->sources[(size_t)layer * z->patch_count + patch];
}

/* 8105 for a patch that shows a texture. */
static zt_result check_texture_source(const checking *c, uint32_t i) {
    const zt__zipmap *z = c->zipmap;
    uint32_t texture = source_of(z, 0, i);
    for (uint32_t l = 1; l < z->layer_count; l++) {
        if (source_of(z, l, i) != texture)
            return broken(c, 8105, i, "the layers show different textures");
    }
    if (texture >= c->scope->texture)
        return broken(c, 8105, i, "the texture that it shows does not come before the zipmap");
    if (c->scope->texture_layers(c->scope->user, texture) != z->layer_count)
        return broken(c, 8105, i, "the texture that it shows has another number of layers");
    return ZT_OK;
}

/* 8108 for one image. */
static zt_result check_shape(const checking *c, uint32_t i, const zt__image_record *image) {
    if (!image) /* behind a finding that the sink let pass */
        return ZT_OK;
    if (image->depth != 1 || image->layer_kind == ZT_LAYERS_CUBE)
        return broken(c, 8108, i, "a volume or cube map");
    if (image->layers != 1 && image->layers != c->root_layers)
        return broken(c, 8108, i, "neither one array layer nor as many as the root");
    return ZT_OK;
}

/* 8105 and 8108 for a patch that shows images. */
static zt_result check_images(checking *c, uint32_t i) {
    const zt__payload_scope *scope = c->scope;
    for (uint32_t l = 0; l < c->zipmap->layer_count; l++) {
        uint32_t index = source_of(c->zipmap, l, i);
        const zt__image_record *image = index < scope->image_count ? scope->image_of(scope->user, index) : NULL;
        if (!image)
            ZT_TRY(broken(c, 8105, i, "an image that is not there"));
        if (image && i == 0 && l == 0)
            c->root_layers = image->layers;
        ZT_TRY(check_shape(c, i, image));
    }
    return ZT_OK;
}

/* 8106 to 8108. */
static zt_result check_coverage(const checking *c, uint32_t i) {
    const zt__zipmap *z = c->zipmap;
    const zt__payload_scope *scope = c->scope;
    uint32_t mask = z->masks[i];
    if (mask != ZT_NONE) {
        const zt__image_record *image = mask < scope->image_count ? scope->image_of(scope->user, mask) : NULL;
        const zt_format_info *format = image ? zt_find_format(image->format) : NULL;
        if (!image)
            ZT_TRY(broken(c, 8106, i, "a mask that is not there"));
        if (image && (!format || format->channels != 1))
            ZT_TRY(broken(c, 8106, i, "a mask of more than one channel, or of an unknown format"));
        ZT_TRY(check_shape(c, i, image));
    }
    if (i == 0 || z->source_kinds[i] != 0)
        return ZT_OK;
    uint32_t first = source_of(z, 0, i);
    const zt__image_record *image = first < scope->image_count ? scope->image_of(scope->user, first) : NULL;
    if (image && (image->alpha_mode != 0) == (mask != ZT_NONE))
        return broken(c, 8107, i, mask != ZT_NONE ? "alpha and a mask" : "neither alpha nor mask");
    return ZT_OK;
}

/* 8109 to 8111: fills composed[i], with the identity behind a finding. The parent is below i. */
static zt_result check_matrix(const checking *c, uint32_t i) {
    zt__zipmap *z = c->zipmap;
    const double *m = z->matrices[i];
    double *all = z->composed[i];
    double a[9];
    memcpy(all, identity, sizeof identity);
    for (int k = 0; k < MATRIX_ENTRIES; k++) {
        if (!isfinite(m[k]) || (m[k] == 0.0 && signbit(m[k])))
            return broken(c, 8109, i, "a matrix entry that is not finite, or negative zero");
    }
    if (i == 0)
        return ZT_OK;
    zt__multiply(m, z->composed[z->parents[i]], all);
    double d = zt__adjugate(all, a);
    bool finite = isfinite(d);
    for (int k = 0; k < MATRIX_ENTRIES; k++)
        finite = finite && isfinite(all[k]);
    if (!finite || d == 0.0) {
        memcpy(all, identity, sizeof identity);
        return broken(c, 8110, i, "its composed matrix is not finite or not invertible");
    }
    const double corners[4] = {a[8], a[6] + a[8], a[7] + a[8], (a[6] + a[7]) + a[8]};
    for (int k = 0; k < 4; k++) {
        if (!isfinite(corners[k]) || (d > 0.0 ? !(corners[k] > 0.0) : !(corners[k] < 0.0)))
            return broken(c, 8111, i, "its quadrilateral reaches infinity");
    }
    return ZT_OK;
}

static zt_result check_patch(checking *c, uint32_t i) {
    zt__zipmap *z = c->zipmap;
    if (i > 0 && z->parents[i] >= i) {
        ZT_TRY(broken(c, 8103, i, "its parent does not come before it"));
        z->parents[i] = 0; /* for a validator that goes on: composing must not read ahead */
    }
    if (z->source_kinds[i] > 1) {
        ZT_TRY(broken(c, 8104, i, "an unknown kind of source"));
        z->source_kinds[i] = 0;
    }
    if (z->source_kinds[i] == 1)
        ZT_TRY(check_texture_source(c, i));
    else
        ZT_TRY(check_images(c, i));
    ZT_TRY(check_coverage(c, i));
    return check_matrix(c, i);
}

zt_result zt__check_zipmap(zt__sink *sink, zt__zipmap *zipmap, const zt__payload_scope *scope, uint64_t offset) {
    checking c = {sink, zipmap, scope, offset, 1};
    ZT_RULE(sink, 8101, zipmap->patch_count >= 1 && zipmap->patch_count <= UINT32_C(1) << 24, offset, "%u patches",
            zipmap->patch_count);
    ZT_RULE(sink, 8101, zipmap->layer_count == scope->layer_count, offset, "%u layers, the texture has %u",
            zipmap->layer_count, scope->layer_count);
    if (zipmap->patch_count == 0)
        return ZT_OK;
    ZT_TRY(check_root(&c));
    for (uint32_t i = 0; i < zipmap->patch_count; i++)
        ZT_TRY(check_patch(&c, i));
    return ZT_OK;
}

/* ---- decoding ------------------------------------------------------------------------------------ */

typedef struct planes {
    zt__sink *sink;
    zt__decoder *decoder;
    zt__cursor in;
    uint64_t offset;
} planes;

static zt_result read_plane(planes *p, uint32_t element_size, uint32_t count, void *dst) {
    return zt__decode_plane(p->sink, p->decoder, &p->in, p->offset, element_size, count, dst);
}

static zt_result read_planes(planes *p, zt__zipmap *z, double *column) {
    uint32_t n = z->patch_count;
    ZT_TRY(read_plane(p, 4, n, z->parents));
    ZT_TRY(read_plane(p, 1, n, z->source_kinds));
    for (uint32_t l = 0; l < z->layer_count; l++)
        ZT_TRY(read_plane(p, 4, n, z->sources + (size_t)l * n));
    ZT_TRY(read_plane(p, 4, n, z->masks));
    for (int k = 0; k < MATRIX_ENTRIES; k++) {
        ZT_TRY(read_plane(p, 8, n, column));
        for (uint32_t i = 0; i < n; i++)
            memcpy(&z->matrices[i][k], &column[i], sizeof(double)); /* bits: no FPU looks at them */
    }
    ZT_RULE(p->sink, 5106, zt__left(&p->in) == 0, p->offset + p->in.at, "%zu bytes behind the last plane",
            zt__left(&p->in));
    return ZT_OK;
}

/* The header: rule 8101 and the limit on patches, before anything is allocated. Constant planes store nothing, so the
 * chunk's size bounds no count. */
static zt_result read_header(planes *p, const zt_limits *limits, const zt__payload_scope *scope, uint32_t *patch_count,
                             bool *ok) {
    *patch_count = zt__take32(&p->in);
    uint32_t layer_count = zt__take32(&p->in);
    uint64_t reserved = zt__take64(&p->in);
    *ok = !p->in.bad && layer_count == scope->layer_count && *patch_count >= 1 && *patch_count <= UINT32_C(1) << 24;
    ZT_RULE(p->sink, 8101, !p->in.bad, p->offset, "the chunk is smaller than its header");
    ZT_RULE(p->sink, 8101, reserved == 0, p->offset + 8, "a reserved field is not zero");
    ZT_RULE(p->sink, 8101, layer_count == scope->layer_count, p->offset + 4, "%u layers, the texture has %u",
            layer_count, scope->layer_count);
    ZT_RULE(p->sink, 8101, *patch_count >= 1 && *patch_count <= UINT32_C(1) << 24, p->offset, "%u patches",
            *patch_count);
    if (*patch_count > limits->patches) {
        *ok = false;
        ZT_TRY(zt__report(p->sink, 1007, p->offset, "%u patches, the limit is %u", *patch_count, limits->patches));
    }
    return ZT_OK;
}

zt_result zt__decode_zipmap(zt__sink *sink, zt__memory *memory, zt__decoder *decoder, const zt_limits *limits,
                            const uint8_t *data, size_t size, const zt__payload_scope *scope, uint64_t offset,
                            zt__zipmap **out) {
    planes p = {sink, decoder, zt__cursor_of(data, size), offset};
    uint32_t count;
    bool ok;
    void *column = NULL;
    zt__zipmap *z = NULL;
    *out = NULL;
    zt__enter(sink, "ZPMP/texture %u", scope->texture);
    ZT_TRY(read_header(&p, limits, scope, &count, &ok));
    if (!ok) /* reported; there is nothing to go on with */
        return ZT_OK;
    ZT_TRY(zt__zipmap_new(memory, count, scope->layer_count, sink->diag, &z));
    zt_result result = zt__alloc_raw(memory, count, sizeof(double), sink->diag, &column);
    if (result == ZT_OK)
        result = read_planes(&p, z, column);
    zt__free(memory, column, count, sizeof(double));
    if (result == ZT_OK)
        result = zt__check_zipmap(sink, z, scope, offset);
    if (result != ZT_OK) {
        zt__free(memory, z, 1, (size_t)z->block_size);
        return result;
    }
    *out = z;
    return ZT_OK;
}

/* ---- encoding ------------------------------------------------------------------------------------- */

static zt_result write_planes(zt__plane_writer *w, const zt__zipmap *z, double *column) {
    uint32_t count = z->patch_count;
    zt__store32(w->out, count);
    zt__store32(w->out + 4, z->layer_count);
    zt__store64(w->out + 8, 0);
    ZT_TRY(zt__planes_put(w, 4, count, z->parents));
    ZT_TRY(zt__planes_put(w, 1, count, z->source_kinds));
    for (uint32_t l = 0; l < z->layer_count; l++)
        ZT_TRY(zt__planes_put(w, 4, count, z->sources + (size_t)l * count));
    ZT_TRY(zt__planes_put(w, 4, count, z->masks));
    for (int k = 0; k < MATRIX_ENTRIES; k++) {
        for (uint32_t i = 0; i < count; i++)
            memcpy(&column[i], &z->matrices[i][k], sizeof(double));
        ZT_TRY(zt__planes_put(w, 8, count, column));
    }
    return ZT_OK;
}

/* Bytes that the planes may need at most. */
static uint64_t capacity_of(const zt__zipmap *z) {
    uint64_t words = 2 + (uint64_t)z->layer_count;
    return HEADER_SIZE + words * zt__plane_bound(4, z->patch_count) + zt__plane_bound(1, z->patch_count) +
           MATRIX_ENTRIES * (uint64_t)zt__plane_bound(8, z->patch_count);
}

zt_result zt__encode_zipmap(zt__encoder *encoder, const zt__zipmap *zipmap, zt_diag *diag, uint8_t **out,
                            uint64_t *out_capacity, size_t *out_size) {
    zt__plane_writer w;
    void *column = NULL;
    uint64_t largest = (uint64_t)zipmap->patch_count * sizeof(double);
    zt_result result = zt__planes_begin(&w, encoder, HEADER_SIZE, capacity_of(zipmap), largest, diag);
    if (result == ZT_OK)
        result = zt__alloc_raw(encoder->memory, zipmap->patch_count, sizeof(double), diag, &column);
    if (result == ZT_OK)
        result = write_planes(&w, zipmap, column);
    zt__free(encoder->memory, column, zipmap->patch_count, sizeof(double));
    return zt__planes_end(&w, result, out, out_capacity, out_size);
}
