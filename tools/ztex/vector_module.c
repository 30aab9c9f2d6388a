/* SPDX-License-Identifier: Apache-2.0 */
/* The one symbol that the module of drawings and fonts exports. */
#include "vector_halves.h"

extern const vector_module ztex_vector_module;

__attribute__((visibility("default"))) const vector_module ztex_vector_module = {
    .size = sizeof(vector_module),
    .drawing_open = vector_drawing_open,
    .drawing_size = vector_drawing_size,
    .drawing_place = vector_drawing_place,
    .drawing_render = vector_drawing_render,
    .drawing_paths = vector_drawing_paths,
    .drawing_shapes = vector_drawing_shapes,
    .drawing_close = vector_drawing_close,
    .text_open = vector_text_open,
    .text_size = vector_text_size,
    .text_paths = vector_text_paths,
    .text_close = vector_text_close,
};
