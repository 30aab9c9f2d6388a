/* SPDX-License-Identifier: Apache-2.0 */
/* What render, extract and convert share: finding what the command line names in a file, and telling pictures apart. */
#ifndef ZTEX_PICK_H
#define ZTEX_PICK_H

#include "command.h"
#include "image_io.h"

/* The texture that NAME or INDEX says; NULL: texture 0. Prints the message on failure. Returns a cmd_status. */
int pick_texture(const cmd_input *input, const char *text, uint32_t *texture);

/* The layer that SEMANTIC or INDEX says; NULL: layer 0. */
int pick_layer(const cmd_input *input, uint32_t texture, const char *text, uint32_t *layer);

/* What a layer of a texture would be as one image: its image or, for umbrellas, an image that is as fine as their
 * pictures in the mean. *number (may be NULL) gets the image's number or ZT_NONE, *semantic what the layer means. 0, or
 * -1. */
int pick_image_of(const zt_file *file, uint32_t texture, uint32_t layer, uint32_t *number, uint32_t *semantic,
                  zt_image_info *out);

/* "x,y,w,h" and the like: exactly count finite numbers between commas. 0, or -1. *end (may be NULL) gets what follows,
 * which otherwise must be nothing. */
int pick_numbers(const char *text, double *numbers, size_t count, const char **end);

/* Unsigned decimal numbers, as pick_numbers, each at most UINT32_MAX. */
int pick_integers(const char *text, uint32_t *numbers, size_t count);

/* 1: the name's extension is that of a picture with linear floats (OpenEXR, Radiance). */
int pick_is_linear(const char *path);

/* 1: values of this meaning are colours, which pictures for people keep in sRGB. */
int pick_is_colour(uint32_t semantic);

/* Author, copyright and title of a texture file for the pictures made of it: fills texts, returns their number. */
#define PICK_TEXTS 3
size_t pick_texts(const zt_file *file, img_text texts[PICK_TEXTS]);

#endif
