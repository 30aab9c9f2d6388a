/* SPDX-License-Identifier: Apache-2.0 */
/* The functions of vector_module.h, as the two halves of the module define them. */
#ifndef ZTEX_VECTOR_HALVES_H
#define ZTEX_VECTOR_HALVES_H

#include "vector_module.h"

int vector_drawing_open(const void *data, size_t size, int edges, vector_drawing **out, char *error);
void vector_drawing_size(const vector_drawing *drawing, double *width, double *height);
void vector_drawing_place(vector_drawing *drawing, const author_silmap_place *place);
int vector_drawing_render(const vector_drawing *drawing, uint32_t width, uint32_t height, uint8_t *rgba, char *error);
int vector_drawing_paths(const vector_drawing *drawing, double tolerance, vector_paths *out, char *error);
int vector_drawing_shapes(const vector_drawing *drawing, double tolerance, vector_shapes *out, char *error);
void vector_drawing_close(vector_drawing *drawing);

int vector_text_open(const void *font, size_t size, const uint32_t *characters, size_t count, vector_text **out,
                     char *error);
void vector_text_size(const vector_text *text, double *width, double *height);
int vector_text_paths(const vector_text *text, const author_silmap_place *place, double tolerance, vector_paths *out,
                      char *error);
void vector_text_close(vector_text *text);

#endif
