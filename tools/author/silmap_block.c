/* SPDX-License-Identifier: Apache-2.0 */
/* What the original has in one cell, as far as the fit asks for it. */
#include "silmap_fit.h"

#include <stdlib.h>
#include <string.h>

size_t silmap_table_size(uint32_t edge) {
    return (size_t)edge * (edge + 1) * 2 + edge + 1;
}

void silmap_table_fill(const uint8_t *places, uint32_t edge, uint32_t finer, const double *values, double *table) {
    size_t pitch = (size_t)edge * finer;
    double *bottom = table + (size_t)edge * (edge + 1) * 2, part = 1.0 / (finer * finer);
    bottom[0] = 0;
    for (uint32_t x = 0; x < edge; x++) {
        double e = 0, g = 0;
        for (uint32_t y = 0; y < edge; y++, table += 2) {
            const uint8_t *at = places + x * finer * pitch + (size_t)y * finer;
            double sum = 0;
            for (uint32_t i = 0; i < finer * finer; i++)
                sum += values[at[i / finer * pitch + i % finer]];
            table[0] = e;
            table[1] = g;
            g += e + sum * part / 2;
            e += sum * part;
        }
        table[0] = e;
        table[1] = g;
        table += 2;
        bottom[x + 1] = bottom[x] + e;
    }
}

/* In the middle of the border between the regions. */
static uint8_t middle_point(const uint8_t *places, uint32_t pitch) {
    double x = 0, y = 0, n = 0;
    for (uint32_t k = 0; k + pitch + 1 < pitch * pitch; k++) {
        int border = places[k] != places[k + 1] || places[k] != places[k + pitch];
        if ((k + 1) % pitch == 0 || !border)
            continue;
        x += k / pitch + 1.0;
        y += k % pitch + 1.0;
        n++;
    }
    if (n < 1)
        return ZT_SILMAP_DEFAULT;
    unsigned px = (unsigned)(x / n * 8 / pitch), py = (unsigned)(y / n * 8 / pitch);
    return (uint8_t)((px > 7 ? 7 : px) | (py > 7 ? 7 : py) << 3);
}

/* How often the region changes from one side of the cell to the other along its border. */
static int changes(const uint8_t *places, uint32_t pitch, uint32_t first, uint32_t step) {
    int count = 0;
    for (uint32_t i = 1; i < pitch; i++)
        count += places[first + i * step] != places[first + (i - 1) * step];
    return count;
}

/* A region that is in the cell and crosses none of its sides is smaller than the cell. */
static int is_thin(const uint8_t *places, uint32_t pitch) {
    uint32_t last = pitch * (pitch - 1);
    int west = changes(places, pitch, 0, 1), east = changes(places, pitch, last, 1);
    int north = changes(places, pitch, 0, pitch), south = changes(places, pitch, pitch - 1, pitch);
    return west > 1 || east > 1 || north > 1 || south > 1 || west + east + north + south == 0;
}

silmap_block *silmap_block_create(const uint32_t *regions, uint32_t count, const uint8_t *places, uint32_t edge,
                                  uint32_t finer) {
    static const double second[SILMAP_LOCAL] = {0, 1};
    uint32_t pitch = edge * finer;
    size_t all = (size_t)pitch * pitch, table = count == 2 ? silmap_table_size(edge) : 0;
    silmap_block *block = calloc(1, sizeof *block + (count == 2 ? table * sizeof *block->table : all));
    if (!block)
        return NULL;
    memcpy(block->regions, regions, count * sizeof *regions);
    block->count = count;
    for (size_t i = 0; i < all; i++)
        block->shares[places[i]]++;
    for (uint32_t r = 0; r < count; r++)
        block->shares[r] /= (double)all;
    block->middle = middle_point(places, pitch);
    block->thin = is_thin(places, pitch);
    if (count == 2) {
        block->table = block->memory;
        silmap_table_fill(places, edge, finer, second, block->memory);
    } else {
        block->places = memcpy(block->memory, places, all);
    }
    return block;
}
