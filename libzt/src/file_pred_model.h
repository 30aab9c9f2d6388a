/* SPDX-License-Identifier: Apache-2.0 */
/* The tables of a predicted tile, chosen from what its samples are (encoder of file_pred.h). */
#ifndef ZT_FILE_PRED_MODEL_H
#define ZT_FILE_PRED_MODEL_H

#include "file_pred_job.h"

enum {
    ZT__PRED_CONTEXTS = ZT__PRED_PLANES * ZT__PRED_ACTS,
    ZT__PRED_LOG_SIZE = 4096,
    ZT__PRED_LOG_ONE = 1 << 10 /* logarithms and costs are in bits of 1/1024 */
};

/* How often each symbol comes, in the order in which tables are stored. */
typedef struct zt__pred_counts {
    uint32_t of[256];
    uint32_t used;  /* symbols up to the last one that occurs */
    uint32_t total; /* of all */
    uint64_t cost;
} zt__pred_counts;

typedef struct zt__pred_model {
    zt__pred_counts counts[ZT__PRED_CONTEXTS]; /* context = plane x ZT__PRED_ACTS + activity */
    int64_t pairs[ZT__PRED_CONTEXTS][ZT__PRED_CONTEXTS];
    uint16_t logs[ZT__PRED_LOG_SIZE];
    /* results */
    uint32_t table_count;
    uint8_t map[ZT__PRED_CONTEXTS];
    uint16_t frequencies[ZT__PRED_TABLES][256]; /* in the order in which tables are stored */
} zt__pred_model;

/* Once, before anything else. */
void zt__pred_model_init(zt__pred_model *model);

/* Cost of coding these symbols with a table of their own; table not counted. Sets used and total. */
uint64_t zt__pred_cost(const zt__pred_model *model, zt__pred_counts *counts);

/* Chooses at most ZT__PRED_TABLES tables for the first contexts of counts, which it overwrites. */
void zt__pred_choose(zt__pred_model *model, uint32_t contexts, uint32_t effort);

/* The place of a symbol in that order, and back: 8-bit residuals come by growing magnitude. */
static inline uint32_t zt__pred_place(uint32_t channel_bytes, uint32_t symbol) {
    return channel_bytes == 1 ? (symbol << 1 ^ (0 - (symbol >> 7))) & 255 : symbol;
}

static inline uint32_t zt__pred_symbol(uint32_t channel_bytes, uint32_t place) {
    return channel_bytes == 1 ? (place >> 1 ^ (0 - (place & 1))) & 255 : place;
}

#endif
