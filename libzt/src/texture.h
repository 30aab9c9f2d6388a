/* SPDX-License-Identifier: Apache-2.0 */
/* Where all kinds of textures meet: the only layer that sees every payload. */
#ifndef ZT_TEXTURE_H
#define ZT_TEXTURE_H

#include "file_open.h"
#include "silmap_payload.h"
#include "umbrella_payload.h"
#include "zipmap_payload.h"

/* Opens and closes payload chunks for zt__walk. */
extern const zt__payload_hooks zt__texture_hooks;

/* Called for everything that a texture itself shows. */
typedef struct zt__visitor {
    void *user;
    void (*image)(void *user, uint32_t image);
    void (*texture)(void *user, uint32_t texture); /* a patch, base or background shows it */
} zt__visitor;

/* A kind of textures whose payload is a chunk: what all kinds have in common. */
typedef struct zt__kind {
    zt_result (*decode)(zt__sink *sink, zt_file *file, zt__decoder *decoder, const uint8_t *data, size_t size,
                        const zt__payload_scope *scope, uint64_t offset, void **payload);
    zt_result (*encode)(zt__encoder *encoder, const void *payload, zt_diag *diag, uint8_t **bytes, uint64_t *capacity,
                        size_t *size);
    uint64_t (*block_size)(const void *payload); /* of its one block of memory */
    uint32_t (*layer_image)(const void *payload, uint32_t layer);
    /* patch: of a zipmap, or ZT_NONE: all there is */
    void (*visit)(const void *payload, uint32_t patch, const zt__visitor *visitor);
} zt__kind;

/* NULL: kind image, and numbers that are no kind. */
const zt__kind *zt__kind_of(uint8_t kind);

/* Visits the images and textures of a texture that is in range and can be read (zt__is_readable). */
void zt__visit_texture(const zt_file *file, uint32_t texture, uint32_t patch, const zt__visitor *visitor);

/* False for a texture whose payload could not be decoded, which a recovery and a validator leave so. */
static inline bool zt__is_readable(const zt_file *file, uint32_t texture) {
    const zt__texture *t = &file->textures[texture];
    return t->entry.kind == ZT_KIND_IMAGE || t->payload;
}

/* The payload of a texture, or NULL for another kind. texture is in range. */
static inline const zt__zipmap *zt__zipmap_of(const zt_file *file, uint32_t texture) {
    const zt__texture *t = &file->textures[texture];
    return t->entry.kind == ZT_KIND_ZIPMAP ? (const zt__zipmap *)t->payload : NULL;
}

static inline const zt__silmap *zt__silmap_of(const zt_file *file, uint32_t texture) {
    const zt__texture *t = &file->textures[texture];
    return t->entry.kind == ZT_KIND_SILMAP ? (const zt__silmap *)t->payload : NULL;
}

static inline const zt__umbrellas *zt__umbrellas_of(const zt_file *file, uint32_t texture) {
    const zt__texture *t = &file->textures[texture];
    return t->entry.kind == ZT_KIND_UMBRELLA ? (const zt__umbrellas *)t->payload : NULL;
}

#endif
