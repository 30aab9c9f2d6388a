/* SPDX-License-Identifier: Apache-2.0 */
/* How hard tiles are coded: what each effort tries, and the choice of the smallest. Sizes decide, so the choice is the
 * same on every machine. */
#include "file_codec.h"
#include "file_pred_frame.h"

enum { CODEC_1 = 0, CANDIDATES = 1 + ZT__PRED_FORMS };

typedef enum forms { NO_FORMS, FORMS_NEAR, ALL_FORMS } forms;

/* What is done beside codec 2 with words (whose own steps are in file_pred_encode.c and file_pred_model.c). Codec 1 and
 * the forms of codec 2 with a frame are the candidates: all are coded at a low level first, and those that promise most
 * once more. */
typedef struct plan {
    uint8_t probe; /* the low level; 0: nothing is tried where codec 2 with words makes the tile smaller */
    uint8_t forms; /* FORMS_NEAR: only where codec 1 promises something */
    uint8_t near;  /* a size is near the best one when it is not above it by 1/near */
    uint8_t tries; /* at the high level; one that is off by more than an eighth is the last */
    uint8_t level;
} plan;

static const plan plans[ZT__PRED_MAX_EFFORT + 1] = {
    {0, 0, 0, 0, 0},          {0, NO_FORMS, 1, 1, 0},   {1, NO_FORMS, 4, 1, 3},    {1, NO_FORMS, 4, 1, 5},
    {1, NO_FORMS, 4, 1, 5},   {1, FORMS_NEAR, 2, 1, 5}, {1, FORMS_NEAR, 2, 1, 15}, {3, ALL_FORMS, 2, 1, 17},
    {3, ALL_FORMS, 2, 2, 19}, {6, ALL_FORMS, 4, 3, 19}};

int zt__level_of_effort(uint32_t effort) {
    static const int levels[ZT__PRED_MAX_EFFORT + 1] = {0, 1, 3, 5, 7, 9, 12, 15, 17, 19};
    return levels[effort];
}

/* One tile on its way. */
typedef struct trial {
    zt__encoder *encoder;
    const plan *plan;
    const zt__pred_shape *shape; /* or NULL */
    const uint8_t *src;
    size_t size;
    uint8_t *frame; /* room for what is tried */
    size_t frame_room;
    uint8_t *values, *samples, *best;
    size_t best_size; /* size: nothing is smaller than raw */
    uint8_t codec;
    uint32_t transform;
    zt_diag *diag;
} trial;

static size_t row_size(const zt__pred_shape *shape) {
    return (size_t)shape->width * shape->channels * shape->channel_bytes;
}

static zt_result take_memory(trial *t, uint32_t effort) {
    uint8_t *memory;
    size_t work = zt__pred_work_size(t->shape), samples = 2 * t->size + row_size(t->shape);
    work = effort > 1 && samples > work ? samples : work;
    ZT_TRY(zt__encoder_memory(t->encoder, (uint64_t)work + t->size, t->diag, &memory));
    t->values = memory; /* they take the place of codec 2's work */
    t->samples = memory + t->size + row_size(t->shape);
    t->best = memory + work;
    return ZT_OK;
}

/* Codec 2 with words. */
static void code_words(trial *t, uint32_t effort) {
    size_t got = zt__pred_encode(t->shape, t->src, row_size(t->shape), effort, t->values, t->best, t->size - 1);
    if (got == 0)
        return;
    t->best_size = got;
    t->codec = ZT__CODEC_PRED;
    t->transform = t->best[0] & (ZT__PRED_COLOUR | ZT__PRED_NORMAL);
}

/* Codes a candidate at a level. *size: of the tile it would be; SIZE_MAX: no smaller than raw. */
static zt_result code_candidate(const trial *t, uint32_t candidate, int level, size_t *size) {
    zt__encoder encoder = *t->encoder;
    const uint8_t *src = t->src;
    size_t head = 0, frame;
    encoder.level = level;
    if (candidate != CODEC_1) {
        zt__pred_form form = zt__pred_form_at(candidate - 1, t->transform);
        zt__pred_to_samples(t->shape, &form, t->src, row_size(t->shape), t->values, t->samples);
        src = t->samples;
        head = ZT__PRED_FORM_SIZE;
    }
    ZT_TRY(zt__encode_frame(&encoder, src, t->size, t->frame, t->frame_room, &frame, t->diag));
    *size = frame > 0 && frame + head < t->size ? frame + head : SIZE_MAX;
    return ZT_OK;
}

/* What has just been coded is the best so far. */
static void keep(trial *t, uint32_t candidate, size_t size) {
    size_t head = 0;
    if (candidate != CODEC_1) {
        zt__pred_form form = zt__pred_form_at(candidate - 1, t->transform);
        zt__pred_put_form(&form, t->best);
        head = ZT__PRED_FORM_SIZE;
    }
    memcpy(t->best + head, t->frame, size - head);
    t->best_size = size;
    t->codec = candidate == CODEC_1 ? ZT__CODEC_ZSTD : ZT__CODEC_PRED;
}

/* Whether a high level may make the probed one the smallest. Tiles that hardly compress hold no repetition. */
static bool promises(const trial *t, size_t probe) {
    bool hardly = t->best_size >= t->size / 2 && t->plan->forms != ALL_FORMS;
    return probe != SIZE_MAX && probe < t->best_size + (hardly ? 0 : t->best_size / t->plan->near);
}

/* Sizes of all candidates at the low level. */
static zt_result probe_all(const trial *t, size_t sizes[CANDIDATES]) {
    for (uint32_t i = 0; i < CANDIDATES; i++)
        sizes[i] = SIZE_MAX;
    ZT_TRY(code_candidate(t, CODEC_1, t->plan->probe, &sizes[CODEC_1]));
    if (t->plan->forms == NO_FORMS || (t->plan->forms == FORMS_NEAR && !promises(t, sizes[CODEC_1])))
        return ZT_OK;
    for (uint32_t i = 1; i < CANDIDATES; i++)
        ZT_TRY(code_candidate(t, i, t->plan->probe, &sizes[i]));
    return ZT_OK;
}

static zt_result code_frames(trial *t) {
    size_t sizes[CANDIDATES], size;
    ZT_TRY(probe_all(t, sizes));
    for (uint32_t i = 0; i < t->plan->tries; i++) {
        uint32_t next = 0;
        for (uint32_t k = 1; k < CANDIDATES; k++)
            next = sizes[k] < sizes[next] ? k : next;
        if (!promises(t, sizes[next]))
            break;
        sizes[next] = SIZE_MAX;
        ZT_TRY(code_candidate(t, next, t->plan->level, &size));
        if (size == SIZE_MAX || size > t->best_size + t->best_size / 8)
            break;
        if (size < t->best_size)
            keep(t, next, size);
    }
    return ZT_OK;
}

/* Where codec 2 is not possible: codec 1, straight to its place. */
static zt_result code_plain(trial *t, int level) {
    size_t size;
    zt__encoder encoder = *t->encoder;
    encoder.level = level;
    t->best = t->frame;
    ZT_TRY(zt__encode_frame(&encoder, t->src, t->size, t->frame, t->frame_room, &size, t->diag));
    t->best_size = size > 0 ? size : t->size;
    t->codec = size > 0 ? ZT__CODEC_ZSTD : ZT__CODEC_RAW;
    return ZT_OK;
}

/* Blocks as they lie, or with their fields apart: up to an effort the one that is smaller at level 1, then both. */
static zt_result code_blocks(trial *t, const zt__fields *fields, uint32_t effort) {
    enum { LAST_GUESS = 4 };
    const uint8_t codecs[2] = {ZT__CODEC_ZSTD, ZT__CODEC_FIELDS};
    size_t probes[2] = {0, 0}, size;
    uint8_t *apart;
    zt__encoder encoder = *t->encoder;
    ZT_TRY(zt__encoder_memory(t->encoder, 2 * (uint64_t)t->size, t->diag, &apart));
    zt__fields_apart(fields, t->src, t->size / fields->block_bytes, apart);
    t->best = apart + t->size;
    for (int i = 0; effort <= LAST_GUESS && i < 2; i++) {
        encoder.level = 1;
        ZT_TRY(zt__encode_frame(&encoder, i ? apart : t->src, t->size, t->frame, t->frame_room, &size, t->diag));
        probes[i] = size > 0 ? size : t->size;
    }
    encoder.level = t->encoder->level;
    for (int i = 0; i < 2; i++) {
        if (probes[i] > probes[1 - i])
            continue;
        ZT_TRY(zt__encode_frame(&encoder, i ? apart : t->src, t->size, t->frame, t->frame_room, &size, t->diag));
        if (size == 0 || size >= t->best_size)
            continue;
        memcpy(t->best, t->frame, size);
        t->best_size = size;
        t->codec = codecs[i];
    }
    return ZT_OK;
}

zt_result zt__encode_tile(zt__encoder *encoder, uint32_t effort, const zt__tile_form *form, const void *src,
                          size_t size, void *dst, size_t dst_size, uint8_t *codec, size_t *stored_size, zt_diag *diag) {
    const zt__pred_shape *shape = form && form->shape.channels > 0 ? &form->shape : NULL;
    trial t = {.encoder = encoder, .plan = &plans[effort], .shape = shape, .src = src, .size = size, .frame = dst};
    t.frame_room = dst_size;
    t.best_size = size;
    t.diag = diag;
    *codec = ZT__CODEC_RAW;
    *stored_size = 0;
    if (dst_size < zt__encode_bound(size))
        return zt__fail(diag, ZT_INTERNAL, 0, ZT__NO_OFFSET, "no room to encode");
    if (!encoder->raw_only && form && form->fields) {
        ZT_TRY(code_blocks(&t, form->fields, effort));
    } else if (!encoder->raw_only && (!shape || size == 1)) {
        ZT_TRY(code_plain(&t, encoder->level));
    } else if (!encoder->raw_only) {
        ZT_TRY(take_memory(&t, effort));
        code_words(&t, effort);
        if (t.plan->probe > 0)
            ZT_TRY(code_frames(&t));
        else if (t.codec == ZT__CODEC_RAW)
            ZT_TRY(code_plain(&t, t.plan->level));
    }
    if (t.codec == ZT__CODEC_RAW)
        memcpy(dst, src, size);
    else if (t.best != dst)
        memcpy(dst, t.best, t.best_size);
    *codec = t.codec;
    *stored_size = t.best_size;
    return ZT_OK;
}
