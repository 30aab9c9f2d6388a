/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the authoring library takes from OpenCV: local features, their nearest neighbours, and robust homographies.
 * OpenCV brings some 140 shared libraries, so it sits in a module that the command loads when photographs are to be
 * registered; the library is handed this table and links nothing.
 *
 * The functions may be called from several threads at once; each works in the calling thread, and gives the same result
 * whatever runs beside it. They return 0, or -1 with one line in error (AUTHOR_ERROR bytes); nothing is thrown through
 * them.
 */
#ifndef ZTEX_AUTHOR_VISION_H
#define ZTEX_AUTHOR_VISION_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define AUTHOR_VISION_FILE "ztex-vision.so"
#define AUTHOR_VISION_SYMBOL "ztex_vision_module"

/* Where a feature is: pixels, the centre of the first one being (0.5, 0.5). size: diameter of its blob in pixels;
 * angle: of its strongest gradient, in degrees from x towards y. */
typedef struct author_point {
    float x, y, size, angle;
} author_point;

/* Features of a picture with an index over their descriptors. */
typedef struct author_features author_features;

#define AUTHOR_DESCRIPTOR 128 /* numbers */

/* An index over rows of AUTHOR_DESCRIPTOR bytes. */
typedef struct author_index author_index;

typedef struct author_match {
    uint32_t query, train; /* indices of features */
    float ratio;           /* distance of the nearest to that of the second nearest, 0 to 1: small is distinctive */
} author_match;

typedef struct author_vision {
    size_t size; /* sizeof(author_vision) */

    /* SIFT features with root-normalised descriptors, the largest first; at most `most`, the weakest of each scale left
     * out. grey: rows of width bytes. */
    int (*detect)(const uint8_t *grey, uint32_t width, uint32_t height, uint32_t most, author_features **out,
                  char *error);
    void (*release)(author_features *features); /* NULL is allowed */
    const author_point *(*points)(const author_features *features, size_t *count);

    /* For each of the query_count first (largest) features of query the nearest one in train, by an index built with
     * it. out has room for query_count. */
    int (*match)(const author_features *query, size_t query_count, const author_features *train, author_match *out,
                 size_t *count, char *error);
    /* The same among the features of train that lie within radius pixels of where each feature of query is. */
    int (*match_near)(const author_features *query, const author_features *train, double radius, author_match *out,
                      size_t *count, char *error);

    /* The homography, by rows, that maps most of `from` to within about `reach` of `to` (pairs of x, y), by
     * MAGSAC++ (Barath et al. 2020) with a fixed seed. inlier: 1 for each pair that follows it. *found is 0 when there
     * is none. */
    int (*homography)(const double *from, const double *to, size_t count, double reach, double matrix[9],
                      uint8_t *inlier, int *found, char *error);

    /* A row of AUTHOR_DESCRIPTOR numbers from 0 to 1 for each point. */
    const float *(*descriptors)(const author_features *features);
    /* The rows must stay as they are until index_release. */
    int (*index_create)(const uint8_t *rows, size_t count, author_index **out, char *error);
    void (*index_release)(author_index *index); /* NULL is allowed */
    /* Rows near each query (query_count rows), the nearest first: `most` row numbers, and squares of their distances. A
     * number of UINT32_MAX means that there are no more. */
    int (*index_search)(const author_index *index, const uint8_t *queries, size_t query_count, uint32_t most,
                        uint32_t *numbers, float *squares, char *error);
} author_vision;

#ifdef __cplusplus
}
#endif

#endif
