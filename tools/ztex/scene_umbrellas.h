/* SPDX-License-Identifier: Apache-2.0 */
/* Between the files that read umbrellas out of a scene. All return a cmd_status; members that are not there leave *out
 * as it is. */
#ifndef ZTEX_SCENE_UMBRELLAS_H
#define ZTEX_SCENE_UMBRELLAS_H

#include <stdlib.h>

#include "scene.h"
#include "umbrellas.h"

int scene_real(make_scene *scene, const json_t *object, const char *pointer, const char *name, double low, double high,
               double *out);
int scene_count(make_scene *scene, const json_t *object, const char *pointer, const char *name, uint32_t low,
                uint32_t high, uint32_t *out);
/* A number, or two. */
int scene_range(make_scene *scene, const json_t *object, const char *pointer, const char *name, author_range bounds,
                author_range *out);
/* "#rrggbb", or three numbers of linear light. */
int scene_colour(make_scene *scene, const json_t *value, const char *pointer, float out[3]);

/* scene_bases.c: the member "bases". */
int scene_bases(make_scene *scene, const json_t *object, const char *pointer, const make_options *defaults,
                const make_texture *texture, make_umbrellas *u);

#endif
