/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the predicted codec (file_pred.h) share: constants of the format, and the state of one decoding. */
#ifndef ZT_FILE_PRED_JOB_H
#define ZT_FILE_PRED_JOB_H

#include "file_pred.h"

enum {
    ZT__PRED_PLANES = 8, /* 4 channels of 2 bytes */
    ZT__PRED_TABLES = 8, /* of one tile */
    ZT__PRED_ACTS = 16,  /* activities that a plane distinguishes */
    ZT__PRED_LANES = 64, /* most lanes */
    ZT__PRED_BITS = 11,  /* frequencies of a table sum to 2^11 */
    ZT__PRED_SLOTS = 1 << ZT__PRED_BITS,
    ZT__PRED_LOW = 1 << 15, /* lane states are at least this and below 2^31 */
    ZT__PRED_STRIP = 8,     /* rows that are restored at a time, and rows of a zero block */
    ZT__PRED_BLOCK = 64,    /* columns of a zero block */
    ZT__PRED_MARGIN = 64,   /* bytes before and behind a row of the scratch memory */
    ZT__PRED_REACH = 64,    /* most bytes of words that a step of a vector loop reads */
    ZT__PRED_COLOUR = 1,    /* bits of the flags byte */
    ZT__PRED_ZEROS = 2,
    ZT__PRED_FRAME = 16, /* samples are a zstd frame: file_pred_frame.h */
    ZT__PRED_NORMAL = 32
};

/* An entry of a decoding table, one a slot: the frequency of a symbol, then from these bits on the symbol and what the
 * slot is behind its first one. */
enum { ZT__PRED_FREQUENCY = 0xFFF, ZT__PRED_SYMBOL_AT = 12, ZT__PRED_OFFSET_AT = 20 };

/* The table of each activity of a plane. */
typedef struct zt__pred_map {
    const uint32_t *tables[ZT__PRED_ACTS];
    uint8_t numbers[ZT__PRED_ACTS];
} zt__pred_map;

typedef struct zt__pred_job {
    zt__pred_shape shape;
    uint32_t planes; /* channels x channel_bytes */
    uint32_t coded;  /* bit k: plane k is coded, else it is zero */
    uint32_t lanes;
    bool colour;
    bool normal;                    /* channel 2 wants slopes after restore() */
    uint8_t first[ZT__PRED_PLANES]; /* prediction of texel (0, 0) */
    zt__pred_map maps[ZT__PRED_PLANES];
    const uint8_t *zeros; /* a bit for each block of each coded plane, 1: coded; or NULL */

    const uint8_t *next, *end; /* words */
    uint8_t *tail;             /* 2 x ZT__PRED_REACH bytes: where vector loops move the last words, zeros behind them */
    const uint8_t *tail_end;   /* == end once they are there; NULL before */
    bool exhausted;            /* a word was wanted and there was none */
    uint32_t *states;
    uint32_t *tables;

    /* Rows in scratch memory. From the margin on: bytes left of a row are zero, those right of it may be written. */
    size_t pitch;
    uint8_t *acts;                       /* activity around each sample of a row */
    uint8_t *above[4], *current[4];      /* magnitudes of a channel in the previous and this row */
    uint8_t *residuals[ZT__PRED_PLANES]; /* ZT__PRED_STRIP rows each, zero behind their ends */
    size_t texel_pitch;
    uint8_t *texels; /* ZT__PRED_STRIP rows of whole texels, for restore() */
    uint8_t *top;    /* the row above them */
    uint8_t *none;   /* a row of zeros */
} zt__pred_job;

struct zt__pred_kernel {
    const char *name;
    /* Activities of a row's samples from the magnitudes of the row above and, unless beside is NULL, those of another
     * channel in this row. high: of the low byte plane, the row of high bytes; else NULL. */
    void (*select)(const uint8_t *above, const uint8_t *beside, const uint8_t *high, uint8_t *acts, uint32_t width);
    /* Decodes samples from to to - 1 of a row. from is a multiple of ZT__PRED_BLOCK. */
    void (*symbols)(zt__pred_job *job, const zt__pred_map *map, uint8_t *out, uint32_t from, uint32_t to);
    /* Magnitudes of a row of residuals. high: NULL for channels of one byte. */
    void (*measure)(const uint8_t *high, const uint8_t *low, uint8_t *out, uint32_t width);
    /* Texels of a strip of rows from its residuals. Strips come from the top down. */
    void (*restore)(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch);
    /* Adds the third component of normals to a row of texels of 8-bit channels. NULL: zt__pred_add_slopes does it. */
    void (*add_slopes)(uint8_t *texels, uint32_t channels, uint32_t width);
};

/* Channel of the texel that comes j-th in the order of the planes: green first, from which colours were subtracted. */
static inline uint32_t zt__pred_channel(uint32_t channels, uint32_t j) {
    return channels >= 3 && j < 2 ? 1 - j : j;
}

/* The plain C loops, which the others use for ends of rows, or as they are. */
void zt__pred_select_c(const uint8_t *above, const uint8_t *beside, const uint8_t *high, uint8_t *acts, uint32_t width);
void zt__pred_symbols_c(zt__pred_job *job, const zt__pred_map *map, uint8_t *out, uint32_t from, uint32_t to);
/* With fewer than ZT__PRED_REACH bytes of words left, moves them to job->tail. Returns false when more than there were
 * have been used. */
bool zt__pred_words_left(zt__pred_job *job, const uint8_t **next);

/* The same where more may be left, by value, so that a loop keeps its pointer in a register. NULL: more than there were
 * have been used. */
static inline const uint8_t *zt__pred_words(zt__pred_job *job, const uint8_t *next) {
    if (job->end - next >= ZT__PRED_REACH)
        return next;
    return zt__pred_words_left(job, &next) ? next : NULL;
}

void zt__pred_measure_c(const uint8_t *high, const uint8_t *low, uint8_t *out, uint32_t width);
void zt__pred_restore_c(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch);

/* Those of AVX2 that AVX-512 has nothing better for. */
void zt__pred_measure_avx2(const uint8_t *high, const uint8_t *low, uint8_t *out, uint32_t width);
void zt__pred_restore_avx2(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch);
void zt__pred_add_slopes_avx2(uint8_t *texels, uint32_t channels, uint32_t width);

/* By vectors of the compiler; only where zt__pred_kernel_vector is not NULL. */
void zt__pred_restore_vector(zt__pred_job *job, uint32_t rows, uint8_t *dst, size_t dst_pitch);

#endif
