/* SPDX-License-Identifier: Apache-2.0 */
#include "file_spool.h"

#include <string.h>
#include <unistd.h>

#include "base_bytes.h"
#include "base_diag.h"
#include "file_output.h"

enum { BLOCK = 1 << 20, FIRST_BLOCKS = 16 };

void zt__spool_init(zt__spool *spool, zt__memory *memory, const char *folder, uint64_t memory_bytes) {
    memset(spool, 0, sizeof *spool);
    spool->memory = memory;
    spool->folder = folder;
    spool->most_blocks = memory_bytes / BLOCK;
    spool->fd = -1;
}

void zt__spool_free(zt__spool *spool) {
    for (uint64_t i = 0; i < spool->block_count; i++)
        zt__free(spool->memory, spool->blocks[i], BLOCK, 1);
    zt__free(spool->memory, spool->blocks, spool->block_capacity, sizeof *spool->blocks);
    if (spool->fd >= 0)
        close(spool->fd);
    spool->fd = -1;
    spool->block_count = 0;
    spool->block_capacity = 0;
    spool->blocks = NULL;
}

static bool grow_list(zt__spool *spool) {
    uint64_t capacity = spool->block_capacity ? 2 * spool->block_capacity : FIRST_BLOCKS;
    void *list;
    if (zt__alloc(spool->memory, capacity, sizeof *spool->blocks, NULL, &list) != ZT_OK)
        return false;
    if (spool->block_count > 0)
        memcpy(list, spool->blocks, (size_t)spool->block_count * sizeof *spool->blocks);
    zt__free(spool->memory, spool->blocks, spool->block_capacity, sizeof *spool->blocks);
    spool->blocks = list;
    spool->block_capacity = capacity;
    return true;
}

/* False when memory is used up: the caller's limit, or the machine's. The rest then goes to the file. */
static bool add_block(zt__spool *spool) {
    void *block;
    if (spool->full || spool->block_count == spool->most_blocks)
        return false;
    if (spool->block_count == spool->block_capacity && !grow_list(spool))
        return false;
    if (zt__alloc_raw(spool->memory, BLOCK, 1, NULL, &block) != ZT_OK)
        return false;
    spool->blocks[spool->block_count++] = block;
    return true;
}

zt_result zt__spool_append(zt__spool *spool, const void *data, size_t size, zt_diag *diag, uint64_t *place) {
    const uint8_t *bytes = data;
    *place = spool->size;
    while (size > 0 && !spool->full) {
        uint64_t at = spool->size % BLOCK;
        if (spool->size / BLOCK == spool->block_count && !add_block(spool)) {
            spool->full = true;
            break;
        }
        size_t n = size < BLOCK - at ? size : (size_t)(BLOCK - at);
        memcpy(spool->blocks[spool->size / BLOCK] + at, bytes, n);
        bytes += n;
        size -= n;
        spool->size += n;
    }
    if (size == 0)
        return ZT_OK;
    if (spool->fd < 0)
        ZT_TRY(zt__create_temporary(spool->memory, spool->folder, diag, &spool->fd, NULL));
    ZT_TRY(zt__write_all(spool->fd, bytes, size, diag));
    spool->size += size;
    return ZT_OK;
}

zt_result zt__spool_read(const zt__spool *spool, uint64_t place, void *dst, size_t size, zt_diag *diag) {
    uint8_t *out = dst;
    uint64_t in_memory = spool->block_count * BLOCK;
    while (size > 0 && place < in_memory) {
        uint64_t at = place % BLOCK;
        size_t n = size < BLOCK - at ? size : (size_t)(BLOCK - at);
        memcpy(out, spool->blocks[place / BLOCK] + at, n);
        out += n;
        size -= n;
        place += n;
    }
    if (size == 0)
        return ZT_OK;
    return zt__pread_all(spool->fd, out, size, place - in_memory, diag);
}
