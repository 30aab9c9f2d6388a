/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the fuzz targets share: requirements that end the process, an allocator that counts, limits that keep one input
 * short, and random numbers that an input brings with it.
 */
#ifndef ZT_FUZZ_SUPPORT_H
#define ZT_FUZZ_SUPPORT_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <zt/zt.h>
#include <zt/zt_check.h>

/* The entry points that libFuzzer and driver.c call; of the last one a target may have none. */
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);
size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t max_size, unsigned seed);
int LLVMFuzzerInitialize(int *argc, char ***argv);

/* libFuzzer's own, or driver.c's. */
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size);

/* Stays in every build type: a fuzz target's requirements are what it is for. */
#define REQUIRE(condition)                                                            \
    do {                                                                              \
        if (!(condition)) {                                                           \
            fprintf(stderr, "%s:%d: required: %s\n", __FILE__, __LINE__, #condition); \
            abort();                                                                  \
        }                                                                             \
    } while (0)

/* Counts what is allocated, and requires that it stays within a ceiling and that sizes are told rightly. */
typedef struct fuzz_memory {
    zt_allocator allocator; /* its user is this struct */
    uint64_t ceiling;       /* live bytes never exceed it */
    uint64_t live, peak;
    uint64_t calls;
    uint64_t fail_at; /* the call with this number, counted from 1, gets no memory; 0: none */
} fuzz_memory;

void fuzz_memory_init(fuzz_memory *memory, uint64_t ceiling);

/* Small enough that no input takes long, large enough for every file of the corpus. */
zt_limits fuzz_limits(void);

/* A heap copy of exactly this size, so that a sanitizer sees any read behind the end. Never NULL. */
uint8_t *fuzz_copy(const uint8_t *data, size_t size);

/* malloc that ends the process instead of returning NULL; size may be 0. */
void *fuzz_malloc(size_t size);

/* What a diagnostic must hold behind a call that returned result, for a file of this size. */
void fuzz_require_diag(const zt_diag *diag, zt_result result, uint64_t file_size);

static inline uint32_t fuzz_load32(const uint8_t *p) {
    return (uint32_t)p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static inline uint64_t fuzz_load64(const uint8_t *p) {
    return (uint64_t)fuzz_load32(p) | (uint64_t)fuzz_load32(p + 4) << 32;
}

/* Little-endian, 1 to 8 bytes. */
static inline void fuzz_store(uint8_t *p, uint64_t value, size_t size) {
    for (size_t i = 0; i < size; i++)
        p[i] = (uint8_t)(value >> 8 * i);
}

/* Random numbers (xorshift64*, Vigna 2016) from a hash of the input: what a target does depends on the input alone. */
typedef struct fuzz_random {
    uint64_t state;
} fuzz_random;

fuzz_random fuzz_random_of(const uint8_t *data, size_t size);
uint64_t fuzz_next(fuzz_random *random);
/* 0 <= result < count; 0 for count 0. */
uint32_t fuzz_below(fuzz_random *random, uint32_t count);

#endif
