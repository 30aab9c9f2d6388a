/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures as the authoring library wants them. */
#ifndef ZTEX_LOAD_LINEAR_H
#define ZTEX_LOAD_LINEAR_H

#include <author.h>

#include "image_io.h"

/* The colours of the upright picture at path in linear light: 3 channels, or 1 when it is grey; its alpha is not looked
 * at. One of more than max_texels is reduced to about as many by area averages. Any thread may call it. error:
 * IMG_ERROR bytes. */
author_result load_linear(const char *path, uint64_t max_texels, author_picture *out, char *error);

#endif
