/* SPDX-License-Identifier: Apache-2.0 */
/* The rows of a picture as numbers in linear light, a band at a time, so that a large picture needs little memory. */
#ifndef ZTEX_LIGHT_ROWS_H
#define ZTEX_LIGHT_ROWS_H

#include "command.h"
#include "image_io.h"

typedef struct light_rows {
    img_reader *reader;
    const img_info *info;
    uint32_t channels, transfer;
    img_type type;
    float *table; /* of linear light for all values of integers */
    unsigned char *band;
} light_rows;

/* The first so many channels of the reader's picture, read as IMG_U8, IMG_U16 or IMG_FLOAT. The transfer is a known
 * one. 0, or -1: no memory; to be closed in any case. */
int light_rows_open(light_rows *rows, img_reader *reader, uint32_t channels, uint32_t transfer, img_type type);
void light_rows_close(light_rows *rows); /* all zero is allowed; the reader stays open */

/* Calls back for each row, from the top; first is the number of its first value. 0, or -1 with error (IMG_ERROR
 * bytes). */
int light_rows_each(const light_rows *rows, void (*row)(void *user, uint32_t y, size_t first), void *user, char *error);

/* Within a call back: a value of the row as it is coded, integers from 0 to 1. */
static inline float light_rows_value(const light_rows *rows, size_t i) {
    if (rows->type == IMG_U8)
        return (float)rows->band[i] / 255.0f;
    if (rows->type == IMG_U16)
        return (float)((const uint16_t *)(const void *)rows->band)[i] / 65535.0f;
    return ((const float *)(const void *)rows->band)[i];
}

/* The same in linear light. */
static inline float light_rows_light(const light_rows *rows, size_t i) {
    if (rows->type == IMG_U8)
        return rows->table[rows->band[i]];
    if (rows->type == IMG_U16)
        return rows->table[((const uint16_t *)(const void *)rows->band)[i]];
    return zt_transfer_decode(rows->transfer, light_rows_value(rows, i));
}

#endif
