/* SPDX-License-Identifier: Apache-2.0 */
/* Lookups in images, in the order of spec/ztex.md section 12. */
#include "file_sample.h"

#include <math.h>

#include "file_format.h"

enum {
    TAIL_SHIFT = 31, /* larger than every level: one tile */
    OUTSIDE = -1     /* a texel that is zero */
};

/* ---- a set of images ------------------------------------------------------------------------------ */

static zt_result check_sampleable(const zt__image *image, uint32_t index, zt_diag *diag) {
    if (!image->format)
        return zt__fail(diag, ZT_UNSUPPORTED, 0, ZT__NO_OFFSET, "image %u has the unknown format %u", index,
                        image->record.format);
    if (!image->format->is_plain)
        return zt__fail(diag, ZT_UNSUPPORTED, 0, ZT__NO_OFFSET,
                        "image %u has the block format %s, which is not sampled here", index, image->format->name);
    if (!zt_transfer_known(image->record.transfer))
        return zt__fail(diag, ZT_UNSUPPORTED, 0, ZT__NO_OFFSET,
                        "image %u has transfer characteristics %u, which are not sampled here", index,
                        image->record.transfer);
    return ZT_OK;
}

static void init_level(zt__sample_level *level, const zt__image *image, uint32_t k) {
    zt_level_info info;
    zt__level_geometry(&image->record, k, &info);
    level->width = info.width;
    level->height = info.height;
    level->depth = info.depth;
    level->unit = zt__unit_of_level(k, image->tail_level);
    level->tiles_x = info.tiles_x;
    if (k >= image->tail_level) {
        level->shift = TAIL_SHIFT;
        level->slice_bytes = info.slice_size;
        level->tail_offset = zt__tail_offset(&image->record, k);
        return;
    }
    level->shift = image->record.tile_log2;
    level->slice_tiles = (uint64_t)info.tiles_x * info.tiles_y;
}

static void init_image(zt__sample_image *s, const zt_file *file, uint32_t index) {
    const zt__image *image = &file->images[index];
    const zt__image_record *r = &image->record;
    s->image = index;
    s->format = image->format;
    s->transfer = r->transfer;
    s->levels = r->levels;
    s->premultiply = r->alpha_mode == ZT_ALPHA_STRAIGHT;
    s->layers = r->layers;
    s->size[0] = r->width;
    s->size[1] = r->height;
    s->size[2] = r->depth > 1 ? r->depth : 0.0;
    if (image->format->channel_bits == 8 && r->transfer == ZT_TRANSFER_SRGB)
        s->table = zt__srgb8_values;
    else if (image->format->channel_bits == 8 && zt__transfer_is_identity(r->transfer))
        s->table = zt__unorm8_values;
    for (uint32_t k = 0; k < r->levels; k++)
        init_level(&s->level[k], image, k);
    for (uint32_t u = 0; u < image->unit_count; u++)
        s->units[u].count = file->units[image->first_unit + u].tile_count;
}

zt_result zt__image_set_open(const zt_file *file, const uint32_t *indices, uint32_t count, zt_diag *diag,
                             zt__image_set **out) {
    uint64_t levels = 0;
    uint64_t units = 0;
    size_t size;
    void *block;
    *out = NULL;
    for (uint32_t i = 0; i < count; i++) {
        ZT_TRY(check_sampleable(&file->images[indices[i]], indices[i], diag));
        levels += file->images[indices[i]].record.levels;
        units += file->images[indices[i]].unit_count;
    }
    uint64_t images_at = zt__align16(sizeof(zt__image_set));
    uint64_t levels_at = zt__align16(images_at + (uint64_t)count * sizeof(zt__sample_image));
    uint64_t units_at = zt__align16(levels_at + levels * sizeof(zt__sample_level));
    if (!zt__to_size(units_at + units * sizeof(zt__tile_store), &size))
        return zt__fail(diag, ZT_NO_MEMORY, 0, ZT__NO_OFFSET, "too many images");
    ZT_TRY(zt__alloc(zt__memory_of(file), 1, size, diag, &block));
    char *base = block;
    zt__image_set *set = block;
    zt__sample_level *level = (zt__sample_level *)(void *)(base + levels_at);
    zt__tile_store *unit = (zt__tile_store *)(void *)(base + units_at);
    set->file = file;
    set->count = count;
    set->block_size = size;
    set->images = (zt__sample_image *)(void *)(base + images_at);
    for (uint32_t i = 0; i < count; i++) {
        set->images[i].level = level;
        set->images[i].units = unit;
        init_image(&set->images[i], file, indices[i]);
        level += set->images[i].levels;
        unit += file->images[indices[i]].unit_count;
    }
    *out = set;
    return ZT_OK;
}

static void free_unit(zt__memory *memory, const zt__image *image, uint32_t unit, zt__tile_store *store) {
    zt__tile_slot *slots = atomic_load_explicit(&store->slots, memory_order_acquire);
    if (!slots)
        return;
    for (uint64_t t = 0; t < store->count; t++) {
        uint8_t *bytes = atomic_load_explicit(&slots[t].bytes, memory_order_acquire);
        if (bytes)
            zt__free(memory, bytes, 1, zt__unit_tile_size(image, unit, t));
    }
    zt__free(memory, slots, store->count, sizeof *slots);
}

void zt__image_set_close(zt__image_set *set) {
    if (!set)
        return;
    zt__memory *memory = zt__memory_of(set->file);
    for (uint32_t i = 0; i < set->count; i++) {
        const zt__image *image = &set->file->images[set->images[i].image];
        for (uint32_t u = 0; u < image->unit_count; u++)
            free_unit(memory, image, u, &set->images[i].units[u]);
    }
    zt__free(memory, set, 1, (size_t)set->block_size);
}

/* ---- tiles ------------------------------------------------------------------------------------------ */

/* The slots of a unit, made on first touch. Of two threads that make them at once one wins, the other frees its own. */
static zt_result make_slots(zt__sample_call *call, zt__tile_store *store, zt__tile_slot **out) {
    zt__memory *memory = zt__memory_of(call->set->file);
    void *block;
    zt__tile_slot *found = NULL;
    ZT_TRY(zt__alloc(memory, store->count, sizeof(zt__tile_slot), call->diag, &block));
    *out = block;
    if (!atomic_compare_exchange_strong_explicit(&store->slots, &found, *out, memory_order_acq_rel,
                                                 memory_order_acquire)) {
        zt__free(memory, block, store->count, sizeof(zt__tile_slot));
        *out = found;
    }
    return ZT_OK;
}

static zt_result load_tile(zt__sample_call *call, const zt__sample_image *image, uint32_t unit, uint64_t tile,
                           const uint8_t **out) {
    zt__memory *memory = zt__memory_of(call->set->file);
    zt__tile_store *store = &image->units[unit];
    zt__tile_slot *slots = atomic_load_explicit(&store->slots, memory_order_acquire);
    zt__sink sink = {0};
    uint8_t *found = NULL;
    void *block;
    sink.diag = call->diag;
    if (!slots)
        ZT_TRY(make_slots(call, store, &slots));
    uint32_t size = zt__unit_tile_size(&call->set->file->images[image->image], unit, tile);
    ZT_TRY(zt__alloc_raw(memory, 1, size, call->diag, &block));
    zt_result result = zt__read_tile_into(call->set->file, &sink, &call->decoder, image->image, unit, tile, block, 0);
    if (result != ZT_OK) {
        zt__free(memory, block, 1, size);
        return result;
    }
    uint8_t *bytes = block;
    if (atomic_compare_exchange_strong_explicit(&slots[tile].bytes, &found, bytes, memory_order_acq_rel,
                                                memory_order_acquire)) {
        atomic_fetch_add_explicit(&call->set->tile_bytes, size, memory_order_relaxed);
        *out = bytes;
    } else {
        zt__free(memory, block, 1, size);
        *out = found;
    }
    return ZT_OK;
}

static inline zt_result tile_of(zt__sample_call *call, const zt__sample_image *image, uint32_t unit, uint64_t tile,
                                const uint8_t **out) {
    zt__tile_slot *slots = atomic_load_explicit(&image->units[unit].slots, memory_order_acquire);
    if (slots) {
        *out = atomic_load_explicit(&slots[tile].bytes, memory_order_acquire);
        if (*out)
            return ZT_OK;
    }
    return load_tile(call, image, unit, tile, out);
}

/* ---- texels (step 1) -------------------------------------------------------------------------------- */

static inline void add_texel(const zt__sample_image *image, const uint8_t *src, float weight, float sum[4]) {
    float c[4];
    if (image->table && image->format->channels == 4) {
        c[0] = image->table[src[0]];
        c[1] = image->table[src[1]];
        c[2] = image->table[src[2]];
        c[3] = zt__unorm8_values[src[3]];
    } else {
        zt__unpack_linear(image->format, image->transfer, src, 1, c);
    }
    float rgb_weight = image->premultiply ? weight * c[3] : weight;
    sum[0] += rgb_weight * c[0];
    sum[1] += rgb_weight * c[1];
    sum[2] += rgb_weight * c[2];
    sum[3] += weight * c[3];
}

/* Row y of the tile column that holds x: *out is its first byte, *first its first x. */
static zt_result tile_row(zt__sample_call *call, const zt__sample_image *image, const zt__sample_level *level,
                          uint32_t x, uint32_t y, uint64_t slice, const uint8_t **out, uint32_t *first) {
    uint32_t tile_x = x >> level->shift;
    uint32_t tile_y = y >> level->shift;
    uint32_t left = tile_x << level->shift;
    uint32_t width = zt__min32(level->width - left, UINT32_C(1) << level->shift);
    uint64_t tile = slice * level->slice_tiles + (uint64_t)tile_y * level->tiles_x + tile_x;
    const uint8_t *bytes;
    ZT_TRY(tile_of(call, image, level->unit, tile, &bytes));
    uint64_t row = y - (tile_y << level->shift);
    *first = left;
    *out = bytes + (size_t)(level->tail_offset + slice * level->slice_bytes + row * width * image->format->block_bytes);
    return ZT_OK;
}

zt_result zt__fetch_texel(zt__sample_call *call, uint32_t slot, uint32_t x, uint32_t y, uint32_t layer, float rgba[4]) {
    const zt__sample_image *image = &call->set->images[slot];
    const uint8_t *row;
    uint32_t first;
    rgba[0] = rgba[1] = rgba[2] = rgba[3] = 0.0f;
    ZT_TRY(tile_row(call, image, &image->level[0], x, y, zt__min32(layer, image->layers - 1), &row, &first));
    add_texel(image, row + (size_t)(x - first) * image->format->block_bytes, 1.0f, rgba);
    return ZT_OK;
}

/* ---- one direction (steps 3 and 4) ------------------------------------------------------------------- */

/* Texel index i of n under a wrap mode; i is within a few n of the level. */
static int32_t wrap_index(int32_t i, int32_t n, uint8_t wrap) {
    if (i >= 0 && i < n)
        return i;
    switch (wrap) {
    case ZT_WRAP_REPEAT:
        i %= n;
        return i < 0 ? i + n : i;
    case ZT_WRAP_MIRROR:
        i %= 2 * n;
        if (i < 0)
            i += 2 * n;
        return i < n ? i : 2 * n - 1 - i;
    case ZT_WRAP_CLAMP:
        return i < 0 ? 0 : n - 1;
    default:
        return OUTSIDE;
    }
}

/* Brings a coordinate near the unit interval without changing which texels it means, so that the conversion to an
 * integer is defined for every double. */
static double reduce(double u, uint8_t wrap) {
    if (wrap == ZT_WRAP_REPEAT)
        u -= floor(u);
    else if (wrap == ZT_WRAP_MIRROR)
        u -= 2.0 * floor(u * 0.5);
    if (!(u > -2.0)) /* NaN too */
        return -2.0;
    return u < 3.0 ? u : 3.0;
}

bool zt__wrap_unit(double *u, uint8_t wrap) {
    double m;
    switch (wrap) {
    case ZT_WRAP_REPEAT:
        *u -= floor(*u);
        return true;
    case ZT_WRAP_MIRROR:
        m = *u - 2.0 * floor(*u / 2.0);
        *u = m > 1.0 ? 2.0 - m : m;
        return true;
    case ZT_WRAP_CLAMP:
        *u = fmin(fmax(*u, 0.0), 1.0);
        return true;
    default:
        return *u >= 0.0 && *u <= 1.0;
    }
}

typedef struct taps {
    int32_t index[2];
    float weight[2];
    int count;
} taps;

static taps taps_of(double u, uint32_t size, uint8_t wrap, bool nearest) {
    taps t = {{0, 0}, {1.0f, 0.0f}, 1};
    int32_t n = (int32_t)size;
    double s = reduce(u, wrap) * (double)size;
    if (nearest) {
        t.index[0] = wrap_index((int32_t)floor(s), n, wrap);
        return t;
    }
    s -= 0.5;
    double i = floor(s);
    double f = s - i;
    t.index[0] = wrap_index((int32_t)i, n, wrap);
    t.index[1] = wrap_index((int32_t)i + 1, n, wrap);
    t.weight[0] = (float)(1.0 - f);
    t.weight[1] = (float)f;
    t.count = 2;
    return t;
}

/* ---- lookups in one level ---------------------------------------------------------------------------- */

static zt_result add_row(zt__sample_call *call, const zt__sample_image *image, const zt__sample_level *level,
                         const taps *tx, int32_t y, uint64_t slice, float weight, float sum[4]) {
    const uint8_t *row = NULL;
    uint32_t first = 1;
    uint32_t edge = UINT32_C(1) << level->shift;
    for (int k = 0; k < tx->count; k++) {
        int32_t x = tx->index[k];
        if (x == OUTSIDE || tx->weight[k] == 0.0f)
            continue;
        if (!row || (uint32_t)x - first >= edge)
            ZT_TRY(tile_row(call, image, level, (uint32_t)x, (uint32_t)y, slice, &row, &first));
        add_texel(image, row + (size_t)((uint32_t)x - first) * image->format->block_bytes, weight * tx->weight[k], sum);
    }
    return ZT_OK;
}

/* All four texels count and lie in one tile: one look at the tiles for them. */
static bool one_tile(const zt__sample_level *level, const taps *tx, const taps *ty) {
    return tx->count == 2 && tx->weight[1] != 0.0f && ty->weight[1] != 0.0f &&
           ((tx->index[0] | tx->index[1]) | (ty->index[0] | ty->index[1])) >= 0 &&
           tx->index[0] >> level->shift == tx->index[1] >> level->shift &&
           ty->index[0] >> level->shift == ty->index[1] >> level->shift;
}

static zt_result add_slice(zt__sample_call *call, const zt__sample_image *image, const zt__sample_level *level,
                           const taps *tx, const taps *ty, uint64_t slice, float weight, float sum[4]) {
    if (one_tile(level, tx, ty)) {
        const uint8_t *row;
        uint32_t first;
        uint32_t bytes = image->format->block_bytes;
        uint32_t x0 = (uint32_t)tx->index[0];
        ZT_TRY(tile_row(call, image, level, x0, (uint32_t)ty->index[0], slice, &row, &first));
        uint32_t width = zt__min32(level->width - first, UINT32_C(1) << level->shift);
        ptrdiff_t right = ((ptrdiff_t)tx->index[1] - tx->index[0]) * (ptrdiff_t)bytes;
        ptrdiff_t down = ((ptrdiff_t)ty->index[1] - ty->index[0]) * (ptrdiff_t)(width * bytes);
        const uint8_t *texel = row + (size_t)(x0 - first) * bytes;
        float upper = weight * ty->weight[0];
        float lower = weight * ty->weight[1];
        add_texel(image, texel, upper * tx->weight[0], sum);
        add_texel(image, texel + right, upper * tx->weight[1], sum);
        add_texel(image, texel + down, lower * tx->weight[0], sum);
        add_texel(image, texel + down + right, lower * tx->weight[1], sum);
        return ZT_OK;
    }
    for (int k = 0; k < ty->count; k++) {
        if (ty->index[k] != OUTSIDE && ty->weight[k] != 0.0f)
            ZT_TRY(add_row(call, image, level, tx, ty->index[k], slice, weight * ty->weight[k], sum));
    }
    return ZT_OK;
}

/* What stays the same for all taps of a lookup. */
typedef struct lookup {
    zt__sample_call *call;
    const zt__sample_image *image;
    const uint8_t *wraps;
    uint32_t layer;
    bool nearest;
} lookup;

/* Adds weight times the (bi- or tri-)linear or nearest lookup in level k at (u, v, w). */
static zt_result add_level(const lookup *l, uint32_t k, const double at[3], float weight, float sum[4]) {
    const zt__sample_level *level = &l->image->level[k];
    taps tx = taps_of(at[0], level->width, l->wraps[0], l->nearest);
    taps ty = taps_of(at[1], level->height, l->wraps[1], l->nearest);
    if (l->image->size[2] == 0.0)
        return add_slice(l->call, l->image, level, &tx, &ty, l->layer, weight, sum);
    taps tz = taps_of(at[2], level->depth, l->wraps[2], l->nearest);
    for (int i = 0; i < tz.count; i++) {
        if (tz.index[i] == OUTSIDE || tz.weight[i] == 0.0f)
            continue;
        uint64_t slice = (uint64_t)l->layer * level->depth + (uint32_t)tz.index[i];
        ZT_TRY(add_slice(l->call, l->image, level, &tx, &ty, slice, weight * tz.weight[i], sum));
    }
    return ZT_OK;
}

/* ---- level of detail (steps 2 and 3) ------------------------------------------------------------------ */

/* Squared length in texels of level 0. */
static double length2(const double size[3], double du, double dv, double dw) {
    double x = du * size[0];
    double y = dv * size[1];
    double z = size[2] != 0.0 ? dw * size[2] : 0.0;
    return x * x + y * y + z * z;
}

zt__footprint zt__footprint_of(const zt__sample_image *image, const zt__look *look, const zt_point *point) {
    double px = length2(image->size, point->du_dx, point->dv_dx, point->dw_dx);
    double py = length2(image->size, point->du_dy, point->dv_dy, point->dw_dy);
    bool x_longer = px >= py;
    double p = x_longer ? px : py;
    zt__footprint f = {.probes = 1};
    if (look->max_anisotropy > 1 && p > 0.0) {
        double most = look->max_anisotropy;
        double q = x_longer ? py : px;
        double ratio = q > 0.0 ? ceil(sqrt(p / q)) : most;
        double n = ratio < most ? fmax(ratio, 1.0) : most; /* NaN: most */
        f.probes = (uint32_t)n;
        f.step[0] = x_longer ? point->du_dx : point->du_dy;
        f.step[1] = x_longer ? point->dv_dx : point->dv_dy;
        f.step[2] = x_longer ? point->dw_dx : point->dw_dy;
        p /= n * n;
    }
    f.lambda = 0.5 * log2(p);
    return f;
}

/* One probe at (u, v, w); lambda is clamped. */
static zt_result add_probe(const lookup *l, const double at[3], double lambda, float weight, float sum[4]) {
    if (l->call->look.filter != ZT_FILTER_TRILINEAR)
        return add_level(l, (uint32_t)floor(lambda + 0.5), at, weight, sum);
    uint32_t k = (uint32_t)lambda;
    float fraction = (float)(lambda - (double)k);
    ZT_TRY(add_level(l, k, at, weight * (1.0f - fraction), sum));
    return fraction > 0.0f ? add_level(l, k + 1, at, weight * fraction, sum) : ZT_OK;
}

zt_result zt__sample_footprint(zt__sample_call *call, uint32_t slot, const uint8_t wraps[3], const zt_point *point,
                               const zt__footprint *footprint, float rgba[4]) {
    const zt__sample_image *image = &call->set->images[slot];
    double top = (double)(image->levels - 1);
    double lambda = footprint->lambda > 0.0 ? footprint->lambda : 0.0; /* NaN: 0 */
    lookup l = {call, image, wraps, zt__min32(point->array_layer, image->layers - 1),
                call->look.filter == ZT_FILTER_NEAREST};
    float weight = 1.0f / (float)footprint->probes;
    if (lambda > top)
        lambda = top;
    for (int c = 0; c < 4; c++)
        rgba[c] = 0.0f;
    for (uint32_t i = 0; i < footprint->probes; i++) {
        double t = ((double)i + 0.5) / (double)footprint->probes - 0.5;
        double at[3] = {point->u + t * footprint->step[0], point->v + t * footprint->step[1],
                        point->w + t * footprint->step[2]};
        ZT_TRY(add_probe(&l, at, lambda, weight, rgba));
    }
    return ZT_OK;
}

zt_result zt__sample_image_at(zt__sample_call *call, uint32_t slot, const uint8_t wraps[3], const zt_point *point,
                              float rgba[4]) {
    zt__footprint f = zt__footprint_of(&call->set->images[slot], &call->look, point);
    return zt__sample_footprint(call, slot, wraps, point, &f, rgba);
}
