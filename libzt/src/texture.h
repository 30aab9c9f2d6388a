/* SPDX-License-Identifier: Apache-2.0 */
/* Where all kinds of textures meet: the only layer that sees every payload. */
#ifndef ZT_TEXTURE_H
#define ZT_TEXTURE_H

#include "zipmap_payload.h"

/* Opens and closes payload chunks for zt__walk. */
extern const zt__payload_hooks zt__texture_hooks;

/* The payload of a texture, or NULL for another kind. texture is in range. */
static inline const zt__zipmap *zt__zipmap_of(const zt_file *file, uint32_t texture) {
    const zt__texture *t = &file->textures[texture];
    return t->entry.kind == ZT_KIND_ZIPMAP ? (const zt__zipmap *)t->payload : NULL;
}

#endif
