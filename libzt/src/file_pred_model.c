/* SPDX-License-Identifier: Apache-2.0 */
/* Choice of tables: contexts with similar statistics are merged while that saves bytes. Integers only: the choice is
 * the same on every machine. */
#include "file_pred_model.h"

#include <string.h>

#include "base_bytes.h"

enum {
    SYMBOL_COST = 9 * ZT__PRED_LOG_ONE / 2, /* of an entry of a stored table, about */
    TABLE_COST = 20 * ZT__PRED_LOG_ONE,
    UNUSED = 255 /* context that does not occur, while tables are chosen */
};

/* log2 by repeated squaring: each square of a number in [1, 2) that leaves it gives a one bit. */
static uint32_t exact_log(uint32_t v) {
    uint32_t whole = zt__log2(v), result = whole;
    uint64_t m = ((uint64_t)v << 31) >> whole;
    for (uint32_t bit = ZT__PRED_LOG_ONE; bit > 1; bit >>= 1) {
        m = (m * m) >> 31;
        result = result << 1 | (uint32_t)(m >> 32);
        m >>= m >> 32;
    }
    return result;
}

void zt__pred_model_init(zt__pred_model *model) {
    model->logs[0] = 0;
    for (uint32_t i = 1; i < ZT__PRED_LOG_SIZE; i++)
        model->logs[i] = (uint16_t)exact_log(i);
}

/* v x log2(v) */
static inline uint64_t weighted_log(const zt__pred_model *model, uint32_t v) {
    if (v < ZT__PRED_LOG_SIZE)
        return v * (uint32_t)model->logs[v];
    uint32_t shift = zt__log2(v) - 11;
    return (uint64_t)v * (model->logs[v >> shift] + shift * ZT__PRED_LOG_ONE);
}

uint64_t zt__pred_cost(const zt__pred_model *model, zt__pred_counts *counts) {
    uint64_t sum = 0;
    counts->used = counts->total = 0;
    for (uint32_t i = 0; i < 256; i++)
        if (counts->of[i]) {
            counts->used = i + 1;
            counts->total += counts->of[i];
            sum += weighted_log(model, counts->of[i]);
        }
    uint64_t all = weighted_log(model, counts->total);
    return all > sum ? all - sum : 0;
}

static uint64_t table_cost(uint32_t symbols) {
    return (uint64_t)symbols * SYMBOL_COST + TABLE_COST;
}

/* What merging two contexts costs; negative: it saves. */
static int64_t merge_cost(const zt__pred_model *model, const zt__pred_counts *a, const zt__pred_counts *b) {
    uint64_t sum = 0;
    uint32_t n = zt__max32(a->used, b->used), symbols = 0;
    for (uint32_t i = 0; i < n; i++) {
        uint32_t both = a->of[i] + b->of[i];
        symbols += both != 0;
        sum += weighted_log(model, both);
    }
    uint64_t all = weighted_log(model, a->total + b->total);
    return (int64_t)((all > sum ? all - sum : 0) + table_cost(symbols)) - (int64_t)(a->cost + b->cost);
}

static uint32_t symbols_of(const zt__pred_counts *c) {
    uint32_t n = 0;
    for (uint32_t i = 0; i < c->used; i++)
        n += c->of[i] != 0;
    return n;
}

static void add(const zt__pred_model *model, zt__pred_counts *to, const zt__pred_counts *from) {
    for (uint32_t i = 0; i < 256; i++)
        to->of[i] += from->of[i];
    to->cost = zt__pred_cost(model, to);
    to->cost += table_cost(symbols_of(to));
}

/* Puts context b into a; the last one takes the place of b. */
static void merge(zt__pred_model *model, uint32_t a, uint32_t b, uint32_t n, uint32_t contexts) {
    add(model, &model->counts[a], &model->counts[b]);
    model->counts[b] = model->counts[n - 1];
    for (uint32_t i = 0; i < contexts; i++)
        model->map[i] = (uint8_t)(model->map[i] == b ? a : model->map[i] == n - 1 ? b : model->map[i]);
}

/* Merges neighbours, keeping the order, until at most `most` contexts are left and no merge saves anything. */
static uint32_t merge_neighbours(zt__pred_model *model, uint32_t n, uint32_t most, uint32_t contexts) {
    int64_t *next = model->pairs[0]; /* with the one behind */
    for (uint32_t i = 0; i + 1 < n; i++)
        next[i] = merge_cost(model, &model->counts[i], &model->counts[i + 1]);
    while (n > 1) {
        uint32_t best = 0;
        for (uint32_t i = 1; i + 1 < n; i++)
            if (next[i] < next[best])
                best = i;
        if (n <= most && next[best] >= 0)
            break;
        add(model, &model->counts[best], &model->counts[best + 1]);
        n--;
        memmove(&model->counts[best + 1], &model->counts[best + 2], (n - best - 1) * sizeof(zt__pred_counts));
        memmove(&next[best], &next[best + 1], (n - best - 1) * sizeof *next);
        for (uint32_t i = 0; i < contexts; i++)
            model->map[i] = (uint8_t)(model->map[i] - (model->map[i] != UNUSED && model->map[i] > best));
        if (best + 1 < n)
            next[best] = merge_cost(model, &model->counts[best], &model->counts[best + 1]);
        if (best > 0)
            next[best - 1] = merge_cost(model, &model->counts[best - 1], &model->counts[best]);
    }
    return n;
}

static void set_pair(zt__pred_model *model, uint32_t a, uint32_t b) {
    model->pairs[zt__max32(a, b)][zt__min32(a, b)] = merge_cost(model, &model->counts[a], &model->counts[b]);
}

/* The pair whose merging costs least: *a below *b. */
static void cheapest_pair(const zt__pred_model *model, uint32_t n, uint32_t *a, uint32_t *b) {
    *a = 0;
    *b = 1;
    for (uint32_t i = 1; i < n; i++) {
        for (uint32_t j = 0; j < i; j++) {
            bool cheaper = model->pairs[i][j] < model->pairs[*b][*a];
            *a = cheaper ? j : *a;
            *b = cheaper ? i : *b;
        }
    }
}

/* What the last table has to save. Decoders are faster with few tables: six fill the first cache of most processors, so
 * those behind must be worth it up to the default effort. */
static int64_t price(const zt__pred_model *model, uint32_t n, uint32_t effort) {
    enum { CHEAP = 4, FITTING = 6, SMALL_SHARE = 1000, SHARE = 350 };
    int64_t all = 0;
    if (effort > ZT__PRED_DEFAULT_EFFORT || n <= CHEAP)
        return 0;
    for (uint32_t i = 0; i < n; i++)
        all += (int64_t)model->counts[i].cost;
    return all / (n > FITTING ? SHARE : SMALL_SHARE);
}

/* Merges the best pair of all until the tables are few enough and each is worth its price. */
static uint32_t merge_pairs(zt__pred_model *model, uint32_t n, uint32_t contexts, uint32_t effort) {
    for (uint32_t i = 0; i < n; i++)
        for (uint32_t j = 0; j < i; j++)
            set_pair(model, i, j);
    while (n > 1) {
        uint32_t a, b;
        cheapest_pair(model, n, &a, &b);
        if (n <= ZT__PRED_TABLES && model->pairs[b][a] >= price(model, n, effort))
            break;
        merge(model, a, b, n, contexts);
        n--;
        for (uint32_t j = 0; j < n; j++) { /* what was the last table is b now */
            if (b < n && j != b && j != a)
                model->pairs[zt__max32(b, j)][zt__min32(b, j)] = model->pairs[n][j];
        }
        for (uint32_t j = 0; j < n; j++) {
            if (j != a)
                set_pair(model, a, j);
        }
    }
    return n;
}

/* Rounds counts to frequencies that sum to ZT__PRED_SLOTS; a symbol that occurs has at least 1. */
static void normalise(const zt__pred_model *model, const zt__pred_counts *counts, uint16_t frequencies[256]) {
    uint32_t sum = 0;
    for (uint32_t i = 0; i < 256; i++) {
        uint32_t f = (uint32_t)(((uint64_t)counts->of[i] * ZT__PRED_SLOTS + counts->total / 2) / counts->total);
        f = counts->of[i] != 0 && f == 0 ? 1 : f;
        frequencies[i] = (uint16_t)f;
        sum += f;
    }
    while (sum != ZT__PRED_SLOTS) { /* the change that costs least, or gains most */
        bool less = sum > ZT__PRED_SLOTS;
        int64_t least = INT64_MAX;
        uint32_t best = 0;
        for (uint32_t i = 0; i < counts->used; i++) {
            uint32_t f = frequencies[i];
            if (f <= (less ? 1u : 0u))
                continue;
            int64_t change = (int64_t)model->logs[f] - model->logs[less ? f - 1 : f + 1];
            if (change * (int64_t)counts->of[i] < least) {
                least = change * (int64_t)counts->of[i];
                best = i;
            }
        }
        frequencies[best] = (uint16_t)(less ? frequencies[best] - 1 : frequencies[best] + 1);
        sum = less ? sum - 1 : sum + 1;
    }
}

static void make_tables(zt__pred_model *model, uint32_t n) {
    model->table_count = n;
    for (uint32_t i = 0; i < n; i++)
        normalise(model, &model->counts[i], model->frequencies[i]);
}

/* Contexts that occur become 0 to n - 1. */
static uint32_t compact(zt__pred_model *model, uint32_t contexts) {
    uint32_t n = 0;
    for (uint32_t i = 0; i < contexts; i++) {
        zt__pred_counts *c = &model->counts[i];
        uint64_t cost = zt__pred_cost(model, c);
        model->map[i] = UNUSED;
        if (c->total == 0)
            continue;
        c->cost = cost + table_cost(symbols_of(c));
        model->map[i] = (uint8_t)n;
        if (n != i)
            model->counts[n] = *c;
        n++;
    }
    return n;
}

void zt__pred_choose(zt__pred_model *model, uint32_t contexts, uint32_t effort) {
    /* Up to so many contexts all pairs are compared; above, neighbours are merged first. */
    static const uint8_t few[ZT__PRED_MAX_EFFORT + 1] = {
        0, 0, 0, 12, 20, 32, 64, ZT__PRED_CONTEXTS, ZT__PRED_CONTEXTS, ZT__PRED_CONTEXTS};
    uint32_t n = compact(model, contexts);
    if (effort <= 2)
        n = merge_neighbours(model, n, ZT__PRED_TABLES, contexts);
    else if (n > few[effort])
        n = merge_neighbours(model, n, few[effort], contexts);
    if (effort > 2)
        n = merge_pairs(model, n, contexts, effort);
    make_tables(model, n);
    for (uint32_t i = 0; i < contexts; i++)
        if (model->map[i] == UNUSED)
            model->map[i] = 0;
}
