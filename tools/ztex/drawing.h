/* SPDX-License-Identifier: Apache-2.0 */
/* Drawings (SVG) as pictures and as paths, through the module that reads them. */
#ifndef ZTEX_DRAWING_H
#define ZTEX_DRAWING_H

#include "command.h"
#include "module.h"
#include "vector_module.h"

#define DRAWING_ERROR (MODULE_ERROR > VECTOR_ERROR ? MODULE_ERROR : VECTOR_ERROR)

/* By the name's end. */
int drawing_is_one(const char *path);
/* The module, or NULL with a printed message. */
const vector_module *drawing_module(void);
/* A drawing, for edges alone or to be looked at. Returns a cmd_status; on CMD_INVALID error has a text and nothing is
 * printed, else the message is printed. Close with (*module)->drawing_close. */
int drawing_open(const cmd_args *args, const char *path, int edges, const vector_module **module, vector_drawing **out,
                 char *error);
/* The drawing, `longer` pixels along its longer side, in linear light with alpha: four channels. The same results. */
int drawing_picture(const cmd_args *args, const char *path, uint32_t longer, author_picture *out, char *error);
/* Its first path as points of the unit square; *points is malloc'd, x and y in turns. The same results. */
int drawing_first_path(const cmd_args *args, const char *path, double tolerance, double **points, size_t *count,
                       char *error);

#endif
