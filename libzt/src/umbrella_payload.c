/* SPDX-License-Identifier: Apache-2.0 */
/* Umbrellas in memory: the block with their arrays, and what follows from their order (spec/umbrella.md section 2). */
#include "umbrella_payload.h"

/* ---- memory ------------------------------------------------------------------------------------ */

/* Behind rule 8311 every umbrella with colours of its own has vertices, too: so room for one centre each is enough. */
static uint64_t colour_room_of(const zt__umbrella_header *h) {
    return (uint64_t)h->explicit_vertex_count + zt__min32(h->umbrella_count, h->explicit_vertex_count);
}

static uint32_t edge_at(uint32_t grid, uint32_t level) {
    return zt__max32(grid >> level, 1);
}

uint32_t zt__count_cells(const zt__umbrella_header *h) {
    uint32_t cells = 0;
    for (uint32_t l = 0; l < h->level_count; l++)
        cells += edge_at(h->grid_x, l) * edge_at(h->grid_y, l);
    return cells;
}

/* Where the arrays lie in the block. What must be zero comes first. */
typedef struct layout {
    uint64_t levels, bases, umbrellas, variant_colours, explicit_colours;
    uint64_t base_vertices, morph_vertices, explicit_vertices, list_starts, entries, size;
} layout;

/* Counts have 32 bits and elements at most 48 bytes: sums stay far below 2^63. */
static layout layout_of(const zt__umbrella_header *h) {
    layout at = {.size = 0};
    zt__take_part(&at.size, sizeof(zt__umbrellas));
    at.levels = zt__take_part(&at.size, (uint64_t)h->level_count * sizeof(zt_umbrella_level));
    at.bases = zt__take_part(&at.size, (uint64_t)h->base_count * sizeof(zt_umbrella_base));
    at.umbrellas = zt__take_part(&at.size, (uint64_t)h->umbrella_count * sizeof(zt_umbrella));
    at.variant_colours = zt__take_part(&at.size, (uint64_t)h->variant_colour_count * sizeof(zt_umbrella_colour));
    at.explicit_colours = zt__take_part(&at.size, colour_room_of(h) * sizeof(zt_umbrella_colour));
    at.base_vertices = zt__take_part(&at.size, (uint64_t)h->base_vertex_count * sizeof(zt_umbrella_texel));
    at.morph_vertices = zt__take_part(&at.size, (uint64_t)h->morph_vertex_count * sizeof(zt_umbrella_texel));
    at.explicit_vertices = zt__take_part(&at.size, (uint64_t)h->explicit_vertex_count * sizeof(zt_umbrella_offset));
    at.list_starts = zt__take_part(&at.size, ((uint64_t)zt__count_cells(h) + 1) * sizeof(uint32_t));
    at.entries = zt__take_part(&at.size, (uint64_t)h->entry_count * sizeof(uint32_t));
    return at;
}

static void fill_levels(zt__umbrellas *u) {
    uint32_t cells = 0;
    for (uint32_t l = 0; l < u->header.level_count; l++) {
        u->levels[l].width = edge_at(u->header.grid_x, l);
        u->levels[l].height = edge_at(u->header.grid_y, l);
        u->levels[l].first_cell = cells;
        cells += u->levels[l].width * u->levels[l].height;
    }
}

static zt_umbrella_info view_of(const zt__umbrellas *u) {
    const zt__umbrella_header *h = &u->header;
    zt_umbrella_info view = {
        .grid_x = h->grid_x,
        .grid_y = h->grid_y,
        .level_count = h->level_count,
        .base_count = h->base_count,
        .umbrella_count = h->umbrella_count,
        .base_vertex_count = h->base_vertex_count,
        .morph_vertex_count = h->morph_vertex_count,
        .variant_colour_count = h->variant_colour_count,
        .explicit_vertex_count = h->explicit_vertex_count,
        .cell_count = zt__count_cells(h),
        .entry_count = h->entry_count,
        .longest_list = h->longest_list,
        .colour_mode = (zt_umbrella_colour_mode)h->colour_mode,
        .background_kind = (zt_background_kind)h->background_kind,
        .background_source = h->background_source,
        .prism_height = h->prism_height,
        .taper_start = h->taper_start,
        .taper_end = h->taper_end,
        .levels = u->levels,
        .bases = u->bases,
        .base_vertices = u->base_vertices,
        .morph_vertices = u->morph_vertices,
        .variant_colours = u->variant_colours,
        .umbrellas = u->umbrellas,
        .explicit_vertices = u->explicit_vertices,
        .explicit_colours = u->explicit_colours,
        .list_starts = u->list_starts,
        .entries = u->entries,
    };
    memcpy(view.background, h->background, sizeof view.background);
    memcpy(view.mean, h->mean, sizeof view.mean);
    return view;
}

zt_result zt__umbrellas_new(zt__memory *memory, const zt__umbrella_header *header, const zt__payload_scope *scope,
                            zt_diag *diag, zt__umbrellas **out) {
    layout at = layout_of(header);
    size_t bytes;
    void *block;
    *out = NULL;
    if (!zt__to_size(at.size, &bytes))
        return zt__fail(diag, ZT_NO_MEMORY, 0, ZT__NO_OFFSET, "the umbrellas are too large");
    ZT_TRY(zt__alloc_raw(memory, 1, bytes, diag, &block));
    memset(block, 0, (size_t)at.base_vertices);
    char *base = block;
    zt__umbrellas *u = block;
    *u = (zt__umbrellas){
        .header = *header,
        .repeat_x = scope->wrap_u == ZT_WRAP_REPEAT,
        .repeat_y = scope->wrap_v == ZT_WRAP_REPEAT,
        .block_size = at.size,
        .levels = (zt_umbrella_level *)(void *)(base + at.levels),
        .bases = (zt_umbrella_base *)(void *)(base + at.bases),
        .base_vertices = (zt_umbrella_texel *)(void *)(base + at.base_vertices),
        .morph_vertices = (zt_umbrella_texel *)(void *)(base + at.morph_vertices),
        .variant_colours = (zt_umbrella_colour *)(void *)(base + at.variant_colours),
        .explicit_colours = (zt_umbrella_colour *)(void *)(base + at.explicit_colours),
        .umbrellas = (zt_umbrella *)(void *)(base + at.umbrellas),
        .explicit_vertices = (zt_umbrella_offset *)(void *)(base + at.explicit_vertices),
        .list_starts = (uint32_t *)(void *)(base + at.list_starts),
        .entries = (uint32_t *)(void *)(base + at.entries),
    };
    fill_levels(u);
    u->view = view_of(u);
    *out = u;
    return ZT_OK;
}
