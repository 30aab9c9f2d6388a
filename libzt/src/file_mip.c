/* SPDX-License-Identifier: Apache-2.0 */
#include "file_mip.h"

#include "base_diag.h"
#include "base_parallel.h"
#include "file_ring.h"

enum {
    PARALLEL_TEXELS = 32768 /* less work than this is not worth waking threads for */
};

/* From one level to the next. */
typedef struct mip_step {
    uint32_t level;         /* the source's */
    uint32_t width, width2; /* texels of a row before and behind */
    uint32_t height2, depth;
    zt__axis x;
    uint32_t pad;     /* texels in front of and behind a source row */
    float *x_weights; /* odd widths: one set for each output texel */
    zt__ring rows;
    zt__ring slices;     /* depth > 1 */
    uint32_t slice_rows; /* rows in the slice that is being filled */
    float *out;          /* ZT__MIP_BATCH rows */
    bool out_negative[ZT__MIP_BATCH];
} mip_step;

struct zt__mip {
    zt__memory *memory;
    const zt_parallel *parallel;
    zt__mip_sink sink;
    zt__texels texels;
    uint32_t step_count;
    mip_step *steps;
    uint64_t scratch_size; /* floats for each worker */
    float *scratch;
};

static void run(const zt__mip *mip, uint32_t rows, uint32_t width, zt__task *task, void *context) {
    bool small = (uint64_t)rows * width < PARALLEL_TEXELS;
    zt__run(small ? NULL : mip->parallel, rows, task, context);
}

static float *scratch_of(const zt__mip *mip, unsigned worker) {
    return mip->scratch + worker * mip->scratch_size;
}

/* ---- along x ------------------------------------------------------------------------------------- */

static void pad_texel(const mip_step *s, float *row, int64_t j) {
    int64_t from = zt__axis_wrap(&s->x, j);
    zt__v4 texel = {0};
    if (from >= 0)
        texel = zt__load4(row + 4 * from);
    zt__store4(row + 4 * j, texel);
}

/* row: the texels, with room for pad texels on both sides. */
static void pad_row(const mip_step *s, float *row) {
    int64_t n = s->width, pad = s->pad;
    for (int64_t k = 0; k < pad; k++) {
        pad_texel(s, row, k - pad);
        pad_texel(s, row, n + k);
    }
}

/* The sum runs over differences to a middle texel, so that a constant row stays exactly that constant. */
static void filter_row(const mip_step *s, const float *row, float *out) {
    uint32_t taps = s->x.taps;
    const float *weights = s->x.weights;
    for (uint32_t i = 0; i < s->width2; i++) {
        const float *src = row + 4 * zt__axis_first(&s->x, i);
        if (s->x_weights)
            weights = s->x_weights + (size_t)i * taps;
        zt__v4 middle = zt__load4(src + 4 * (taps / 2)), sum = {0};
        for (uint32_t t = 0; t < taps; t++)
            sum += weights[t] * (zt__load4(src + 4 * t) - middle);
        zt__store4(out + 4 * (size_t)i, middle + sum);
    }
}

/* Even widths, where windows advance by two. */
static void filter_even_row(const mip_step *s, const float *row, float *out) {
    uint32_t taps = s->x.taps;
    const float *src = row + 4 * zt__axis_first(&s->x, 0);
    for (uint32_t i = 0; i < s->width2; i++, src += 8) {
        zt__v4 middle = zt__load4(src + 4 * (taps / 2)), even = {0}, odd = {0};
        for (uint32_t t = 0; t + 1 < taps; t += 2) {
            even += s->x.weights[t] * (zt__load4(src + 4 * t) - middle);
            odd += s->x.weights[t + 1] * (zt__load4(src + 4 * t + 4) - middle);
        }
        zt__store4(out + 4 * (size_t)i, middle + (even + odd));
    }
}

typedef struct x_task {
    const zt__mip *mip;
    mip_step *step;
    const uint8_t *bytes; /* level 0 */
    size_t pitch;
    const float *floats; /* other levels */
    const bool *negative;
} x_task;

static void filter_x(void *context, size_t index, unsigned worker) {
    const x_task *t = context;
    mip_step *s = t->step;
    float *row = scratch_of(t->mip, worker) + 4 * (size_t)s->pad;
    bool negative;
    if (t->bytes) {
        negative = zt__texels_load(&t->mip->texels, t->bytes + index * t->pitch, s->width, row);
    } else {
        memcpy(row, t->floats + 4 * index * s->width, 4 * sizeof(float) * s->width);
        negative = t->negative[index];
    }
    float *out = zt__ring_slot(&s->rows, (uint32_t)index);
    zt__ring_mark(&s->rows, (uint32_t)index, negative);
    if (s->width == 1) {
        memcpy(out, row, 4 * sizeof(float));
        return;
    }
    pad_row(s, row);
    if (s->x.fixed && s->x.taps % 2 == 0)
        filter_even_row(s, row, out);
    else
        filter_row(s, row, out);
}

/* ---- along y and z --------------------------------------------------------------------------------- */

typedef struct line_task {
    const zt__ring *ring;
    uint64_t output; /* the first; -- of which all rows are made when by_output, else parts of one line */
    bool by_output;
    size_t from, length; /* floats: part of the line */
    float *dst;
} line_task;

static void filter_line(void *context, size_t index, unsigned worker) {
    const line_task *t = context;
    (void)worker;
    if (t->by_output)
        zt__ring_combine(t->ring, t->output + index, 0, t->length, t->dst + index * t->length);
    else
        zt__ring_combine(t->ring, t->output, t->from + index * t->length, t->length, t->dst + index * t->length);
}

/* ---- storing ----------------------------------------------------------------------------------------- */

typedef struct store_task {
    const zt__mip *mip;
    const float *rows;
    const bool *negative;
    uint32_t width;
    uint8_t *dst;
    size_t pitch;
} store_task;

static void store_row(void *context, size_t index, unsigned worker) {
    const store_task *t = context;
    float *work = scratch_of(t->mip, worker);
    memcpy(work, t->rows + 4 * index * t->width, 4 * sizeof(float) * t->width);
    zt__texels_store(&t->mip->texels, work, t->negative[index], t->width, t->dst + index * t->pitch);
}

/* ---- from level to level --------------------------------------------------------------------------------- */

static zt_result push_rows(zt__mip *mip, uint32_t step, x_task *task, uint32_t n, zt_diag *diag);

/* s->out holds m rows of the next level, from row y on, modulo its height. */
static zt_result emit(zt__mip *mip, mip_step *s, uint32_t z, uint32_t y, uint32_t m, zt_diag *diag) {
    size_t pitch = (size_t)s->width2 * mip->texels.format->block_bytes;
    for (uint32_t done = 0; done < m;) {
        uint32_t row = (y + done) % s->height2, n = zt__min32(m - done, s->height2 - row);
        store_task t = {.mip = mip, .width = s->width2, .pitch = pitch};
        ZT_TRY(mip->sink.place(mip->sink.user, s->level + 1, z, row, &n, &t.dst, diag));
        t.rows = s->out + 4 * (size_t)done * s->width2;
        t.negative = s->out_negative + done;
        run(mip, n, s->width2, store_row, &t);
        ZT_TRY(mip->sink.commit(mip->sink.user, s->level + 1, z, row, n, diag));
        done += n;
    }
    if (s->level + 1 == mip->step_count)
        return ZT_OK;
    x_task next = {.mip = mip, .floats = s->out, .negative = s->out_negative};
    return push_rows(mip, s->level + 1, &next, m, diag);
}

/* All slices of the next level that the ring of slices can give by now. */
static zt_result emit_slices(zt__mip *mip, mip_step *s, zt_diag *diag) {
    size_t row = 4 * (size_t)s->width2;
    while (zt__ring_ready(&s->slices, 1) == 1) {
        uint64_t output = s->slices.done;
        uint32_t z = zt__ring_place(&s->slices, output);
        bool negative = zt__ring_negative(&s->slices, output);
        for (uint32_t y = 0; y < s->height2; y += ZT__MIP_BATCH) {
            uint32_t m = zt__min32(ZT__MIP_BATCH, s->height2 - y);
            line_task t = {&s->slices, output, false, y * row, row, s->out};
            run(mip, m, s->width2, filter_line, &t);
            for (uint32_t i = 0; i < m; i++)
                s->out_negative[i] = negative;
            ZT_TRY(emit(mip, s, z, y, m, diag));
        }
        zt__ring_take(&s->slices, 1);
    }
    return ZT_OK;
}

/* m rows of a slice of the ring of slices. */
static void fill_slice(zt__mip *mip, mip_step *s, uint32_t m) {
    size_t row = 4 * (size_t)s->width2;
    for (uint32_t i = 0; i < m; i++) {
        uint64_t output = s->rows.done + i;
        bool negative = zt__ring_negative(&s->rows, output);
        if (negative || s->slice_rows + i == 0)
            zt__ring_mark(&s->slices, 0, negative);
        float *slice = zt__ring_slot(&s->slices, 0);
        line_task t = {&s->rows, output, true, 0, row, slice + zt__ring_place(&s->rows, output) * row};
        run(mip, 1, s->width2, filter_line, &t);
    }
    s->slice_rows += m;
}

static zt_result emit_rows(zt__mip *mip, mip_step *s, uint32_t m, zt_diag *diag) {
    uint64_t output = s->rows.done;
    line_task t = {&s->rows, output, true, 0, 4 * (size_t)s->width2, s->out};
    run(mip, m, s->width2, filter_line, &t);
    for (uint32_t i = 0; i < m; i++)
        s->out_negative[i] = zt__ring_negative(&s->rows, output + i);
    return emit(mip, s, 0, zt__ring_place(&s->rows, output), m, diag);
}

static zt_result push_rows(zt__mip *mip, uint32_t step, x_task *task, uint32_t n, zt_diag *diag) {
    mip_step *s = &mip->steps[step];
    task->step = s;
    run(mip, n, s->width, filter_x, task);
    zt__ring_commit(&s->rows, n);
    uint32_t m;
    while ((m = zt__ring_ready(&s->rows, ZT__MIP_BATCH)) > 0) {
        if (s->depth > 1)
            fill_slice(mip, s, m);
        else
            ZT_TRY(emit_rows(mip, s, m, diag));
        zt__ring_take(&s->rows, m);
    }
    if (!zt__ring_complete(&s->rows))
        return ZT_OK;
    zt__ring_reset(&s->rows);
    if (s->depth == 1)
        return ZT_OK;
    s->slice_rows = 0;
    zt__ring_commit(&s->slices, 1);
    ZT_TRY(emit_slices(mip, s, diag));
    if (zt__ring_complete(&s->slices))
        zt__ring_reset(&s->slices);
    return ZT_OK;
}

zt_result zt__mip_push(zt__mip *mip, const uint8_t *rows, uint32_t n, size_t pitch, zt_diag *diag) {
    x_task t = {.mip = mip, .bytes = rows, .pitch = pitch};
    return push_rows(mip, 0, &t, n, diag);
}

uint32_t zt__mip_first_row(const zt__mip *mip, uint32_t level) {
    if (level == 0 || mip->steps[level - 1].depth > 1)
        return 0;
    return zt__ring_place(&mip->steps[level - 1].rows, 0);
}

/* ---- set-up -------------------------------------------------------------------------------------------------- */

static zt_result init_x(zt__mip *mip, mip_step *s, zt_diag *diag) {
    int64_t before = -zt__axis_first(&s->x, 0);
    int64_t behind = zt__axis_first(&s->x, s->width2 - 1) + s->x.taps - (int64_t)s->width;
    int64_t pad = before > behind ? before : behind;
    s->pad = pad > 0 ? (uint32_t)pad : 0;
    if (s->x.fixed)
        return ZT_OK;
    void *block;
    uint64_t count = (uint64_t)s->width2 * s->x.taps;
    ZT_TRY(zt__alloc_raw(mip->memory, count, sizeof(float), diag, &block));
    s->x_weights = block;
    for (uint32_t i = 0; i < s->width2; i++)
        zt__axis_weights(&s->x, i, s->x_weights + (size_t)i * s->x.taps);
    return ZT_OK;
}

static zt_result init_step(zt__mip *mip, const zt__mip_desc *desc, uint32_t level, zt_diag *diag) {
    mip_step *s = &mip->steps[level];
    const zt__image_record *r = desc->record;
    s->level = level;
    s->width = zt__max32(r->width >> level, 1);
    s->depth = zt__max32(r->depth >> level, 1);
    zt__axis y, z;
    zt__axis_init(&s->x, s->width, desc->filter, desc->wrap_u);
    zt__axis_init(&y, zt__max32(r->height >> level, 1), desc->filter, desc->wrap_v);
    zt__axis_init(&z, s->depth, desc->filter, desc->wrap_w);
    s->width2 = s->x.n2;
    s->height2 = y.n2;
    uint64_t row = 4 * (uint64_t)s->width2;
    ZT_TRY(init_x(mip, s, diag));
    /* Rows and slices of the level before come in the order in which its step gives them. */
    mip_step *last = level > 0 ? s - 1 : NULL;
    uint32_t start_y = zt__mip_first_row(mip, level);
    uint32_t start_z = last && last->depth > 1 ? zt__ring_place(&last->slices, 0) : 0;
    ZT_TRY(zt__ring_init(&s->rows, mip->memory, &y, row, ZT__MIP_BATCH, start_y, diag));
    if (s->depth > 1)
        ZT_TRY(zt__ring_init(&s->slices, mip->memory, &z, row * s->height2, 1, start_z, diag));
    void *block;
    ZT_TRY(zt__alloc_raw(mip->memory, ZT__MIP_BATCH * row, sizeof(float), diag, &block));
    s->out = block;
    return ZT_OK;
}

static zt_result init_mip(zt__mip *mip, const zt__mip_desc *desc, zt_diag *diag) {
    void *block;
    const zt__image_record *r = desc->record;
    zt__texels_init(&mip->texels, desc->format, r->transfer, r->alpha_mode, desc->is_normal);
    uint32_t count = r->levels - 1U;
    ZT_TRY(zt__alloc(mip->memory, count, sizeof(mip_step), diag, &block));
    mip->steps = block;
    mip->step_count = count;
    uint32_t pad = 0;
    for (uint32_t i = 0; i < count; i++) {
        ZT_TRY(init_step(mip, desc, i, diag));
        pad = zt__max32(pad, mip->steps[i].pad);
    }
    mip->scratch_size = 4 * ((uint64_t)r->width + 2 * (uint64_t)pad);
    uint64_t workers = zt__workers(mip->parallel);
    ZT_TRY(zt__alloc_raw(mip->memory, workers * mip->scratch_size, sizeof(float), diag, &block));
    mip->scratch = block;
    return ZT_OK;
}

zt_result zt__mip_new(zt__memory *memory, const zt_parallel *parallel, const zt__mip_desc *desc,
                      const zt__mip_sink *sink, zt_diag *diag, zt__mip **out) {
    void *block;
    *out = NULL;
    ZT_TRY(zt__alloc(memory, 1, sizeof(zt__mip), diag, &block));
    zt__mip *mip = block;
    mip->memory = memory;
    mip->parallel = parallel;
    mip->sink = *sink;
    zt_result r = init_mip(mip, desc, diag);
    if (r != ZT_OK)
        zt__mip_free(mip);
    else
        *out = mip;
    return r;
}

static void free_step(zt__memory *memory, mip_step *s) {
    uint64_t row = 4 * (uint64_t)s->width2;
    zt__free(memory, s->x_weights, (uint64_t)s->width2 * s->x.taps, sizeof(float));
    zt__free(memory, s->out, ZT__MIP_BATCH * row, sizeof(float));
    zt__ring_free(&s->rows, memory);
    zt__ring_free(&s->slices, memory);
}

void zt__mip_free(zt__mip *mip) {
    if (!mip)
        return;
    zt__memory *memory = mip->memory;
    for (uint32_t i = 0; i < mip->step_count; i++)
        free_step(memory, &mip->steps[i]);
    zt__free(memory, mip->steps, mip->step_count, sizeof(mip_step));
    uint64_t workers = zt__workers(mip->parallel);
    zt__free(memory, mip->scratch, workers * mip->scratch_size, sizeof(float));
    zt__free(memory, mip, 1, sizeof *mip);
}
