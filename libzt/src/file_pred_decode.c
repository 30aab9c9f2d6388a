/* SPDX-License-Identifier: Apache-2.0 */
/* Decoding of predicted tiles (file_pred.h). This file decides what is accepted; kernels only compute. */
#include "file_pred_frame.h"

#include <string.h>

#include "base_bytes.h"
#include "base_hash.h"

bool zt__pred_shape_ok(const zt__pred_shape *shape) {
    return shape->width >= 1 && shape->width <= ZT__PRED_MAX_EDGE && shape->height >= 1 &&
           shape->height <= ZT__PRED_MAX_EDGE && shape->channels >= 1 && shape->channels <= 4 &&
           (shape->channel_bytes == 1 || shape->channel_bytes == 2);
}

uint32_t zt__pred_kernels(const zt__pred_kernel *out[ZT__PRED_KERNELS]) {
    const zt__pred_kernel *all[ZT__PRED_KERNELS] = {zt__pred_kernel_c(),     zt__pred_kernel_vector(),
                                                    zt__pred_kernel_sse41(), zt__pred_kernel_neon(),
                                                    zt__pred_kernel_avx2(),  zt__pred_kernel_avx512()};
    uint32_t n = 0;
    for (uint32_t i = 0; i < ZT__PRED_KERNELS; i++)
        if (all[i])
            out[n++] = all[i];
    return n;
}

const zt__pred_kernel *zt__pred_kernel_best(void) {
    const zt__pred_kernel *kernels[ZT__PRED_KERNELS];
    return kernels[zt__pred_kernels(kernels) - 1];
}

/* Odd multiples of a cache line: rows of a power of two would fall on the same lines. */
static size_t odd_lines(size_t size) {
    return ((size + 63) & ~(size_t)63) | 64;
}

static size_t row_pitch(const zt__pred_shape *shape) {
    return odd_lines((size_t)shape->width + 2 * ZT__PRED_MARGIN);
}

/* Vector loops keep 4 channels of any tile. */
static size_t texel_row_pitch(const zt__pred_shape *shape) {
    return odd_lines((size_t)shape->width * 4 * shape->channel_bytes + 5 * ZT__PRED_MARGIN);
}

static uint32_t residual_rows(const zt__pred_shape *shape) {
    return shape->channels * shape->channel_bytes * ZT__PRED_STRIP;
}

/* acts, none, 2 x channels of magnitudes, residuals */
static size_t rows_size(const zt__pred_shape *shape) {
    return row_pitch(shape) * (2 + 2 * (size_t)shape->channels + residual_rows(shape)) +
           texel_row_pitch(shape) * (ZT__PRED_STRIP + 1);
}

enum {
    FILL = 16, /* slots that are filled at a time; some behind a table are written too */
    TABLE_BYTES = (ZT__PRED_TABLES * ZT__PRED_SLOTS + FILL) * 4,
    STATE_BYTES = ZT__PRED_LANES * 4,
    TAIL_BYTES = 2 * ZT__PRED_REACH,
    ALIGNMENT = 64
};

size_t zt__pred_scratch_size(const zt__pred_shape *shape) {
    return ALIGNMENT + TABLE_BYTES + STATE_BYTES + TAIL_BYTES + rows_size(shape);
}

static void *aligned(void *p) {
    return (uint8_t *)p + (ALIGNMENT - (uintptr_t)p % ALIGNMENT) % ALIGNMENT;
}

/* Hands out the scratch memory. Rows begin as zeros: margins and planes that are not coded stay so. */
static void place(zt__pred_job *job, void *scratch) {
    const zt__pred_shape *shape = &job->shape;
    job->tables = aligned(scratch);
    job->states = job->tables + TABLE_BYTES / 4;
    job->tail = (uint8_t *)(job->states + ZT__PRED_LANES);
    uint8_t *at = job->tail + TAIL_BYTES;
    memset(at, 0, rows_size(shape));
    job->pitch = row_pitch(shape);
    job->texel_pitch = texel_row_pitch(shape);
    at += ZT__PRED_MARGIN;
    job->acts = at;
    at += job->pitch;
    job->none = at;
    at += job->pitch;
    for (uint32_t j = 0; j < shape->channels; j++) {
        job->above[j] = at;
        job->current[j] = at + job->pitch;
        at += 2 * job->pitch;
    }
    for (uint32_t k = 0; k < job->planes; k++) {
        job->residuals[k] = at;
        at += ZT__PRED_STRIP * job->pitch;
    }
    job->texels = at + ZT__PRED_MARGIN; /* a second one: waves begin far to the left */
    job->top = job->texels + ZT__PRED_STRIP * job->texel_pitch;
}

/* Bits, the least significant of a byte first. Behind the end they are zero. */
typedef struct bits {
    const uint8_t *data;
    size_t size;
    uint64_t at; /* in bits; may be behind the end */
} bits;

/* At least 57 bits from b->at on. */
static inline uint64_t peek(const bits *b) {
    size_t byte = (size_t)(b->at >> 3);
    uint64_t v = 0;
    if (byte < b->size && b->size - byte >= 8)
        v = zt__load64(b->data + byte);
    else
        for (size_t i = byte; i < b->size; i++)
            v |= (uint64_t)b->data[i] << 8 * (i - byte);
    return v >> (b->at & 7);
}

/* One frequency: the bit length of f + 1 as the difference from that of the one before, then its bits below the first.
 * v: the bits from b->at on, at least MOST_BITS; those used are shifted out. Returns false when it is above what a
 * table can hold. */
enum { MAX_DIFFERENCE = 2 * ZT__PRED_BITS, MOST_BITS = MAX_DIFFERENCE + 1 + ZT__PRED_BITS };

static inline bool take_frequency(bits *b, uint64_t *v, uint32_t *length, uint32_t *f) {
    uint32_t z = (uint32_t)__builtin_ctz((uint32_t)*v | UINT32_C(1) << (MAX_DIFFERENCE + 1));
    uint32_t k = *length + ((z >> 1) ^ (0 - (z & 1)));
    b->at += z + 1;                              /* also when it is refused: zeros may come from behind the end */
    if (z > MAX_DIFFERENCE || k > ZT__PRED_BITS) /* a negative k is a large one */
        return false;
    *f = (1u << k) - 1 + ((uint32_t)(*v >> (z + 1)) & ((1u << k) - 1));
    *v >>= z + 1 + k;
    *length = k;
    b->at += k;
    return true;
}

/* The slots of one symbol, and up to FILL more behind them: so most symbols need no loop. */
static inline void fill_slots(uint32_t *slots, uint32_t f, uint32_t entry) {
    uint32_t s = 0;
    do {
        for (uint32_t i = 0; i < FILL; i++)
            slots[s + i] = entry + (i << ZT__PRED_OFFSET_AT);
        entry += (uint32_t)FILL << ZT__PRED_OFFSET_AT;
        s += FILL;
    } while (s < f);
}

/* Slots of one table, and up to FILL behind them (rule 5307). */
static bool take_table(bits *in, uint32_t channel_bytes, uint32_t *table) {
    uint32_t sum = 0, length = ZT__PRED_BITS - 3;
    bits b = *in;              /* a copy that nothing else points to is kept in registers */
    uint64_t v = 0, known = 0; /* bits of v are good up to known */
    for (uint32_t i = 0; i < 256 && sum < ZT__PRED_SLOTS; i++) {
        uint32_t f;
        if (known < b.at + MOST_BITS) {
            v = peek(&b);
            known = b.at + 57;
        }
        bool ok = take_frequency(&b, &v, &length, &f) && f <= ZT__PRED_SLOTS - sum;
        in->at = b.at;
        if (!ok)
            return false;
        /* residuals of one byte by growing magnitude: 0, -1, 1, -2, 2 ... */
        uint32_t symbol = channel_bytes == 1 ? ((i >> 1) ^ (0 - (i & 1))) & 255 : i;
        fill_slots(table + sum, f, f | symbol << ZT__PRED_SYMBOL_AT);
        sum += f;
    }
    return sum == ZT__PRED_SLOTS;
}

static uint32_t blocks_across(const zt__pred_shape *shape) {
    return (shape->width + ZT__PRED_BLOCK - 1) / ZT__PRED_BLOCK;
}

static uint32_t blocks_down(const zt__pred_shape *shape) {
    return (shape->height + ZT__PRED_STRIP - 1) / ZT__PRED_STRIP;
}

static uint32_t coded_planes(const zt__pred_job *job) {
    uint32_t n = 0;
    for (uint32_t k = 0; k < job->planes; k++)
        n += job->coded >> k & 1;
    return n;
}

/* Zero map and tables (rules 5306 to 5308). */
static uint32_t take_tables(zt__pred_job *job, uint32_t table_count, bool zeros, zt__cursor *in) {
    bits b = {in->data + in->at, zt__left(in), 0};
    if (zeros) {
        job->zeros = b.data;
        b.at = (uint64_t)coded_planes(job) * blocks_across(&job->shape) * blocks_down(&job->shape);
        if (b.at > (uint64_t)b.size * 8)
            return 5306;
    }
    for (uint32_t i = 0; i < table_count; i++)
        if (!take_table(&b, job->shape.channel_bytes, job->tables + (size_t)i * ZT__PRED_SLOTS))
            return b.at > (uint64_t)b.size * 8 ? 5306 : 5307;
    if (b.at > (uint64_t)b.size * 8)
        return 5306;
    if ((b.at & 7) != 0 && b.data[b.at >> 3] >> (b.at & 7) != 0)
        return 5308;
    zt__take(in, (size_t)((b.at + 7) >> 3));
    return 0;
}

static void set_map(zt__pred_job *job, uint32_t k, uint32_t act, uint32_t number) {
    job->maps[k].tables[act] = job->tables + (size_t)number * ZT__PRED_SLOTS;
    job->maps[k].numbers[act] = (uint8_t)number;
}

/* Of the flags byte; tiles with a frame come elsewhere. */
enum { TRANSFORMS = ZT__PRED_COLOUR | ZT__PRED_NORMAL, RESERVED = ZT__PRED_FRAME | 0xC0 };

/* Everything in front of the words (rules 5302 to 5310). */
static uint32_t take_header(zt__pred_job *job, zt__cursor *in) {
    uint32_t flags = zt__take8(in), table_count = zt__take8(in);
    job->coded = zt__take8(in);
    for (uint32_t k = 0; k < job->planes; k++)
        job->first[k] = zt__take8(in);
    if (in->bad || (flags & RESERVED) != 0 || (flags >> 2 & 3) == 3 || job->coded >> job->planes != 0)
        return 5302;
    job->colour = flags & ZT__PRED_COLOUR;
    job->normal = flags & ZT__PRED_NORMAL;
    job->lanes = 16u << (flags >> 2 & 3);
    if (!zt__pred_transform_ok(&job->shape, flags & TRANSFORMS))
        return 5303;
    if (job->coded == 0)
        return (flags & ~(uint32_t)TRANSFORMS) != 0 || table_count != 0 || zt__left(in) != 0 ? 5304 : 0;
    if (table_count < 1 || table_count > ZT__PRED_TABLES)
        return 5304;
    for (uint32_t k = 0; k < job->planes; k++)
        for (uint32_t i = 0; (job->coded >> k & 1) != 0 && i < ZT__PRED_ACTS; i += 2) {
            uint32_t pair = zt__take8(in);
            if ((pair & 15) >= table_count || pair >> 4 >= table_count)
                return 5305;
            set_map(job, k, i, pair & 15);
            set_map(job, k, i + 1, pair >> 4);
        }
    if (in->bad)
        return 5302;
    uint32_t broken = take_tables(job, table_count, (flags & ZT__PRED_ZEROS) != 0, in);
    if (broken)
        return broken;
    for (uint32_t i = 0; i < job->lanes; i++) {
        job->states[i] = zt__take32(in);
        if (job->states[i] < ZT__PRED_LOW || job->states[i] >> 31 != 0)
            return 5309;
    }
    return zt__left(in) % 2 != 0 ? 5310 : 0;
}

/* How many of the next count bits are as the first one is, 1 to 32. */
static uint32_t run_of(const uint8_t *map, uint64_t at, uint32_t count, bool *coded) {
    uint64_t v = 0;
    uint32_t bytes = zt__min32(5, (uint32_t)((at + count + 7) / 8 - at / 8)), most = zt__min32(32, count);
    for (uint32_t i = 0; i < bytes; i++)
        v |= (uint64_t)map[at / 8 + i] << 8 * i;
    v >>= at & 7;
    *coded = v & 1;
    return zt__min32((uint32_t)__builtin_ctzll((*coded ? ~v : v) | UINT64_C(1) << 32), most);
}

/* One row of one plane: the blocks that are not zero. */
static void decode_samples(const zt__pred_kernel *kernel, zt__pred_job *job, uint32_t k, uint64_t bit, uint8_t *out) {
    uint32_t width = job->shape.width, across = blocks_across(&job->shape);
    for (uint32_t i = 0; i < across;) {
        bool coded;
        uint32_t from = i * ZT__PRED_BLOCK;
        i += run_of(job->zeros, bit + i, across - i, &coded);
        uint32_t to = zt__min32(i * ZT__PRED_BLOCK, width);
        if (coded)
            kernel->symbols(job, &job->maps[k], out, from, to);
        else
            memset(out + from, 0, to - from);
    }
}

/* One row of one channel: its residuals and their magnitudes. coded_index: of the first of its planes. Returns that of
 * the plane behind. */
static uint32_t decode_channel(const zt__pred_kernel *kernel, zt__pred_job *job, uint32_t j, uint32_t y,
                               uint32_t coded_index) {
    static const uint8_t reference[4] = {0, 0, 1, 0};
    uint32_t width = job->shape.width, channel_bytes = job->shape.channel_bytes, across = blocks_across(&job->shape);
    const uint8_t *beside = j ? job->current[reference[j]] : NULL, *high = NULL;
    uint8_t *row = NULL;
    for (uint32_t k = j * channel_bytes; k < (j + 1) * channel_bytes; k++) {
        high = row;
        row = job->residuals[k] + y % ZT__PRED_STRIP * job->pitch;
        if (!(job->coded >> k & 1))
            continue;
        uint64_t bit = ((uint64_t)coded_index++ * blocks_down(&job->shape) + y / ZT__PRED_STRIP) * across;
        bool coded = true;
        if (job->zeros && run_of(job->zeros, bit, across, &coded) == across && !coded) {
            memset(row, 0, width);
            continue;
        }
        kernel->select(job->above[j], beside, high, job->acts, width);
        if (job->zeros)
            decode_samples(kernel, job, k, bit, row);
        else
            kernel->symbols(job, &job->maps[k], row, 0, width);
    }
    kernel->measure(high, row, job->current[j], width);
    return coded_index;
}

/* One row of all planes. Returns false when the words are used up. */
static bool decode_row(const zt__pred_kernel *kernel, zt__pred_job *job, uint32_t y) {
    uint32_t coded_index = 0;
    for (uint32_t j = 0; j < job->shape.channels; j++)
        coded_index = decode_channel(kernel, job, j, y, coded_index);
    for (uint32_t j = 0; j < job->shape.channels; j++) {
        uint8_t *t = job->above[j];
        job->above[j] = job->current[j];
        job->current[j] = t;
    }
    return !job->exhausted;
}

/* Adds the prediction of the first texel to its residuals, which nothing else looks at any more; or takes both away. */
static void seed(zt__pred_job *job, bool add) {
    for (uint32_t j = 0; j < job->shape.channels; j++) {
        uint8_t *const *rows = job->residuals + (size_t)j * job->shape.channel_bytes;
        const uint8_t *first = job->first + zt__pred_channel(job->shape.channels, j) * job->shape.channel_bytes;
        if (job->shape.channel_bytes == 1) {
            rows[0][0] = (uint8_t)(add ? rows[0][0] + *first : 0);
            continue;
        }
        uint32_t z = (uint32_t)rows[0][0] << 8 | rows[1][0];
        uint32_t r = ((z >> 1 ^ (0 - (z & 1))) + zt__load16(first)) & 0xFFFF;
        z = add ? (r << 1 ^ (0 - (r >> 15))) & 0xFFFF : 0;
        rows[0][0] = (uint8_t)(z >> 8);
        rows[1][0] = (uint8_t)z;
    }
}

/* What is left to do with rows of texels while they are hot. */
static void finish_rows(const zt__pred_kernel *kernel, const zt__pred_job *job, const uint8_t *slopes, uint32_t rows,
                        uint8_t *dst, size_t dst_pitch, zt__hasher *hasher) {
    size_t row_size = (size_t)job->shape.width * job->planes;
    for (uint32_t i = 0; job->normal && i < rows; i++)
        zt__pred_finish_slopes(kernel, slopes, dst + i * dst_pitch, job->shape.channels, job->shape.width);
    if (hasher)
        zt__hash_rows_more(hasher, dst, row_size, rows, dst_pitch);
}

uint32_t zt__pred_decode_hashed(const zt__pred_kernel *kernel, const zt__pred_shape *shape, const uint8_t *stored,
                                size_t size, void *scratch, uint8_t *dst, size_t dst_pitch, uint64_t *hash) {
    zt__pred_job job = {.shape = *shape, .planes = shape->channels * shape->channel_bytes};
    zt__hasher hasher;
    uint8_t slopes[ZT__PRED_SLOPES];
    place(&job, scratch);
    zt__cursor in = zt__cursor_of(stored, size);
    uint32_t broken = take_header(&job, &in);
    if (broken)
        return broken;
    job.next = stored + in.at;
    job.end = stored + size;
    if (job.normal)
        zt__pred_prepare_slopes(kernel, slopes);
    if (hash)
        zt__hash_begin(&hasher);
    for (uint32_t y = 0; y < shape->height; y += ZT__PRED_STRIP) {
        uint32_t rows = zt__min32(ZT__PRED_STRIP, shape->height - y);
        for (uint32_t i = 0; job.coded && i < rows; i++)
            if (!decode_row(kernel, &job, y + i))
                return 5311;
        if (y == 0)
            seed(&job, true);
        kernel->restore(&job, rows, dst + y * dst_pitch, dst_pitch);
        if (y == 0)
            seed(&job, false);
        finish_rows(kernel, &job, slopes, rows, dst + y * dst_pitch, dst_pitch, hash ? &hasher : NULL);
    }
    if (job.next != job.end)
        return 5311;
    for (uint32_t i = 0; job.coded && i < job.lanes; i++)
        if (job.states[i] != ZT__PRED_LOW)
            return 5312;
    if (hash)
        *hash = zt__hash_end(&hasher);
    return 0;
}

uint32_t zt__pred_decode(const zt__pred_kernel *kernel, const zt__pred_shape *shape, const uint8_t *stored, size_t size,
                         void *scratch, uint8_t *dst, size_t dst_pitch) {
    return zt__pred_decode_hashed(kernel, shape, stored, size, scratch, dst, dst_pitch, NULL);
}
