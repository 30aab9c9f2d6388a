/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The patch grid (spec/zipmap.md section 3, last paragraph): which patches a lookup has to look at. The paper draws all
 * patches at every pixel (section 3, equation 1); with the grid a lookup costs what overlaps there, not what there is.
 *
 * Lists are not cut behind a patch that hides all others: whether it does depends on the level of detail of the lookup
 * (its fade, its border), which the grid does not know. A lookup ends when nothing behind shows, at the same cost.
 */
#include "zipmap_payload.h"

#include <math.h>
#include <string.h>

enum {
    CELLS_PER_PATCH = 8,    /* wanted at most */
    ENTRIES_PER_PATCH = 32, /* allowed beside one for each cell: cells of about a fifth of a patch's edge */
    LONG_LIST = 32,         /* from here on a list may be divided */
    MAX_DEPTH = 8,          /* of grids in cells of grids */
    MAX_EDGE = 8192
};

/* A patch in root space, clipped; empty when x0 > x1. */
typedef struct box {
    double x0, y0, x1, y1;
} box;

static const box empty_box = {1.0, 1.0, 0.0, 0.0};

/* The corner (x, y) of patch space, brought to root space by the adjugate a of m: the determinant cancels in the
 * division. Where m is so close to singular that the corner does not come back, or where rounding at the rim of R8111
 * loses it, the patch may be anywhere. */
static void add_corner(const double m[9], const double a[9], double x, double y, box *b) {
    double w = (a[6] * x + a[7] * y) + a[8];
    double u = ((a[0] * x + a[1] * y) + a[2]) / w;
    double v = ((a[3] * x + a[4] * y) + a[5]) / w;
    double back_w = m[6] * u + m[7] * v + m[8];
    double back_x = (m[0] * u + m[1] * v + m[2]) / back_w;
    double back_y = (m[3] * u + m[4] * v + m[5]) / back_w;
    b->x0 = fmin(b->x0, u);
    b->y0 = fmin(b->y0, v);
    b->x1 = fmax(b->x1, u);
    b->y1 = fmax(b->y1, v);
    if (!(fabs(back_x - x) < 1e-3 && fabs(back_y - y) < 1e-3))
        *b = (box){-INFINITY, -INFINITY, INFINITY, INFINITY};
}

/* Rule 8111 makes the quadrilateral finite and convex, so its corners bound it. A margin takes in what rounding in the
 * lookup may take in. */
static box box_of(const double m[9]) {
    double a[9];
    box b = {INFINITY, INFINITY, -INFINITY, -INFINITY};
    zt__adjugate(m, a);
    add_corner(m, a, 0.0, 0.0, &b);
    add_corner(m, a, 1.0, 0.0, &b);
    add_corner(m, a, 0.0, 1.0, &b);
    add_corner(m, a, 1.0, 1.0, &b);
    double margin_x = (b.x1 - b.x0) * 1e-2 + 1e-14; /* ten times what add_corner lets pass */
    double margin_y = (b.y1 - b.y0) * 1e-2 + 1e-14;
    b.x0 = fmax(b.x0 - margin_x, 0.0);
    b.y0 = fmax(b.y0 - margin_y, 0.0);
    b.x1 = fmin(b.x1 + margin_x, 1.0);
    b.y1 = fmin(b.y1 + margin_y, 1.0);
    return b.x0 <= b.x1 && b.y0 <= b.y1 ? b : empty_box;
}

/* What is made, and what it takes to make it. */
typedef struct building {
    zt__memory *memory;
    zt_diag *diag;
    const box *boxes;
    zt__patch_grid *grid;
    uint64_t entries_left; /* so that no pile of patches makes the lists many times as long as they are */
} building;

static zt_result push(const building *b, zt__grid_array *array, uint64_t count, size_t size) {
    uint64_t needed = array->count + count;
    void *data;
    if (needed > array->capacity) {
        uint64_t capacity = needed > 2 * array->capacity ? needed : 2 * array->capacity;
        ZT_TRY(zt__alloc_raw(b->memory, capacity, size, b->diag, &data));
        if (array->count > 0)
            memcpy(data, array->data, (size_t)array->count * size);
        zt__free(b->memory, array->data, array->capacity, size);
        array->data = data;
        array->capacity = capacity;
    }
    array->count = needed;
    return ZT_OK;
}

static uint32_t cell_of(double offset, double scale, uint32_t count) {
    double cell = offset * scale;
    if (!(cell > 0.0))
        return 0;
    return cell < (double)count ? (uint32_t)cell : count - 1;
}

typedef struct span {
    uint32_t x0, y0, x1, y1; /* cells, inclusive */
} span;

/* The cells that a patch touches: cell_of is monotonous, so a point of the box falls into one of them. */
static span span_of(const zt__grid_node *n, const box *b) {
    span s = {cell_of(b->x0 - n->x0, n->scale_x, n->width), cell_of(b->y0 - n->y0, n->scale_y, n->height),
              cell_of(b->x1 - n->x0, n->scale_x, n->width), cell_of(b->y1 - n->y0, n->scale_y, n->height)};
    return s;
}

static box clip(const box *b, const box *region) {
    box c = {fmax(b->x0, region->x0), fmax(b->y0, region->y0), fmin(b->x1, region->x1), fmin(b->y1, region->y1)};
    return c;
}

static void set_size(zt__grid_node *n, uint32_t width, uint32_t height) {
    double extent_x = n->x1 - n->x0;
    double extent_y = n->y1 - n->y0;
    n->width = width;
    n->height = height;
    n->scale_x = extent_x > 0.0 ? (double)width / extent_x : 0.0;
    n->scale_y = extent_y > 0.0 ? (double)height / extent_y : 0.0;
}

static uint32_t clamp_edge(double edge) {
    if (!(edge > 1.0))
        return 1;
    return edge < MAX_EDGE ? (uint32_t)edge : MAX_EDGE;
}

static uint64_t count_entries(const building *b, const zt__grid_node *n, const uint32_t *list, uint32_t count) {
    uint64_t entries = 0;
    for (uint32_t i = 0; i < count; i++) {
        span s = span_of(n, &b->boxes[list[i]]);
        entries += (uint64_t)(s.x1 - s.x0 + 1) * (s.y1 - s.y0 + 1);
    }
    return entries;
}

/* Box and cells of a grid for a list of patches within a region. Cells have the mean patch's shape, there are a few for
 * each patch, and fewer where patches are so large that lists would outgrow their bound. False: dividing does not
 * help, because the list is hardly longer than what overlaps. */
static bool choose_size(const building *b, const box *region, const uint32_t *list, uint32_t count, zt__grid_node *n,
                        uint64_t *entries) {
    double mean_x = 0.0;
    double mean_y = 0.0;
    double area = 0.0;
    n->x0 = n->y0 = 1.0;
    n->x1 = n->y1 = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        box c = clip(&b->boxes[list[i]], region);
        mean_x += (c.x1 - c.x0) / count;
        mean_y += (c.y1 - c.y0) / count;
        area += (c.x1 - c.x0) * (c.y1 - c.y0);
        n->x0 = fmin(n->x0, c.x0);
        n->y0 = fmin(n->y0, c.y0);
        n->x1 = fmax(n->x1, c.x1);
        n->y1 = fmax(n->y1, c.y1);
    }
    double whole = (n->x1 - n->x0) * (n->y1 - n->y0);
    if (n->depth > 0 && !(2.0 * area < whole * count))
        return false;
    double shape = fmax(mean_x, 1e-300) / fmax(mean_y, 1e-300) * ((n->y1 - n->y0) / fmax(n->x1 - n->x0, 1e-300));
    double wanted = (double)CELLS_PER_PATCH * count;
    double across = fmin(sqrt(wanted / fmax(shape, 1e-12)), wanted);
    uint32_t width = clamp_edge(across);
    set_size(n, width, clamp_edge(wanted / (double)width));
    *entries = count_entries(b, n, list, count);
    for (;;) {
        double allowed = (double)ENTRIES_PER_PATCH * count + (double)n->width * n->height;
        if ((double)*entries <= allowed)
            return true;
        /* Entries shrink at most as cells do, so this does not overshoot by much. */
        double shrink = fmin(sqrt(allowed / (double)*entries), 0.85);
        set_size(n, clamp_edge(n->width * shrink), clamp_edge(n->height * shrink));
        *entries = count_entries(b, n, list, count);
    }
}

/* Puts patch i into the lists of the cells it touches. patches NULL: only counts. */
static void put(zt__grid_cell *cells, const zt__grid_node *n, const span *s, uint32_t i, uint32_t *patches) {
    for (uint32_t y = s->y0; y <= s->y1; y++) {
        for (uint32_t x = s->x0; x <= s->x1; x++) {
            zt__grid_cell *cell = &cells[y * n->width + x];
            if (patches)
                patches[cell->first + cell->count] = i;
            cell->count++;
        }
    }
}

/* Counting sort of a list, which lies in `patches` itself, into the cells of a new grid: front first, as the list has
 * it. */
static zt_result fill(building *b, const zt__grid_node *n, uint32_t list, uint32_t count, uint64_t entries) {
    zt__patch_grid *g = b->grid;
    uint32_t cell_count = n->width * n->height;
    uint64_t at = g->patches.count;
    ZT_TRY(push(b, &g->cells, cell_count, sizeof(zt__grid_cell)));
    ZT_TRY(push(b, &g->patches, entries, sizeof(uint32_t)));
    zt__grid_cell *cells = (zt__grid_cell *)g->cells.data + n->first_cell;
    uint32_t *patches = g->patches.data;
    memset(cells, 0, cell_count * sizeof *cells);
    for (uint32_t i = 0; i < count; i++) {
        span s = span_of(n, &b->boxes[patches[list + i]]);
        put(cells, n, &s, patches[list + i], NULL);
    }
    for (uint32_t k = 0; k < cell_count; k++) {
        cells[k].first = (uint32_t)at;
        at += cells[k].count;
        cells[k].count = 0;
    }
    for (uint32_t i = 0; i < count; i++) {
        span s = span_of(n, &b->boxes[patches[list + i]]);
        put(cells, n, &s, patches[list + i], patches);
    }
    return ZT_OK;
}

/* Divides a list among the cells of a grid of its own. *node: its index, or ZT_NONE: it stays a list. */
static zt_result divide(building *b, const box *region, uint32_t depth, uint32_t list, uint32_t count, uint32_t *node) {
    zt__patch_grid *g = b->grid;
    zt__grid_node n = {.depth = depth, .first_cell = (uint32_t)g->cells.count};
    uint64_t entries;
    *node = ZT_NONE;
    if (!choose_size(b, region, (uint32_t *)g->patches.data + list, count, &n, &entries))
        return ZT_OK;
    if (depth > 0 && entries > b->entries_left)
        return ZT_OK;
    b->entries_left -= entries < b->entries_left ? entries : b->entries_left;
    ZT_TRY(fill(b, &n, list, count, entries));
    ZT_TRY(push(b, &g->nodes, 1, sizeof n));
    *node = (uint32_t)(g->nodes.count - 1);
    ((zt__grid_node *)g->nodes.data)[*node] = n;
    return ZT_OK;
}

/* A cell in root space, with a margin: rounding may put a point into it that lies beside it. */
static box region_of(const zt__grid_node *n, uint32_t cell) {
    double width = (n->x1 - n->x0) / n->width;
    double height = (n->y1 - n->y0) / n->height;
    double x = n->x0 + width * (cell % n->width);
    double y = n->y0 + height * (cell / n->width);
    double margin_x = 1e-6 * width + 1e-15;
    double margin_y = 1e-6 * height + 1e-15;
    box region = {x - margin_x, y - margin_y, x + width + margin_x, y + height + margin_y};
    return region;
}

/* Divides the lists of a grid that are long and much longer than its others. */
static zt_result divide_cells(building *b, uint32_t index) {
    zt__patch_grid *g = b->grid;
    zt__grid_node n = ((zt__grid_node *)g->nodes.data)[index];
    uint32_t cell_count = n.width * n.height;
    uint64_t total = 0;
    for (uint32_t k = 0; k < cell_count; k++)
        total += ((zt__grid_cell *)g->cells.data)[n.first_cell + k].count;
    uint64_t mean = total / cell_count;
    for (uint32_t k = 0; k < cell_count; k++) {
        zt__grid_cell cell = ((zt__grid_cell *)g->cells.data)[n.first_cell + k];
        uint32_t child = ZT_NONE;
        if (cell.count > LONG_LIST && cell.count > 4 * mean && n.depth + 1 < MAX_DEPTH) {
            box region = region_of(&n, k);
            ZT_TRY(divide(b, &region, n.depth + 1, cell.first, cell.count, &child));
        }
        if (child != ZT_NONE) {
            ((zt__grid_cell *)g->cells.data)[n.first_cell + k] = (zt__grid_cell){child, ZT_NONE};
            continue;
        }
        g->list_total += cell.count;
        g->longest = zt__max32(g->longest, cell.count);
    }
    return ZT_OK;
}

/* All patches that show in the unit square, from the front, become the list that the outermost grid divides. */
static zt_result build(building *b, uint32_t count) {
    static const box unit = {0.0, 0.0, 1.0, 1.0};
    zt__patch_grid *g = b->grid;
    uint32_t shown = 0;
    uint32_t node;
    ZT_TRY(push(b, &g->patches, count, sizeof(uint32_t)));
    uint32_t *list = g->patches.data;
    for (uint32_t i = count; i-- > 1;) {
        if (b->boxes[i].x0 <= b->boxes[i].x1)
            list[shown++] = i;
    }
    g->patches.count = shown;
    if (shown == 0)
        return ZT_OK;
    b->entries_left = 4 * (uint64_t)ENTRIES_PER_PATCH * shown;
    ZT_TRY(divide(b, &unit, 0, 0, shown, &node));
    for (uint32_t k = 0; k < g->nodes.count; k++)
        ZT_TRY(divide_cells(b, k));
    g->top = *(zt__grid_node *)g->nodes.data;
    return ZT_OK;
}

zt_result zt__build_patch_grid(zt__memory *memory, const zt__zipmap *zipmap, zt_diag *diag, zt__patch_grid **out) {
    uint32_t count = zipmap->patch_count;
    void *boxes_block = NULL;
    void *block = NULL;
    *out = NULL;
    ZT_TRY(zt__alloc(memory, 1, sizeof(zt__patch_grid), diag, &block));
    zt_result result = zt__alloc_raw(memory, count, sizeof(box), diag, &boxes_block);
    if (result == ZT_OK) {
        box *boxes = boxes_block;
        building b = {memory, diag, boxes, block, 0};
        for (uint32_t i = 1; i < count; i++)
            boxes[i] = box_of(zipmap->composed[i]);
        result = build(&b, count);
    }
    zt__free(memory, boxes_block, count, sizeof(box));
    if (result != ZT_OK) {
        zt__free_patch_grid(memory, block);
        return result;
    }
    *out = block;
    return ZT_OK;
}

void zt__free_patch_grid(zt__memory *memory, zt__patch_grid *g) {
    if (!g)
        return;
    zt__free(memory, g->nodes.data, g->nodes.capacity, sizeof(zt__grid_node));
    zt__free(memory, g->cells.data, g->cells.capacity, sizeof(zt__grid_cell));
    zt__free(memory, g->patches.data, g->patches.capacity, sizeof(uint32_t));
    zt__free(memory, g, 1, sizeof *g);
}

uint32_t zt__patches_at(const zt__patch_grid *g, double u, double v, const uint32_t **first) {
    const zt__grid_node *n = &g->top;
    *first = g->patches.data;
    for (;;) {
        if (n->width == 0 || !(u >= n->x0 && u <= n->x1 && v >= n->y0 && v <= n->y1))
            return 0;
        uint32_t x = cell_of(u - n->x0, n->scale_x, n->width);
        uint32_t y = cell_of(v - n->y0, n->scale_y, n->height);
        const zt__grid_cell *cell = (const zt__grid_cell *)g->cells.data + n->first_cell + y * n->width + x;
        if (cell->count != ZT_NONE) {
            *first = (const uint32_t *)g->patches.data + cell->first;
            return cell->count;
        }
        n = (const zt__grid_node *)g->nodes.data + cell->first;
    }
}
