/* SPDX-License-Identifier: Apache-2.0 */
/* What the makers of zipmaps, silmaps and umbrellas share. */
#include "author.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SLICES 64 /* of a loop, between which progress is reported */
#define QUEUE 4   /* tasks of a worker in a slice, at least: at its end workers wait for each other */

author_result author_fail(author_run *run, author_result result, const char *format, ...) {
    va_list list;
    va_start(list, format);
    vsnprintf(run->error, sizeof run->error, format, list);
    va_end(list);
    return result;
}

void *author_alloc(author_run *run, size_t count, size_t size) {
    void *memory = size && count > SIZE_MAX / size ? NULL : calloc(count ? count : 1, size ? size : 1);
    if (!memory)
        author_fail(run, AUTHOR_NO_MEMORY, "no memory for %zu x %zu bytes", count, size);
    return memory;
}

author_result author_picture_create(author_run *run, uint32_t width, uint32_t height, uint32_t channels,
                                    author_picture *out) {
    *out = (author_picture){0};
    uint64_t texels = (uint64_t)width * height;
    if (texels > SIZE_MAX / 4 / sizeof(float))
        return author_fail(run, AUTHOR_NO_MEMORY, "no memory for a picture of %u x %u", width, height);
    float *memory = author_alloc(run, (size_t)texels * channels, sizeof *memory);
    if (!memory)
        return AUTHOR_NO_MEMORY;
    *out = (author_picture){.width = width, .height = height, .channels = channels, .texels = memory};
    return AUTHOR_OK;
}

void author_picture_release(author_picture *picture) {
    free(picture->texels);
    *picture = (author_picture){0};
}

/* ---- threads -------------------------------------------------------------------------------------------- */

typedef struct worker_error {
    author_result result;
    size_t index;
    char text[AUTHOR_ERROR];
} worker_error;

typedef struct slice {
    author_task task;
    void *context;
    size_t first;
    worker_error *errors; /* one for each worker */
} slice;

static void run_one(void *context, size_t index, unsigned worker) {
    const slice *part = context;
    worker_error *error = &part->errors[worker];
    char text[AUTHOR_ERROR] = "";
    size_t i = part->first + index;
    author_result result = part->task(part->context, i, worker, text);
    if (result == AUTHOR_OK || (error->result != AUTHOR_OK && error->index < i))
        return;
    error->result = result;
    error->index = i;
    memcpy(error->text, text, sizeof text);
}

unsigned author_workers(const author_run *run) {
    return run->parallel ? run->parallel->workers : 1;
}

static void run_slice(const author_run *run, slice *part, size_t count) {
    if (run->parallel) {
        run->parallel->run(run->parallel->user, count, run_one, part);
        return;
    }
    for (size_t i = 0; i < count; i++)
        run_one(part, i, 0);
}

static author_result first_error(author_run *run, const worker_error *errors) {
    const worker_error *first = NULL;
    for (unsigned w = 0; w < author_workers(run); w++)
        if (errors[w].result != AUTHOR_OK && (!first || errors[w].index < first->index))
            first = &errors[w];
    return first ? author_fail(run, first->result, "%s", first->text) : AUTHOR_OK;
}

author_result author_for(author_run *run, const char *stage, size_t count, author_task task, void *context) {
    worker_error *errors = author_alloc(run, author_workers(run), sizeof *errors);
    if (!errors)
        return AUTHOR_NO_MEMORY;
    size_t step = count / SLICES + 1;
    if (run->parallel && step < QUEUE * (size_t)author_workers(run))
        step = QUEUE * (size_t)author_workers(run);
    author_result result = AUTHOR_OK;
    for (size_t first = 0; first < count && result == AUTHOR_OK; first += step) {
        slice part = {task, context, first, errors};
        size_t n = count - first < step ? count - first : step;
        run_slice(run, &part, n);
        result = first_error(run, errors);
        double done = (double)(first + n) / (double)count;
        if (result == AUTHOR_OK && run->progress && run->progress(run->user, stage, done) != 0)
            result = author_fail(run, AUTHOR_CANCELLED, "cancelled");
    }
    free(errors);
    return result;
}

/* ---- chance --------------------------------------------------------------------------------------------- */

uint32_t author_random_u32(author_random *random) {
    uint64_t old = random->state;
    random->state = old * 6364136223846793005u + random->increment;
    uint32_t x = (uint32_t)(((old >> 18) ^ old) >> 27);
    unsigned turn = (unsigned)(old >> 59);
    return (x >> turn) | (x << ((32 - turn) & 31));
}

void author_random_seed(author_random *random, uint64_t seed, uint64_t stream) {
    random->state = 0;
    random->increment = stream << 1 | 1;
    author_random_u32(random);
    random->state += seed;
    author_random_u32(random);
}

uint32_t author_random_below(author_random *random, uint32_t bound) {
    uint32_t floor = (0u - bound) % bound;
    for (;;) {
        uint32_t number = author_random_u32(random);
        if (number >= floor)
            return number % bound;
    }
}

double author_random_unit(author_random *random) {
    return author_random_u32(random) * 0x1p-32;
}
