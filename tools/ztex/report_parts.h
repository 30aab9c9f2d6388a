/* SPDX-License-Identifier: Apache-2.0 */
/* What the pages that `ztex make ... --report` writes have in common: they need nothing beside them. */
#ifndef ZTEX_REPORT_PARTS_H
#define ZTEX_REPORT_PARTS_H

#include "command.h"

extern const char report_head[]; /* of a page, up to the end of its style */

/* Text that came from outside. */
void report_put(FILE *stream, const char *text);

/* A picture of sRGB-coded values as a text "data:image/jpeg;base64,...", malloc'd; NULL with a printed message. It
 * passes through a file beside `beside`, since pictures are written by name. type: "jpeg" or "png". */
char *report_picture(const cmd_args *args, const char *beside, const char *type, const float *rgb, uint32_t width,
                     uint32_t height);

/* The picture (which is freed; NULL is allowed) with its caption, which may be NULL. A cmd_status. */
int report_put_picture(FILE *stream, char *picture, const char *caption);

#endif
