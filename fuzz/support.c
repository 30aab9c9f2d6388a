/* SPDX-License-Identifier: Apache-2.0 */
#include "support.h"

#include <xxhash.h>

static void *counting_alloc(void *user, size_t size) {
    fuzz_memory *memory = user;
    REQUIRE(size > 0);
    if (++memory->calls == memory->fail_at)
        return NULL;
    memory->live += size;
    REQUIRE(memory->live <= memory->ceiling);
    if (memory->live > memory->peak)
        memory->peak = memory->live;
    return fuzz_malloc(size);
}

static void counting_free(void *user, void *ptr, size_t size) {
    fuzz_memory *memory = user;
    REQUIRE(ptr != NULL && size > 0 && size <= memory->live);
    memory->live -= size;
    free(ptr);
}

void fuzz_memory_init(fuzz_memory *memory, uint64_t ceiling) {
    memset(memory, 0, sizeof *memory);
    memory->allocator.user = memory;
    memory->allocator.alloc = counting_alloc;
    memory->allocator.free = counting_free;
    memory->ceiling = ceiling;
}

zt_limits fuzz_limits(void) {
    zt_limits limits = {0};
    limits.memory = UINT64_C(1) << 25;
    limits.metadata = UINT64_C(1) << 20;
    limits.patches = 1 << 14;
    limits.tile_size = 1 << 20;
    return limits;
}

void *fuzz_malloc(size_t size) {
    void *block = malloc(size ? size : 1);
    REQUIRE(block != NULL);
    return block;
}

uint8_t *fuzz_copy(const uint8_t *data, size_t size) {
    uint8_t *copy = fuzz_malloc(size);
    if (size > 0)
        memcpy(copy, data, size);
    return copy;
}

static size_t require_text(const char *text, size_t capacity) {
    const char *end = memchr(text, 0, capacity);
    REQUIRE(end != NULL);
    for (const char *p = text; p < end; p++)
        REQUIRE(*p >= 0x20 && *p <= 0x7E);
    return (size_t)(end - text);
}

void fuzz_require_diag(const zt_diag *diag, zt_result result, uint64_t file_size) {
    size_t text = require_text(diag->text, sizeof diag->text);
    require_text(diag->path, sizeof diag->path);
    REQUIRE(result != ZT_INTERNAL);
    REQUIRE(diag->result == result);
    if (result == ZT_OK)
        return;
    REQUIRE(text > 0);
    REQUIRE(diag->rule == 0 || zt_find_rule(diag->rule) != NULL);
    REQUIRE(result != ZT_CORRUPT || diag->rule != 0);
    REQUIRE(diag->offset <= file_size || diag->offset == UINT64_MAX);
}

fuzz_random fuzz_random_of(const uint8_t *data, size_t size) {
    fuzz_random random = {XXH3_64bits(data, size) | 1};
    return random;
}

uint64_t fuzz_next(fuzz_random *random) {
    uint64_t x = random->state;
    x ^= x >> 12;
    x ^= x << 25;
    x ^= x >> 27;
    random->state = x;
    return x * UINT64_C(2685821657736338717);
}

uint32_t fuzz_below(fuzz_random *random, uint32_t count) {
    return (uint32_t)((fuzz_next(random) >> 32) * count >> 32);
}
