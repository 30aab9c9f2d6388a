/* SPDX-License-Identifier: Apache-2.0 */
#include "file_layout.h"

const uint8_t zt__magic[10] = {0xAB, 0x5A, 0x54, 0x45, 0x58, 0xBB, 0x0D, 0x0A, 0x1A, 0x0A};
const uint8_t zt__head_magic[8] = {0xAB, 0x5A, 0x54, 0x63, 0x68, 0x6B, 0xBB, 0x0A};

static const zt__chunk_type chunk_types[] = {
    /* type, version, flags, compressible, repeats, required, rank, kind */
    {ZT__TEXS, 1, ZT__FLAG_CRITICAL, true, false, true, 0, ZT_KIND_IMAGE},
    {ZT__IMAG, 1, ZT__FLAG_CRITICAL, true, false, true, 1, ZT_KIND_IMAGE},
    {ZT__ZPMP, 1, ZT__FLAG_CRITICAL, false, true, false, 2, ZT_KIND_ZIPMAP},
    {ZT__SLMP, 1, ZT__FLAG_CRITICAL, false, true, false, 3, ZT_KIND_SILMAP},
    {ZT__UMBR, 1, ZT__FLAG_CRITICAL, false, true, false, 4, ZT_KIND_UMBRELLA},
    {ZT__META, 1, ZT__FLAG_SAFE_TO_COPY, true, false, false, 5, ZT_KIND_IMAGE},
    /* unknown types: ZT__RANK_UNKNOWN */
    {ZT__TEXL, 1, ZT__FLAG_CRITICAL, false, false, true, 7, ZT_KIND_IMAGE},
};

const zt__chunk_type *zt__get_chunk_type(uint32_t i) {
    return i < sizeof chunk_types / sizeof chunk_types[0] ? &chunk_types[i] : NULL;
}

const zt__chunk_type *zt__find_chunk_type(uint32_t type) {
    for (size_t i = 0; i < sizeof chunk_types / sizeof chunk_types[0]; i++) {
        if (chunk_types[i].type == type)
            return &chunk_types[i];
    }
    return NULL;
}

const zt__chunk_type *zt__find_payload_type(uint8_t kind) {
    for (size_t i = 0; i < sizeof chunk_types / sizeof chunk_types[0]; i++) {
        if (kind != ZT_KIND_IMAGE && chunk_types[i].kind == kind)
            return &chunk_types[i];
    }
    return NULL;
}

static void code_bytes(zt__coder *coder, uint8_t *bytes, size_t n) {
    if (coder->out) {
        memcpy(coder->out, bytes, n);
        coder->out += n;
        return;
    }
    const uint8_t *p = zt__take(coder->in, n);
    if (p)
        memcpy(bytes, p, n);
    else
        memset(bytes, 0, n);
}

void zt__code_u8(zt__coder *coder, uint8_t *v) {
    code_bytes(coder, v, 1);
}

static void code_u16(zt__coder *coder, uint16_t *v) {
    uint8_t b[2];
    zt__store16(b, *v);
    code_bytes(coder, b, sizeof b);
    *v = zt__load16(b);
}

void zt__code_u32(zt__coder *coder, uint32_t *v) {
    uint8_t b[4];
    zt__store32(b, *v);
    code_bytes(coder, b, sizeof b);
    *v = zt__load32(b);
}

void zt__code_u64(zt__coder *coder, uint64_t *v) {
    uint8_t b[8];
    zt__store64(b, *v);
    code_bytes(coder, b, sizeof b);
    *v = zt__load64(b);
}

/* spec/ztex.md section 3 */
void zt__code_preamble(zt__coder *coder, zt__preamble *p) {
    code_bytes(coder, p->magic, sizeof p->magic);
    code_u16(coder, &p->major);
    code_u16(coder, &p->minor);
    code_u16(coder, &p->reserved0);
    zt__code_u64(coder, &p->file_size);
    zt__code_u32(coder, &p->directory_size);
    zt__code_u32(coder, &p->chunk_count);
    zt__code_u64(coder, &p->required_features);
    zt__code_u64(coder, &p->reserved1);
    zt__code_u64(coder, &p->reserved2);
    zt__code_u64(coder, &p->directory_hash);
}

/* section 4 */
void zt__code_entry(zt__coder *coder, zt__entry *e) {
    zt__code_u32(coder, &e->type);
    code_u16(coder, &e->version);
    zt__code_u8(coder, &e->flags);
    zt__code_u8(coder, &e->codec);
    zt__code_u64(coder, &e->offset);
    zt__code_u64(coder, &e->stored_size);
    zt__code_u64(coder, &e->decoded_size);
    zt__code_u64(coder, &e->stored_hash);
    zt__code_u64(coder, &e->decoded_hash);
}

/* section 5 */
void zt__code_head(zt__coder *coder, zt__head *h) {
    code_bytes(coder, h->magic, sizeof h->magic);
    zt__code_u32(coder, &h->index);
    zt__code_u32(coder, &h->reserved);
    zt__code_entry(coder, &h->entry);
}

/* section 6.2 */
void zt__code_plane(zt__coder *coder, zt__plane_header *p) {
    zt__code_u8(coder, &p->element_size);
    zt__code_u8(coder, &p->predictor);
    zt__code_u8(coder, &p->packing);
    zt__code_u8(coder, &p->codec);
    zt__code_u8(coder, &p->bit_width);
    code_bytes(coder, p->reserved, sizeof p->reserved);
    zt__code_u64(coder, &p->base);
    zt__code_u32(coder, &p->count);
    zt__code_u32(coder, &p->stored_size);
    zt__code_u64(coder, &p->hash);
}

/* section 6.3 */
void zt__code_tile(zt__coder *coder, zt__tile_record *t) {
    zt__code_u32(coder, &t->stored_size);
    zt__code_u8(coder, &t->codec);
    code_bytes(coder, t->reserved, sizeof t->reserved);
    zt__code_u64(coder, &t->hash);
}

/* section 7 */
void zt__code_texture(zt__coder *coder, zt__texture_entry *t) {
    zt__code_u8(coder, &t->kind);
    zt__code_u8(coder, &t->wrap_u);
    zt__code_u8(coder, &t->wrap_v);
    zt__code_u8(coder, &t->wrap_w);
    zt__code_u32(coder, &t->layer_count);
    zt__code_u32(coder, &t->name_size);
    zt__code_u32(coder, &t->reserved);
}

void zt__code_layer(zt__coder *coder, zt__layer_entry *l) {
    code_u16(coder, &l->semantic);
    code_u16(coder, &l->reserved);
    zt__code_u32(coder, &l->image);
}

/* section 8.1 */
void zt__code_image(zt__coder *coder, zt__image_record *r) {
    zt__code_u32(coder, &r->format);
    zt__code_u32(coder, &r->width);
    zt__code_u32(coder, &r->height);
    zt__code_u32(coder, &r->depth);
    zt__code_u32(coder, &r->layers);
    zt__code_u8(coder, &r->levels);
    zt__code_u8(coder, &r->tile_log2);
    zt__code_u8(coder, &r->block_width);
    zt__code_u8(coder, &r->block_height);
    zt__code_u8(coder, &r->block_bytes);
    zt__code_u8(coder, &r->alpha_mode);
    zt__code_u8(coder, &r->layer_kind);
    zt__code_u8(coder, &r->primaries);
    zt__code_u8(coder, &r->transfer);
    zt__code_u8(coder, &r->matrix);
    zt__code_u8(coder, &r->full_range);
    zt__code_u8(coder, &r->reserved);
}

/* section 8.3 */
void zt__code_unit(zt__coder *coder, zt__unit_record *u) {
    zt__code_u64(coder, &u->offset);
    zt__code_u64(coder, &u->size);
    zt__code_u64(coder, &u->index_hash);
}
