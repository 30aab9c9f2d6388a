/* SPDX-License-Identifier: Apache-2.0 */
/* Between the files that read scenes. All return a cmd_status and print their messages with the JSON pointer. */
#ifndef ZTEX_SCENE_H
#define ZTEX_SCENE_H

#include "make.h"

int scene_wrong_type(const make_scene *scene, const char *pointer, const json_t *value, const char *wanted);
/* Refuses members that are not in the list, which NULL ends. */
int scene_check_keys(make_scene *scene, const json_t *object, const char *pointer, const char *const *known);
int scene_text(make_scene *scene, const json_t *value, const char *pointer, const char **out);
int scene_whole(make_scene *scene, const json_t *value, const char *pointer, uint32_t min, uint32_t max, uint32_t *out);
int scene_wholes(make_scene *scene, const json_t *value, const char *pointer, size_t count, uint32_t max,
                 uint32_t *out);
int scene_reals(make_scene *scene, const json_t *value, const char *pointer, size_t count, double *out);
int scene_flag(make_scene *scene, const json_t *value, const char *pointer, int *out);
/* The position of a word in "a|b|c". */
int scene_word(make_scene *scene, const json_t *value, const char *pointer, const char *choices, int *out);
/* A texture of the scene before this one, by name. */
int scene_earlier(make_scene *scene, const json_t *value, const char *pointer, const make_texture *texture,
                  uint32_t *out);
/* A member, NULL when it is not there, and its pointer. */
int scene_member(make_scene *scene, const json_t *object, const char *pointer, const char *name, const json_t **value,
                 const char **at);
/* A member that is a word, or true or false; *out stays when it is not there. */
int scene_member_word(make_scene *scene, const json_t *object, const char *pointer, const char *name,
                      const char *choices, int *out);
int scene_member_flag(make_scene *scene, const json_t *object, const char *pointer, const char *name, int *out);

/* The members of object that are options of images, into o; members that are not there leave o as it is. */
int scene_options(make_scene *scene, const json_t *object, const char *pointer, make_options *o);
/* The same out of object's member "defaults". */
int scene_defaults(make_scene *scene, const json_t *object, const char *pointer, make_options *o);
/* scene_silmap.c: the member "silmap" of a texture, which makes it one. */
int scene_silmap(make_scene *scene, const json_t *value, const char *pointer, const make_options *defaults,
                 make_texture *texture);
/* scene_umbrellas.c: the member "umbrellas". The texture's wrap is known. */
int scene_umbrellas(make_scene *scene, const json_t *value, const char *pointer, const make_options *defaults,
                    make_texture *texture);
int scene_image(make_scene *scene, const json_t *value, const char *pointer, const make_options *defaults,
                const make_image **out);
/* One more layer of a texture: the member of the object at pointer whose name is the layer's semantic. images are those
 * of its layers. */
int scene_layer(make_scene *scene, const json_t *value, const char *pointer, const char *name,
                const make_options *defaults, make_texture *texture, const make_image **images);

#endif
