/* SPDX-License-Identifier: Apache-2.0 */
/* Planes (spec/ztex.md section 6.2). Everything between the stored bytes and the array is little-endian bytes; the last
 * step of decoding and the first of encoding change to the machine's byte order. */
#include "base_bytes.h"
#include "base_hash.h"
#include "file_codec.h"

enum { PREDICT_NONE = 0, PREDICT_DELTA = 1, PREDICT_SECOND = 2, PACK_ELEMENTS = 0, PACK_BYTES = 1, PACK_BITS = 2 };

/* ---- elements ------------------------------------------------------------------------------ */

static uint64_t load_element(const uint8_t *p, uint32_t size) {
    switch (size) {
    case 1:
        return *p;
    case 2:
        return zt__load16(p);
    case 4:
        return zt__load32(p);
    default:
        return zt__load64(p);
    }
}

static void store_element(uint8_t *p, uint32_t size, uint64_t v) {
    switch (size) {
    case 1:
        *p = (uint8_t)v;
        break;
    case 2:
        zt__store16(p, (uint16_t)v);
        break;
    case 4:
        zt__store32(p, (uint32_t)v);
        break;
    default:
        zt__store64(p, v);
        break;
    }
}

static uint64_t element_mask(uint32_t size) {
    return UINT64_MAX >> (64 - 8 * size);
}

static bool machine_is_little(void) {
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 1;
}

/* Between little-endian bytes and the machine's order: its own inverse. src may be dst. */
static void turn_bytes(uint8_t *dst, const uint8_t *src, uint32_t size, size_t count) {
    if (machine_is_little()) {
        memmove(dst, src, size * count);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        uint8_t e[8];
        memcpy(e, src + i * size, size);
        for (uint32_t k = 0; k < size; k++)
            dst[i * size + k] = e[size - 1 - k];
    }
}

/* ---- predictors and packings ----------------------------------------------------------------- */

static uint64_t zigzag(uint64_t d, uint32_t size) {
    uint64_t sign = d >> (8 * size - 1) & 1;
    return (d << 1 ^ (0 - sign)) & element_mask(size);
}

static void unpredict(uint8_t *p, uint32_t size, size_t count, uint8_t predictor) {
    uint64_t before = 0, second = 0;
    if (predictor == PREDICT_NONE)
        return;
    for (size_t i = 0; i < count; i++) {
        uint64_t z = load_element(p + i * size, size);
        uint64_t d = z >> 1 ^ (0 - (z & 1));
        uint64_t guess = predictor == PREDICT_DELTA ? before : 2 * before - second;
        second = before;
        before = guess + d;
        store_element(p + i * size, size, before);
    }
}

static void predict(uint8_t *dst, const uint8_t *src, uint32_t size, size_t count, uint8_t predictor) {
    uint64_t before = 0, second = 0;
    if (predictor == PREDICT_NONE) {
        memcpy(dst, src, size * count);
        return;
    }
    for (size_t i = 0; i < count; i++) {
        uint64_t e = load_element(src + i * size, size);
        uint64_t guess = predictor == PREDICT_DELTA ? before : 2 * before - second;
        second = before;
        before = e;
        store_element(dst + i * size, size, zigzag(e - guess, size));
    }
}

/* Element-major to byte-major. */
static void split_bytes(uint8_t *dst, const uint8_t *src, uint32_t size, size_t count) {
    for (uint32_t k = 0; k < size; k++)
        for (size_t i = 0; i < count; i++)
            dst[k * count + i] = src[i * size + k];
}

static void join_bytes(uint8_t *dst, const uint8_t *src, uint32_t size, size_t count) {
    for (uint32_t k = 0; k < size; k++)
        for (size_t i = 0; i < count; i++)
            dst[i * size + k] = src[k * count + i];
}

static uint64_t bits_size(uint64_t count, uint32_t width) {
    return zt__ceil_div(count * width, 8);
}

static uint64_t get_bits(const uint8_t *p, uint64_t at, uint32_t width) {
    uint64_t v = 0;
    for (uint32_t got = 0; got < width;) {
        uint32_t shift = (uint32_t)(at & 7), take = zt__min32(8 - shift, width - got);
        uint32_t bits = (uint32_t)p[at >> 3] >> shift & ((1U << take) - 1);
        v |= (uint64_t)bits << got;
        got += take;
        at += take;
    }
    return v;
}

/* The bytes are zero before. */
static void put_bits(uint8_t *p, uint64_t at, uint32_t width, uint64_t v) {
    for (uint32_t put = 0; put < width;) {
        uint32_t shift = (uint32_t)(at & 7), take = zt__min32(8 - shift, width - put);
        uint32_t bits = (uint32_t)(v >> put) & ((1U << take) - 1);
        p[at >> 3] = (uint8_t)(p[at >> 3] | bits << shift);
        put += take;
        at += take;
    }
}

/* ---- decoding ---------------------------------------------------------------------------------- */

static bool bits_fit(const zt__plane_header *h) {
    uint64_t mask = element_mask(h->element_size);
    if (h->bit_width > 8 * h->element_size || h->base > mask)
        return false;
    uint64_t most = h->bit_width == 0 ? 0 : UINT64_MAX >> (64 - h->bit_width);
    return most <= mask - h->base;
}

/* R5102, R5101. The context's element size is 1, 2, 4 or 8. */
static zt_result check_header(zt__sink *sink, const zt__plane_header *h, uint32_t element_size, uint32_t count,
                              uint64_t offset) {
    if (h->element_size != element_size || h->count != count)
        return zt__report(sink, 5102, offset, "a plane has %u elements of %u bytes instead of %u of %u",
                          (unsigned)h->count, (unsigned)h->element_size, (unsigned)count, (unsigned)element_size);
    if (h->predictor > PREDICT_SECOND || h->packing > PACK_BITS || h->codec > ZT__CODEC_ZSTD)
        return zt__report(sink, 5101, offset, "a plane has predictor %u, packing %u, codec %u", (unsigned)h->predictor,
                          (unsigned)h->packing, (unsigned)h->codec);
    if (h->reserved[0] || h->reserved[1] || h->reserved[2])
        return zt__report(sink, 5101, offset, "reserved bytes of a plane are not zero");
    if (h->packing != PACK_BITS && (h->bit_width != 0 || h->base != 0))
        return zt__report(sink, 5101, offset, "a plane without bit packing has a bit width or a base");
    if (h->packing == PACK_BITS && (h->predictor != 0 || h->codec != 0))
        return zt__report(sink, 5101, offset, "a bit-packed plane has a predictor or a codec");
    if (h->packing == PACK_BITS && !bits_fit(h))
        return zt__report(sink, 5101, offset, "base and bit width of a plane exceed its elements");
    return ZT_OK;
}

/* R5103. */
static zt_result check_size(zt__sink *sink, const zt__plane_header *h, size_t left, uint64_t offset) {
    uint64_t full = (uint64_t)h->count * h->element_size;
    bool good = h->stored_size == full;
    if (h->packing == PACK_BITS)
        good = h->stored_size == bits_size(h->count, h->bit_width);
    else if (h->codec == ZT__CODEC_ZSTD)
        good = h->stored_size >= 1 && h->stored_size < full;
    if (!good)
        return zt__report(sink, 5103, offset, "a plane has the stored size %u", (unsigned)h->stored_size);
    if (h->stored_size > left)
        return zt__report(sink, 5103, offset, "a plane of %u stored bytes goes beyond its chunk",
                          (unsigned)h->stored_size);
    return ZT_OK;
}

static zt_result decode_bits(zt__sink *sink, const zt__plane_header *h, const uint8_t *stored, uint64_t offset,
                             uint8_t *dst) {
    uint64_t used = (uint64_t)h->count * h->bit_width;
    if (used % 8 != 0)
        ZT_RULE(sink, 5104, stored[used / 8] >> (used % 8) == 0, offset,
                "unused bits of a bit-packed plane are not zero");
    for (uint64_t i = 0; i < h->count; i++)
        store_element(dst + i * h->element_size, h->element_size,
                      h->base + get_bits(stored, i * h->bit_width, h->bit_width));
    return ZT_OK;
}

/* Stored bytes to little-endian elements at dst. */
static zt_result decode_elements(zt__sink *sink, zt__decoder *decoder, const zt__plane_header *h, const uint8_t *stored,
                                 uint64_t offset, uint8_t *dst) {
    if (h->packing == PACK_BITS)
        return decode_bits(sink, h, stored, offset, dst);
    size_t size = (size_t)h->count * h->element_size;
    const uint8_t *packed = stored;
    if (h->codec == ZT__CODEC_ZSTD) {
        uint8_t *plain = dst;
        if (h->packing == PACK_BYTES)
            ZT_TRY(zt__decoder_raw(decoder, size, sink->diag, &plain));
        ZT_TRY(zt__decode_frame(sink, decoder, stored, h->stored_size, plain, size, offset));
        packed = plain;
    }
    if (h->packing == PACK_BYTES)
        join_bytes(dst, packed, h->element_size, h->count);
    else if (packed != dst)
        memcpy(dst, packed, size);
    unpredict(dst, h->element_size, h->count, h->predictor);
    return ZT_OK;
}

/* The header and the stored bytes of the plane at the cursor: 5101 to 5103. *offset: of the header in the file. */
static zt_result take_plane(zt__sink *sink, zt__cursor *in, uint64_t chunk_offset, uint32_t element_size,
                            uint32_t count, zt__plane_header *h, const uint8_t **stored, uint64_t *offset) {
    *offset = chunk_offset != ZT__NO_OFFSET ? chunk_offset + in->at : ZT__NO_OFFSET;
    if (zt__left(in) < ZT__PLANE_HEADER_SIZE)
        return zt__report(sink, 5103, *offset, "the chunk ends before a plane's header");
    zt__coder reading = zt__reading(in);
    zt__code_plane(&reading, h);
    ZT_TRY(check_header(sink, h, element_size, count, *offset));
    ZT_TRY(check_size(sink, h, zt__left(in), *offset));
    *stored = zt__take(in, h->stored_size);
    return ZT_OK;
}

zt_result zt__skip_plane(zt__sink *sink, zt__cursor *in, uint64_t chunk_offset, uint32_t element_size, uint32_t count) {
    zt__plane_header h;
    const uint8_t *stored;
    uint64_t offset;
    return take_plane(sink, in, chunk_offset, element_size, count, &h, &stored, &offset);
}

zt_result zt__decode_plane(zt__sink *sink, zt__decoder *decoder, zt__cursor *in, uint64_t chunk_offset,
                           uint32_t element_size, uint32_t count, void *dst) {
    zt__plane_header h = {0};
    const uint8_t *stored;
    uint64_t offset;
    ZT_TRY(take_plane(sink, in, chunk_offset, element_size, count, &h, &stored, &offset));
    uint64_t place = offset != ZT__NO_OFFSET ? offset + ZT__PLANE_HEADER_SIZE : ZT__NO_OFFSET;
    ZT_TRY(decode_elements(sink, decoder, &h, stored, place, dst));
    size_t size = (size_t)count * element_size;
    ZT_RULE(sink, 5105, zt__hash(dst, size) == h.hash, offset, "a plane does not have the hash that is stored for it");
    turn_bytes(dst, dst, element_size, count);
    return ZT_OK;
}

/* ---- encoding ---------------------------------------------------------------------------------- */

size_t zt__plane_bound(uint32_t element_size, uint32_t count) {
    return ZT__PLANE_HEADER_SIZE + zt__encode_bound((size_t)element_size * count);
}

/* One plane that is being coded: elements and work are the halves of the caller's scratch. */
typedef struct plane_coding {
    zt__encoder *encoder;
    uint32_t size, count;
    uint8_t *elements; /* little-endian */
    uint8_t *work;
    uint8_t *out; /* behind the header */
    size_t out_size;
    zt_diag *diag;
} plane_coding;

/* *stored is SIZE_MAX when the form is no smaller than raw bytes. */
static zt_result try_zstd(plane_coding *c, uint8_t predictor, uint8_t packing, size_t *stored) {
    size_t frame, bytes = (size_t)c->size * c->count;
    *stored = SIZE_MAX;
    predict(c->work, c->elements, c->size, c->count, predictor);
    const uint8_t *src = c->work;
    if (packing == PACK_BYTES) {
        /* The elements make room: they are rebuilt from the split bytes afterwards. */
        uint8_t *split = c->elements;
        split_bytes(split, c->work, c->size, c->count);
        src = split;
    }
    zt_result r = zt__encode_frame(c->encoder, src, bytes, c->out, c->out_size, &frame, c->diag);
    if (packing == PACK_BYTES) {
        memcpy(c->elements, c->work, bytes);
        unpredict(c->elements, c->size, c->count, predictor);
    }
    if (r == ZT_OK && frame > 0)
        *stored = frame;
    return r;
}

static void bits_form(const plane_coding *c, zt__plane_header *h) {
    uint64_t low = UINT64_MAX, high = 0;
    for (size_t i = 0; i < c->count; i++) {
        uint64_t e = load_element(c->elements + i * c->size, c->size);
        low = e < low ? e : low;
        high = e > high ? e : high;
    }
    h->packing = PACK_BITS;
    h->base = c->count > 0 ? low : 0;
    uint64_t span = c->count > 0 ? high - low : 0;
    while (h->bit_width < 64 && span >> h->bit_width != 0)
        h->bit_width++;
    /* The largest number of that width must fit above base, and the base can be lowered for it. */
    uint64_t mask = element_mask(c->size);
    uint64_t most = h->bit_width == 0 ? 0 : UINT64_MAX >> (64 - h->bit_width);
    if (h->base > mask - most)
        h->base = mask - most;
}

static void write_bits(plane_coding *c, const zt__plane_header *h) {
    memset(c->out, 0, h->stored_size);
    for (uint64_t i = 0; i < c->count; i++) {
        uint64_t e = load_element(c->elements + i * c->size, c->size);
        put_bits(c->out, i * h->bit_width, h->bit_width, e - h->base);
    }
}

/* The smallest form, the first of them on a tie: raw elements, the zstd forms, bits. A raw form with a predictor or
 * byte planes is as large as the plain one before it, so it never wins. */
static zt_result choose_form(plane_coding *c, zt__plane_header *h) {
    size_t best = (size_t)c->size * c->count, stored;
    zt__plane_header empty = *h;
    for (uint8_t form = 0; form < 6 && !c->encoder->raw_only && best > 0; form++) {
        uint8_t predictor = form / 2, packing = form % 2;
        if (packing == PACK_BYTES && c->size == 1)
            continue;
        ZT_TRY(try_zstd(c, predictor, packing, &stored));
        if (stored < best) {
            best = stored;
            *h = empty;
            h->predictor = predictor;
            h->packing = packing;
            h->codec = ZT__CODEC_ZSTD;
        }
    }
    zt__plane_header bits = empty;
    bits_form(c, &bits);
    uint64_t bits_bytes = bits_size(c->count, bits.bit_width);
    if (bits_bytes < best) {
        best = (size_t)bits_bytes;
        *h = bits;
    }
    h->stored_size = (uint32_t)best;
    return ZT_OK;
}

zt_result zt__encode_plane(zt__encoder *encoder, uint32_t element_size, uint32_t count, const void *src, void *scratch,
                           uint8_t *dst, size_t dst_size, size_t *used, zt_diag *diag) {
    *used = 0;
    size_t bytes = (size_t)element_size * count, stored;
    if (dst_size < zt__plane_bound(element_size, count) || (uint64_t)element_size * count > UINT32_MAX)
        return zt__fail(diag, ZT_INTERNAL, 0, ZT__NO_OFFSET, "no room for a plane");
    plane_coding c = {.encoder = encoder, .size = element_size, .count = count, .diag = diag};
    c.elements = scratch;
    c.work = c.elements + bytes;
    c.out = dst + ZT__PLANE_HEADER_SIZE;
    c.out_size = dst_size - ZT__PLANE_HEADER_SIZE;
    turn_bytes(c.elements, src, element_size, count);

    zt__plane_header h = {.element_size = (uint8_t)element_size, .count = count};
    h.hash = zt__hash(c.elements, bytes);
    ZT_TRY(choose_form(&c, &h));
    if (h.packing == PACK_BITS)
        write_bits(&c, &h);
    else if (h.codec == ZT__CODEC_ZSTD)
        ZT_TRY(try_zstd(&c, h.predictor, h.packing, &stored));
    else
        memcpy(c.out, c.elements, bytes);
    zt__coder writing = zt__writing(dst);
    zt__code_plane(&writing, &h);
    *used = ZT__PLANE_HEADER_SIZE + h.stored_size;
    return ZT_OK;
}

zt_result zt__planes_begin(zt__plane_writer *w, zt__encoder *encoder, size_t header_size, uint64_t capacity,
                           uint64_t largest, zt_diag *diag) {
    void *block;
    *w = (zt__plane_writer){.encoder = encoder, .diag = diag, .used = header_size};
    ZT_TRY(zt__alloc_raw(encoder->memory, capacity, 1, diag, &block));
    w->out = block;
    w->capacity = capacity;
    ZT_TRY(zt__alloc_raw(encoder->memory, largest, 2, diag, &w->scratch));
    w->scratch_size = largest;
    return ZT_OK;
}

zt_result zt__planes_put(zt__plane_writer *w, uint32_t element_size, uint32_t count, const void *src) {
    size_t used = 0;
    ZT_TRY(zt__encode_plane(w->encoder, element_size, count, src, w->scratch, w->out + w->used,
                            (size_t)w->capacity - w->used, &used, w->diag));
    w->used += used;
    return ZT_OK;
}

zt_result zt__planes_end(zt__plane_writer *w, zt_result result, uint8_t **out, uint64_t *out_capacity,
                         size_t *out_size) {
    bool whole = result == ZT_OK;
    zt__free(w->encoder->memory, w->scratch, w->scratch_size, 2);
    if (!whole)
        zt__free(w->encoder->memory, w->out, w->capacity, 1);
    *out = whole ? w->out : NULL;
    *out_capacity = whole ? w->capacity : 0;
    *out_size = whole ? w->used : 0;
    return result;
}
