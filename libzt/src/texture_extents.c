/* SPDX-License-Identifier: Apache-2.0 */
/* zt_query_extents: which bytes of the file a request reads. */
#include "texture.h"

/* Collects ranges. The first pass counts, the second fills. */
typedef struct collector {
    const zt_file *file;
    zt_extent *items;
    size_t count, capacity;
    const zt_request *request;
    uint8_t *wanted; /* by texture: shown by one that the request names */
} collector;

static void add(collector *c, uint64_t offset, uint64_t size) {
    if (c->count < c->capacity) {
        c->items[c->count].offset = offset;
        c->items[c->count].size = size;
    }
    c->count++;
}

static void add_levels(collector *c, uint32_t image, uint32_t first, uint32_t last) {
    const zt__image *im = &c->file->images[image];
    uint32_t levels = im->record.levels, done = ZT_NONE;
    first = zt__min32(first, levels - 1u);
    last = zt__min32(last, levels - 1u);
    for (uint32_t level = first; level <= last; level++) {
        uint32_t unit = zt__unit_of_level(level, im->tail_level);
        const zt__unit_record *record = &c->file->units[im->first_unit + unit].record;
        if (unit != done)
            add(c, c->file->texels_offset + record->offset, record->size);
        done = unit;
    }
}

/* The tile index and the tiles of one row of tiles after the other: neighbours in a row are neighbours in the file. */
static zt_result add_region(collector *c, uint32_t image, const zt_region *region, zt_diag *diag) {
    const zt__image *im = &c->file->images[image];
    const zt__tile_index *index;
    zt__sink sink = {0};
    zt_level_info level;
    uint32_t unit = zt__unit_of_level(region->level, im->tail_level);
    const zt__unit_record *record = &c->file->units[im->first_unit + unit].record;
    uint64_t at = c->file->texels_offset + record->offset;
    if (region->level >= im->tail_level) {
        add(c, at, record->size);
        return ZT_OK;
    }
    sink.diag = diag;
    zt_result result = zt__tile_index_of(c->file, &sink, image, unit, &index);
    uint64_t index_size = c->file->units[im->first_unit + unit].tile_count * ZT__TILE_RECORD_SIZE;
    add(c, at, index_size);
    ZT_TRY(result);
    zt__level_geometry(&im->record, region->level, &level);
    uint32_t step = im->record.tile_log2;
    uint32_t x0 = region->x / im->record.block_width >> step, y0 = region->y / im->record.block_height >> step;
    uint32_t x1 = (region->x + region->width - 1) / im->record.block_width >> step;
    uint32_t y1 = (region->y + region->height - 1) / im->record.block_height >> step;
    for (uint32_t z = region->z; z < region->z + region->depth; z++) {
        for (uint32_t y = y0; y <= y1; y++) {
            uint64_t row = (((uint64_t)region->layer * level.depth + z) * level.tiles_y + y) * level.tiles_x;
            uint64_t from = index->offsets[row + x0], to = index->offsets[row + x1 + 1];
            add(c, at + index_size + from, to - from);
        }
    }
    return ZT_OK;
}

static void want_image(void *user, uint32_t image) {
    collector *c = user;
    add_levels(c, image, c->request->min_level, c->request->max_level);
}

static void want_texture(void *user, uint32_t texture) {
    collector *c = user;
    c->wanted[texture] = 1;
}

/* Textures show earlier textures only, so one pass down finds them all, each once. */
static void add_textures(collector *c) {
    const zt__visitor visitor = {c, want_image, want_texture};
    zt__visit_texture(c->file, c->request->texture, c->request->patch, &visitor);
    for (uint32_t i = c->request->texture; i-- > 0;) {
        if (c->wanted[i])
            zt__visit_texture(c->file, i, ZT_NONE, &visitor);
    }
}

static zt_result check_request(const zt_file *file, const zt_request *r, zt_diag *diag) {
    if (r->texture == ZT_NONE) {
        if (r->image >= file->image_count)
            return zt__bad_argument(diag, "there is no such image");
    } else {
        const zt__zipmap *zipmap = r->texture < file->texture_count ? zt__zipmap_of(file, r->texture) : NULL;
        if (r->texture >= file->texture_count || r->region)
            return zt__bad_argument(diag, "there is no such texture, or a region is asked of a texture");
        if (r->patch != ZT_NONE && (!zipmap || r->patch >= zipmap->patch_count))
            return zt__bad_argument(diag, "there is no such patch");
    }
    if (r->min_level > r->max_level)
        return zt__bad_argument(diag, "min_level is above max_level");
    if (!r->region)
        return ZT_OK;
    const zt__image_record *record = &file->images[r->image].record;
    zt_level_info level;
    if (r->region->level >= record->levels || r->region->layer >= record->layers)
        return zt__bad_argument(diag, "there is no such level or layer");
    zt__level_geometry(record, r->region->level, &level);
    if (r->region->width == 0 || r->region->height == 0 || r->region->depth == 0 ||
        !zt__range_ok(r->region->x, r->region->width, level.width) ||
        !zt__range_ok(r->region->y, r->region->height, level.height) ||
        !zt__range_ok(r->region->z, r->region->depth, level.depth))
        return zt__bad_argument(diag, "the region is empty or leaves the level");
    return ZT_OK;
}

static zt_result collect(collector *c, const zt_request *r, zt_diag *diag) {
    c->count = 0;
    if (r->texture == ZT_NONE) {
        if (r->region)
            return add_region(c, r->image, r->region, diag);
        add_levels(c, r->image, r->min_level, r->max_level);
        return ZT_OK;
    }
    memset(c->wanted, 0, c->file->texture_count);
    c->request = r;
    add_textures(c);
    return ZT_OK;
}

static void sift_down(zt_extent *items, size_t root, size_t count) {
    for (;;) {
        size_t child = 2 * root + 1;
        if (child >= count)
            return;
        if (child + 1 < count && items[child].offset < items[child + 1].offset)
            child++;
        if (items[root].offset >= items[child].offset)
            return;
        zt_extent swap = items[root];
        items[root] = items[child];
        items[child] = swap;
        root = child;
    }
}

static void sort_extents(zt_extent *items, size_t count) {
    for (size_t i = count / 2; i-- > 0;)
        sift_down(items, i, count);
    for (size_t end = count; end-- > 1;) {
        zt_extent swap = items[0];
        items[0] = items[end];
        items[end] = swap;
        sift_down(items, 0, end);
    }
}

/* Sorts, and joins ranges that touch or overlap. Returns how many are left. */
static size_t join(zt_extent *items, size_t count) {
    size_t left = 0;
    sort_extents(items, count);
    for (size_t i = 0; i < count; i++) {
        if (left > 0 && items[i].offset <= items[left - 1].offset + items[left - 1].size) {
            uint64_t end = items[i].offset + items[i].size;
            if (end > items[left - 1].offset + items[left - 1].size)
                items[left - 1].size = end - items[left - 1].offset;
        } else {
            items[left++] = items[i];
        }
    }
    return left;
}

static zt_result query(collector *c, const zt_request *request, zt_extent *extents, size_t capacity, size_t *count,
                       zt_diag *diag) {
    zt__memory *memory = zt__memory_of(c->file);
    void *block;
    zt_extent index;
    c->items = &index;
    c->capacity = 1;
    zt_result result = collect(c, request, diag);
    if (result == ZT_AGAIN) {
        /* Not asked a second time: the io could answer otherwise by then. */
        if (capacity > 0)
            extents[0] = index;
        *count = 1;
    }
    ZT_TRY(result);
    size_t allocated = c->count;
    ZT_TRY(zt__alloc_raw(memory, allocated, sizeof *c->items, diag, &block));
    c->items = block;
    c->capacity = allocated;
    result = collect(c, request, diag);
    if (result == ZT_OK) {
        size_t joined = join(c->items, c->count);
        for (size_t i = 0; i < joined && i < capacity; i++)
            extents[i] = c->items[i];
        *count = joined;
    }
    zt__free(memory, block, allocated, sizeof *c->items);
    return result;
}

zt_result zt_query_extents(const zt_file *file, const zt_request *request, zt_extent *extents, size_t capacity,
                           size_t *count, zt_diag *diag) {
    collector c = {0};
    void *block;
    zt__begin(diag);
    if (count)
        *count = 0;
    if (!file || !request || !count || (!extents && capacity > 0))
        return zt__bad_argument(diag, "an argument is NULL");
    ZT_TRY(check_request(file, request, diag));
    ZT_TRY(zt__alloc(zt__memory_of(file), file->texture_count, 1, diag, &block));
    c.file = file;
    c.wanted = block;
    zt_result result = query(&c, request, extents, capacity, count, diag);
    zt__free(zt__memory_of(file), block, file->texture_count, 1);
    return result;
}
