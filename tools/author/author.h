/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Making zipmaps, silmaps and umbrellas out of pictures: what all three share. author_zipmap.h, author_silmap.h and
 * author_umbrella.h have the rest.
 *
 * A library without files, terminal and globals: pictures come as memory and go as memory; the command `ztex` reads and
 * writes them. Functions that take long take an author_run, through which they use threads, say how far they are, and
 * can be stopped. The result is the same whatever the number of threads: work is cut by the input, never by the
 * workers, and sums over parts are taken in the order of the parts.
 *
 * Memory that a function hands out is the caller's, and author_..._release gives it back; a structure that is all zero
 * may be released. After an error out-parameters are all zero, and author_run.error says in one line what is wrong and
 * what would help.
 */
#ifndef ZTEX_AUTHOR_H
#define ZTEX_AUTHOR_H

#include <stddef.h>
#include <stdint.h>
#include <zt/zt.h>

#ifdef __cplusplus
extern "C" {
#endif

#define AUTHOR_ERROR 512

typedef enum author_result {
    AUTHOR_OK = 0,
    AUTHOR_BAD_INPUT = 1, /* the pictures or options cannot give a result: the text says why */
    AUTHOR_NO_MEMORY = 2,
    AUTHOR_CANCELLED = 3, /* progress asked for it */
    AUTHOR_INTERNAL = 4   /* a library misbehaved */
} author_result;

/* How to work. All zero: in the calling thread, silent. */
typedef struct author_run {
    const zt_parallel *parallel; /* NULL: the calling thread */
    /* Called from the calling thread now and then: done is 0 to 1 within the stage, a noun such as "features". Not 0:
     * stop. */
    int (*progress)(void *user, const char *stage, double done);
    void *user;
    char error[AUTHOR_ERROR]; /* UTF-8, set by a function that does not return AUTHOR_OK */
} author_run;

/* A picture: rows top down, channels interleaved, tight. Colours are in linear light; the fourth of 4 and the second of
 * 2 channels is alpha, never multiplied into the others. 1 to 4 channels. */
typedef struct author_picture {
    uint32_t width, height, channels;
    float *texels; /* width x height x channels */
} author_picture;

/* Zeroed texels. Errors: AUTHOR_NO_MEMORY, also for sizes that no memory holds. */
author_result author_picture_create(author_run *run, uint32_t width, uint32_t height, uint32_t channels,
                                    author_picture *out);
void author_picture_release(author_picture *picture);

/* Sets run->error and returns result: `return author_fail(run, AUTHOR_BAD_INPUT, "...", ...)`. */
#if defined(__GNUC__)
__attribute__((format(printf, 3, 4)))
#endif
author_result
author_fail(author_run *run, author_result result, const char *format, ...);

/* Memory for count elements of size bytes, zeroed; NULL (with run->error set) when there is none or the product
 * overflows. free() it. */
void *author_alloc(author_run *run, size_t count, size_t size);

/* Runs task(context, i, worker) for i below count, in slices, and reports progress between them; worker <
 * author_workers(run). A task that returns anything but AUTHOR_OK ends the work after its slice: the result is that of
 * the lowest such i, and its text. Errors: AUTHOR_CANCELLED, AUTHOR_NO_MEMORY, what the tasks return. */
typedef author_result (*author_task)(void *context, size_t index, unsigned worker, char *error);
author_result author_for(author_run *run, const char *stage, size_t count, author_task task, void *context);
unsigned author_workers(const author_run *run);

/* PCG32 (XSH RR 64/32, O'Neill 2014): the one source of chance. Equal seeds and streams give equal numbers on every
 * machine. */
typedef struct author_random {
    uint64_t state, increment;
} author_random;
void author_random_seed(author_random *random, uint64_t seed, uint64_t stream);
uint32_t author_random_u32(author_random *random);
uint32_t author_random_below(author_random *random, uint32_t bound); /* 0 to bound - 1, without bias; bound > 0 */
double author_random_unit(author_random *random);                    /* [0, 1), a multiple of 2^-32 */

#ifdef __cplusplus
}
#endif

#endif
