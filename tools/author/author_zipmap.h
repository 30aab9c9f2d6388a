/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Registration: a heap of photographs of one thing, in no order, becomes trees of zooms (paper, section 4). Each
 * picture gets the picture that it is a zoom into, and the matrix P of `spec/zipmap.md` that places it there.
 *
 *     author_registration found;
 *     if (author_register(&run, vision, &photos, NULL, &found) != AUTHOR_OK)
 *         return complain(run.error);
 *     for (size_t i = 0; i < found.order_count; i++) {
 *         const author_placing *p = &found.placings[found.order[i]];
 *         if (p->state == AUTHOR_PLACED)
 *             add_patch(found.order[i], p->parent, p->matrix);
 *     }
 *     author_registration_release(&found);
 */
#ifndef ZTEX_AUTHOR_ZIPMAP_H
#define ZTEX_AUTHOR_ZIPMAP_H

#include "author.h"
#include "author_vision.h"

#ifdef __cplusplus
extern "C" {
#endif

#define AUTHOR_NONE UINT32_MAX
#define AUTHOR_FEW_PHOTOS 40
#define AUTHOR_CANDIDATES 12
#define AUTHOR_REASON_TEXT 256

typedef struct author_photo {
    const char *name;       /* for messages */
    uint32_t width, height; /* of the whole picture, in pixels: figures in "pixels" are of these */
} author_photo;

/* The pictures, and how to get their texels. load is called from the threads of the work, for different pictures at
 * once, once for each picture, and gives all of the picture in linear light with 1, 3 or more channels (grey, or red,
 * green and blue first), reduced by area averages to about max_texels or fewer when it has more. (A picture of another
 * size serves as well: coordinates go by the edges of the picture.) The library releases it. error: AUTHOR_ERROR bytes
 * for a result other than AUTHOR_OK. */
typedef struct author_photos {
    const author_photo *photos;
    size_t count;
    author_result (*load)(void *user, size_t index, uint64_t max_texels, author_picture *out, char *error);
    void *user;
} author_photos;

/* All zero (or NULL) means the defaults. */
typedef struct author_register_options {
    size_t size;            /* sizeof(author_register_options), or 0 */
    double min_correlation; /* of a picture low-passed to its parent's resolution with the parent; default 0.9 */
    double min_contained;   /* share of a picture's area that its parent must contain; default 0.6 */
    double min_ratio;       /* how much finer a child is at least; default 1.1 */
    /* Bytes for all pictures together, and as many again for their features: detail and weak features are dropped to
     * fit. Default 1 GiB. */
    uint64_t memory;
    /* Pictures that each one is compared with: those that look most alike at a quick look. Default: all, and
     * AUTHOR_CANDIDATES of more than AUTHOR_FEW_PHOTOS pictures. */
    uint32_t candidates;
} author_register_options;

typedef enum author_state {
    AUTHOR_UNPLACED = 0, /* reason and text say why */
    AUTHOR_ROOT = 1,     /* the coarsest picture of a group */
    AUTHOR_PLACED = 2    /* has a parent */
} author_state;

typedef enum author_reason {
    AUTHOR_REASON_NONE = 0,
    AUTHOR_REASON_FEW_MATCHES = 1,   /* too few features are found again in any other picture */
    AUTHOR_REASON_NO_HOMOGRAPHY = 2, /* the matches do not follow one plane's perspective */
    AUTHOR_REASON_CORRELATION = 3,   /* in its place it does not look like what it would cover */
    AUTHOR_REASON_AMBIGUOUS = 4,     /* it fits in several places equally well (repeated texture) */
    AUTHOR_REASON_OWN_GROUP = 5      /* it fits, but no coarser picture contains enough of it */
} author_reason;
const char *author_reason_name(author_reason reason); /* "too few matches" ...; static; never NULL */

typedef struct author_placing {
    author_state state;
    author_reason reason;          /* of AUTHOR_UNPLACED */
    char text[AUTHOR_REASON_TEXT]; /* one line for people: why, with the figures and the nearest picture's name; else
                                    * "" */
    uint32_t parent;               /* index of a picture; AUTHOR_NONE for roots and the unplaced */
    uint32_t group;                /* index of a root in `roots`; AUTHOR_NONE for the unplaced */
    /* By rows, homogeneous: P of the zipmap, the parent's coordinates in [0, 1] x [0, 1] to this picture's own. Scaled
     * so that w is 1 at this picture's centre. Identity for roots and the unplaced. */
    double matrix[9];
    double root_matrix[9]; /* the same from the coordinates of the group's root: M of the zipmap */
    double ratio;     /* this picture's pixels along a length over the parent's, at this picture's centre; root: 1 */
    double contained; /* share of its area that lies inside the parent */
    uint32_t matches; /* features found again in the parent; 0 when the place came by way of other pictures */
    uint32_t inliers; /* those that agree with one homography */
    double residual;  /* RMS of what blocks of the picture would still like to move, in this picture's pixels */
    double
        distortion; /* the part of it that a radial lens distortion explains: move of the corners, in pixels, signed */
    double uncertainty; /* expected error of a corner in pixels, from the noise and the detail that there is */
    double correlation; /* with the parent, both at the parent's resolution, -1 to 1 */
} author_placing;

/* One pair of pictures that was looked at. */
typedef struct author_pair {
    uint32_t coarse, fine; /* indices of pictures; coarse < fine in scale where that is known */
    uint32_t matches, inliers;
    author_reason reason; /* AUTHOR_REASON_NONE: it holds, and the rest is known */
    double matrix[9];     /* coordinates of coarse to those of fine; all zero without a homography */
    double ratio, residual, correlation;
} author_pair;

typedef struct author_registration {
    author_placing *placings; /* one for each photograph */
    size_t count;
    uint32_t *roots; /* index of the root of each group: the group of most pictures first */
    size_t group_count;
    uint32_t
        *order; /* indices of all that have a group: group after group, parents before children, coarse before fine */
    size_t order_count;
    author_pair *pairs; /* by coarse, then fine, of the first look */
    size_t pair_count;
} author_registration;

/* Finds who is a zoom into whom, and where. A picture alone makes a group only when it is the only one. Errors:
 * AUTHOR_BAD_INPUT (no pictures, more than 4096, a picture that does not load), AUTHOR_NO_MEMORY, AUTHOR_CANCELLED,
 * AUTHOR_INTERNAL. */
author_result author_register(author_run *run, const author_vision *vision, const author_photos *photos,
                              const author_register_options *options, author_registration *out);
void author_registration_release(author_registration *registration);

#ifdef __cplusplus
}
#endif

#endif
