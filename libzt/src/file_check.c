/* SPDX-License-Identifier: Apache-2.0 */
#include "file_check.h"

#define TYPE_TEXT(type) (int)((type)&0xff), (int)((type) >> 8 & 0xff), (int)((type) >> 16 & 0xff), (int)((type) >> 24)

enum {
    MAX_CHUNKS = 65535,
    MAX_EDGE = 1 << 20,
    MAX_DEPTH = 1 << 14,
    MAX_LAYERS = 1 << 16,
    MAX_TEXTURE_LAYERS = 32,
    MAX_NAME = 255
};

static const uint64_t max_size = UINT64_C(1) << 53;
static const uint64_t max_zstd_size = UINT64_C(1) << 30;

/* ---- preamble and directory ---- */

static zt_result check_magic(zt__sink *sink, const zt__preamble *p) {
    static const uint8_t lf_only[] = {0xAB, 0x5A, 0x54, 0x45, 0x58, 0xBB, 0x0A};
    static const uint8_t stripped[] = {0x2B, 0x5A, 0x54, 0x45, 0x58, 0x3B};
    if (memcmp(p->magic, lf_only, sizeof lf_only) == 0 || memcmp(p->magic, stripped, sizeof stripped) == 0)
        return zt__report(sink, 2001, 0,
                          "the magic is damaged as by a text-mode transfer: copy the file in binary mode");
    ZT_RULE(sink, 2001, memcmp(p->magic, zt__magic, sizeof zt__magic) == 0, 0, "this is not a .ztex file");
    return ZT_OK;
}

zt_result zt__check_preamble(zt__sink *sink, const zt_limits *limits, const zt__preamble *p) {
    ZT_TRY(check_magic(sink, p));
    ZT_RULE(sink, 2002, p->major == 1, 10, "version %u.%u: this library reads version 1", p->major, p->minor);
    ZT_RULE(sink, 2003, p->reserved0 == 0 && p->reserved1 == 0 && p->reserved2 == 0, 14,
            "a reserved field of the preamble is not zero");
    ZT_RULE(sink, 2004, p->chunk_count >= 3 && p->chunk_count <= MAX_CHUNKS, 28, "%u chunks: a file has 3 to %u",
            p->chunk_count, MAX_CHUNKS);
    ZT_RULE(sink, 2005, p->directory_size == p->chunk_count * (uint32_t)ZT__ENTRY_SIZE, 24,
            "a directory of %u bytes for %u chunks", p->directory_size, p->chunk_count);
    for (unsigned bit = 0; bit < 64; bit++)
        ZT_RULE(sink, 2008, !(p->required_features >> bit & 1), 32, "feature bit %u is required and not known", bit);
    ZT_RULE(sink, 1002, p->chunk_count <= limits->chunks, 28, "%u chunks: the limit is %u (zt_limits.chunks)",
            p->chunk_count, limits->chunks);
    return ZT_OK;
}

static bool type_text_ok(uint32_t type) {
    for (int i = 0; i < 4; i++, type >>= 8) {
        uint32_t c = type & 0xff;
        if (!((c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9')))
            return false;
    }
    return true;
}

static zt_result check_entry_type(zt__sink *sink, const zt__entry *e, uint64_t at) {
    const zt__chunk_type *known = zt__find_chunk_type(e->type);
    ZT_RULE(sink, 3004, type_text_ok(e->type), at, "chunk type %08x has characters other than A-Z and 0-9", e->type);
    ZT_RULE(sink, 3005, !(e->flags & ~(ZT__FLAG_CRITICAL | ZT__FLAG_SAFE_TO_COPY)), at + 6,
            "flags %02x of %c%c%c%c: a reserved bit is set", e->flags, TYPE_TEXT(e->type));
    ZT_RULE(sink, 3005, !known || e->flags == known->flags, at + 6, "%c%c%c%c has flags %u", TYPE_TEXT(e->type),
            e->flags);
    ZT_RULE(sink, 3012, known || !(e->flags & ZT__FLAG_CRITICAL), at, "critical chunk %c%c%c%c is not known",
            TYPE_TEXT(e->type));
    ZT_RULE(sink, 3008, !known || !(known->flags & ZT__FLAG_CRITICAL) || e->version == known->version, at + 4,
            "version %u of %c%c%c%c is not known", e->version, TYPE_TEXT(e->type));
    ZT_RULE(sink, 3006, e->codec <= ZT__CODEC_ZSTD, at + 7, "codec %u of %c%c%c%c is not known", e->codec,
            TYPE_TEXT(e->type));
    ZT_RULE(sink, 3006, !known || known->compressible || e->codec == ZT__CODEC_RAW, at + 7, "%c%c%c%c has codec %u",
            TYPE_TEXT(e->type), e->codec);
    return ZT_OK;
}

zt_result zt__check_entry(zt__sink *sink, const zt__entry *e, uint32_t index, uint64_t expected_offset) {
    uint64_t at = ZT__PREAMBLE_SIZE + (uint64_t)index * ZT__ENTRY_SIZE;
    ZT_TRY(check_entry_type(sink, e, at));
    ZT_RULE(sink, 3003, e->stored_size >= 1 && e->stored_size < max_size, at + 16, "a stored size of %llu bytes",
            (unsigned long long)e->stored_size);
    ZT_RULE(sink, 3003,
            e->decoded_size >= 1 && e->decoded_size < max_size &&
                (e->codec == ZT__CODEC_RAW || e->decoded_size <= max_zstd_size),
            at + 24, "a decoded size of %llu bytes", (unsigned long long)e->decoded_size);
    if (e->codec == ZT__CODEC_RAW) {
        ZT_RULE(sink, 3007, e->decoded_size == e->stored_size && e->decoded_hash == e->stored_hash, at + 24,
                "stored raw, but decoded size or hash differ from the stored ones");
    } else {
        ZT_RULE(sink, 3007, e->stored_size < e->decoded_size, at + 16, "compressed to %llu bytes from %llu",
                (unsigned long long)e->stored_size, (unsigned long long)e->decoded_size);
    }
    ZT_RULE(sink, 3001, e->offset == expected_offset, at + 8, "chunk %u is said to be at %llu and must be at %llu",
            index, (unsigned long long)e->offset, (unsigned long long)expected_offset);
    return ZT_OK;
}

static uint32_t rank_of(const zt__entry *e) {
    const zt__chunk_type *known = zt__find_chunk_type(e->type);
    return known ? known->rank : ZT__RANK_UNKNOWN;
}

/* Types compare as their bytes in the file do. */
static uint32_t type_key(uint32_t type) {
    return (type & 0xff) << 24 | (type >> 8 & 0xff) << 16 | (type >> 16 & 0xff) << 8 | type >> 24;
}

static zt_result check_neighbours(zt__sink *sink, const zt__entry *a, const zt__entry *b, uint64_t at) {
    const zt__chunk_type *known = zt__find_chunk_type(b->type);
    if (a->type == b->type) {
        ZT_RULE(sink, 3011, known && known->repeats, at, "%c%c%c%c occurs twice", TYPE_TEXT(b->type));
        return ZT_OK;
    }
    bool sorted = rank_of(a) < rank_of(b) || (rank_of(a) == rank_of(b) && type_key(a->type) < type_key(b->type));
    ZT_RULE(sink, 3009, sorted, at, "%c%c%c%c comes behind %c%c%c%c", TYPE_TEXT(b->type), TYPE_TEXT(a->type));
    return ZT_OK;
}

zt_result zt__check_directory(zt__sink *sink, const zt__entry *entries, uint32_t count) {
    uint32_t found = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint64_t at = ZT__PREAMBLE_SIZE + (uint64_t)i * ZT__ENTRY_SIZE;
        const zt__chunk_type *known = zt__find_chunk_type(entries[i].type);
        if (known && !known->repeats) {
            uint32_t bit = UINT32_C(1) << known->rank;
            ZT_RULE(sink, 3011, !(found & bit), at, "%c%c%c%c occurs twice", TYPE_TEXT(entries[i].type));
            found |= bit;
        }
        if (i > 0 && !(known && !known->repeats && entries[i].type == entries[i - 1].type))
            ZT_TRY(check_neighbours(sink, &entries[i - 1], &entries[i], at));
    }
    for (uint32_t i = 0; zt__get_chunk_type(i); i++) {
        const zt__chunk_type *known = zt__get_chunk_type(i);
        ZT_RULE(sink, 3010, !known->required || (found >> known->rank & 1), ZT__PREAMBLE_SIZE,
                "there is no %c%c%c%c chunk", TYPE_TEXT(known->type));
    }
    return ZT_OK;
}

/* ---- images ---- */

static zt_result check_image_dimensions(zt__sink *sink, const zt_limits *limits, const zt__image_record *r,
                                        uint64_t at) {
    ZT_RULE(sink, 6002,
            r->width >= 1 && r->width <= MAX_EDGE && r->height >= 1 && r->height <= MAX_EDGE && r->depth >= 1 &&
                r->depth <= MAX_DEPTH && r->layers >= 1 && r->layers <= MAX_LAYERS,
            at + 4, "%u x %u x %u texels, %u layers", r->width, r->height, r->depth, r->layers);
    uint32_t edge = zt__max32(zt__max32(r->width, r->height), r->depth);
    ZT_RULE(sink, 6003, r->levels >= 1 && r->levels <= 1 + zt__log2(edge), at + 20,
            "%u levels for an edge of %u texels", r->levels, edge);
    ZT_RULE(sink, 1005, edge <= limits->dimension, at + 4,
            "an edge of %u texels: the limit is %u (zt_limits.dimension)", edge, limits->dimension);
    ZT_RULE(sink, 1006, r->layers <= limits->layers, at + 16, "%u array layers: the limit is %u (zt_limits.layers)",
            r->layers, limits->layers);
    return ZT_OK;
}

static zt_result check_image_block(zt__sink *sink, const zt__image_record *r, const zt_format_info *format,
                                   uint64_t at) {
    if (format) {
        ZT_RULE(sink, 6005,
                r->block_width == format->block_width && r->block_height == format->block_height &&
                    r->block_bytes == format->block_bytes,
                at + 22, "a block of %u x %u texels in %u bytes for %s", r->block_width, r->block_height,
                r->block_bytes, format->name);
        return ZT_OK;
    }
    ZT_RULE(sink, 6005,
            r->block_width >= 1 && r->block_width <= 16 && r->block_height >= 1 && r->block_height <= 16 &&
                r->block_bytes >= 1 && r->block_bytes <= 64,
            at + 22, "a block of %u x %u texels in %u bytes", r->block_width, r->block_height, r->block_bytes);
    return ZT_OK;
}

/* R6004 and R6009. No product overflows: edges are at most 2^20 blocks of at most 64 bytes, times 2^14 slices; layers
 * are multiplied with a check. */
static zt_result check_image_size(zt__sink *sink, const zt_limits *limits, const zt__image_record *r, uint64_t at) {
    ZT_RULE(sink, 6004, r->tile_log2 >= 4 && r->tile_log2 <= 16, at + 21, "a tile edge of 2^%u blocks", r->tile_log2);
    uint64_t edge = UINT64_C(1) << r->tile_log2;
    uint64_t blocks_x = zt__ceil_div(r->width, r->block_width), blocks_y = zt__ceil_div(r->height, r->block_height);
    uint64_t tile_x = blocks_x < edge ? blocks_x : edge, tile_y = blocks_y < edge ? blocks_y : edge;
    uint64_t tile_size = tile_x * tile_y * r->block_bytes;
    ZT_RULE(sink, 6004, tile_size <= UINT64_C(1) << 30, at + 21, "tiles of %llu bytes", (unsigned long long)tile_size);

    uint64_t slices = (uint64_t)r->depth * r->layers, bytes, tiles;
    bool fits = zt__mul64(blocks_x * blocks_y * r->block_bytes, slices, &bytes) && bytes < max_size / 2 &&
                zt__mul64(zt__ceil_div(blocks_x, edge) * zt__ceil_div(blocks_y, edge), slices, &tiles) &&
                tiles < UINT64_C(1) << 28;
    ZT_RULE(sink, 6009, fits, at + 4, "%u x %u x %u texels in %u layers are too many", r->width, r->height, r->depth,
            r->layers);
    ZT_RULE(sink, 1008, tile_size <= limits->tile_size, at + 21,
            "tiles of %llu bytes: the limit is %u (zt_limits.tile_size)", (unsigned long long)tile_size,
            limits->tile_size);
    uint32_t tail = zt__tail_level(r);
    uint64_t tail_size = tail < r->levels ? zt__tail_size(r, tail) : 0;
    ZT_RULE(sink, 1008, tail_size <= limits->tile_size, at + 21,
            "a mip tail of %llu bytes: the limit is %u (zt_limits.tile_size)", (unsigned long long)tail_size,
            limits->tile_size);
    return ZT_OK;
}

static bool primaries_ok(uint8_t v) {
    return v == 1 || v == 2 || (v >= 4 && v <= 12) || v == 22;
}

static bool transfer_ok(uint8_t v) {
    return v == 1 || v == 2 || (v >= 4 && v <= 18);
}

zt_result zt__check_image(zt__sink *sink, const zt_limits *limits, const zt__image_record *r, uint64_t offset) {
    const zt_format_info *format = zt_find_format(r->format);
    ZT_TRY(check_image_dimensions(sink, limits, r, offset));
    ZT_TRY(check_image_block(sink, r, format, offset));
    ZT_TRY(check_image_size(sink, limits, r, offset));
    ZT_RULE(sink, 6006, r->alpha_mode <= ZT_ALPHA_PREMULTIPLIED, offset + 25, "alpha mode %u", r->alpha_mode);
    ZT_RULE(sink, 6006, r->alpha_mode == ZT_ALPHA_NONE || !format || format->has_alpha, offset + 25,
            "alpha mode %u for %s, which has no alpha", r->alpha_mode, format->name);
    ZT_RULE(sink, 6007, r->layer_kind <= ZT_LAYERS_FRAMES, offset + 26, "layer kind %u", r->layer_kind);
    ZT_RULE(sink, 6007,
            r->layer_kind != ZT_LAYERS_CUBE || (r->width == r->height && r->depth == 1 && r->layers % 6 == 0),
            offset + 26, "cube faces of %u x %u x %u texels in %u layers", r->width, r->height, r->depth, r->layers);
    ZT_RULE(sink, 6008, primaries_ok(r->primaries) && transfer_ok(r->transfer) && r->matrix == 0 && r->full_range == 1,
            offset + 27, "CICP %u/%u/%u/%u", r->primaries, r->transfer, r->matrix, r->full_range);
    ZT_RULE(sink, 6008, !format || !format->is_srgb || r->transfer == ZT_TRANSFER_SRGB, offset + 28,
            "transfer %u for %s", r->transfer, format->name);
    ZT_RULE(sink, 6001, r->reserved == 0, offset + 31, "a reserved byte is %u", r->reserved);
    return ZT_OK;
}

zt_result zt__check_tile(zt__sink *sink, const zt__tile_record *t, uint32_t decoded_size, const zt__tile_form *form,
                         uint64_t offset) {
    ZT_RULE(sink, 5301, t->codec != ZT__CODEC_PRED || (form && form->shape.channels > 0), offset + 4,
            "codec 2 in a mip tail or for this format");
    ZT_RULE(sink, 5401, t->codec != ZT__CODEC_FIELDS || (form && form->fields), offset + 4,
            "codec 4 in a mip tail or for this format");
    ZT_RULE(sink, 5201, !t->reserved[0] && !t->reserved[1] && !t->reserved[2], offset + 5,
            "reserved bytes are not zero");
    if (t->codec == ZT__CODEC_RAW) {
        ZT_RULE(sink, 5202, t->stored_size == decoded_size, offset, "%u raw bytes for a tile of %u", t->stored_size,
                decoded_size);
    } else {
        ZT_RULE(sink, 5202, t->stored_size >= 1 && t->stored_size < decoded_size, offset,
                "%u bytes by codec %u for a tile of %u", t->stored_size, t->codec, decoded_size);
    }
    return ZT_OK;
}

/* ---- text ---- */

/* Length of the UTF-8 sequence at p, or 0: not one. */
static size_t utf8_sequence(const uint8_t *p, size_t left) {
    static const uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    size_t n = p[0] < 0x80                   ? 1
               : p[0] >= 0xC2 && p[0] < 0xE0 ? 2
               : (p[0] & 0xF0) == 0xE0       ? 3
               : (p[0] & 0xF8) == 0xF0       ? 4
                                             : 0;
    if (n == 0 || n > left)
        return 0;
    uint32_t code = n == 1 ? p[0] : p[0] & (0x7Fu >> n);
    for (size_t i = 1; i < n; i++) {
        if ((p[i] & 0xC0) != 0x80)
            return 0;
        code = code << 6 | (p[i] & 0x3Fu);
    }
    if (n > 1 && code < least[n])
        return 0;
    return code > 0x10FFFF || (code >= 0xD800 && code < 0xE000) ? 0 : n;
}

bool zt__utf8_ok(const char *text, size_t size, bool control) {
    const uint8_t *p = (const uint8_t *)text;
    while (size > 0) {
        size_t n = utf8_sequence(p, size);
        if (n == 0 || *p == 0 || (!control && (*p < 0x20 || *p == 0x7F)))
            return false;
        p += n;
        size -= n;
    }
    return true;
}

zt_result zt__check_texture(zt__sink *sink, const zt__texture_entry *t, const char *name, uint64_t offset) {
    ZT_RULE(sink, 6103, t->kind == ZT_KIND_IMAGE || zt__find_payload_type(t->kind), offset,
            "texture kind %u is not known", t->kind);
    ZT_RULE(sink, 6104, t->wrap_u <= ZT_WRAP_BORDER && t->wrap_v <= ZT_WRAP_BORDER && t->wrap_w <= ZT_WRAP_BORDER,
            offset + 1, "wrap modes %u, %u, %u", t->wrap_u, t->wrap_v, t->wrap_w);
    ZT_RULE(sink, 6104, t->reserved == 0, offset + 12, "a reserved field is not zero");
    ZT_RULE(sink, 6105, t->layer_count >= 1 && t->layer_count <= MAX_TEXTURE_LAYERS, offset + 4, "%u layers",
            t->layer_count);
    ZT_RULE(sink, 6107, t->name_size <= MAX_NAME && zt__utf8_ok(name, t->name_size, false), offset + 8,
            "a name of %u bytes is too long or not valid text", t->name_size);
    return ZT_OK;
}

zt_result zt__check_metadata_key(zt__sink *sink, const char *key, size_t size, uint64_t offset) {
    static const char *const registered[] = {"zt.title",  "zt.author",  "zt.copyright", "zt.license",
                                             "zt.source", "zt.comment", "zt.writer",    "zt.xmp"};
    ZT_RULE(sink, 7002, size >= 1 && size <= MAX_NAME && zt__utf8_ok(key, size, false), offset,
            "a key of %zu bytes is too long or not valid text", size);
    if (size < 3 || memcmp(key, "zt.", 3) != 0)
        return ZT_OK;
    bool known = false;
    for (size_t i = 0; i < sizeof registered / sizeof registered[0]; i++)
        known = known || (strlen(registered[i]) == size && memcmp(registered[i], key, size) == 0);
    ZT_RULE(sink, 7005, known, offset, "the key %.*s begins with zt. and is not registered",
            (int)(size < 100 ? size : 100), key);
    return ZT_OK;
}

zt_result zt__check_metadata_value(zt__sink *sink, const char *value, size_t size, uint64_t offset) {
    ZT_RULE(sink, 7004, zt__utf8_ok(value, size, true), offset, "a value of %zu bytes is not valid text", size);
    return ZT_OK;
}
