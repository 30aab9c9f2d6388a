/* SPDX-License-Identifier: Apache-2.0 */
/*
 * All points of a chain at once. Where a border between two regions passes, each cell has two lines that count, so
 * cells form chains; what a chain costs is a sum over its lines of functions of two neighbouring points, and dynamic
 * programming finds the best points of all its cells together, out of the better ones of each. One point at a time
 * cannot: a line that should move as a whole needs both its ends.
 */
#include "silmap_fit.h"

#include <stdlib.h>
#include <string.h>

#define PIECE 32 /* cells; between pieces one cell stays, and another in the next round */
#define STATES 64
#define KEPT 16 /* of them are tried together with those of the neighbours */
#define GAIN 1e-9
#define POINT 0x3fu
#define NO_ARM 4

typedef struct chain_node {
    size_t cell;
    uint8_t in, out;        /* arms towards the one before and the one behind */
    uint8_t states[STATES]; /* positions that it may have */
    uint8_t count, now;
    uint8_t from[STATES]; /* best state of the one before, for each of its own */
} chain_node;

typedef struct chain_piece {
    size_t first, count; /* nodes */
} chain_piece;

typedef struct chain_job {
    silmap_labels *labels;
    chain_node *nodes;
    size_t node_count;
    chain_piece *pieces;
    size_t piece_count;
    double *memory; /* two tables of each worker */
    uint8_t *taken; /* of each cell */
    const uint32_t *moved;
    uint32_t since;
} chain_job;

/* ---- tracing -------------------------------------------------------------------------------------------- */

/* Arms of a cell that have different regions on their sides. */
static unsigned used_arms(const silmap_labels *labels, size_t c) {
    uint32_t at[4];
    for (int k = 0; k < 4; k++)
        at[k] = labels->sample[silmap_corner(labels->grid, c, k)];
    return (at[ZT_SILMAP_00] != at[ZT_SILMAP_01] ? 1u << SILMAP_W : 0) |
           (at[ZT_SILMAP_00] != at[ZT_SILMAP_10] ? 1u << SILMAP_N : 0) |
           (at[ZT_SILMAP_10] != at[ZT_SILMAP_11] ? 1u << SILMAP_E : 0) |
           (at[ZT_SILMAP_01] != at[ZT_SILMAP_11] ? 1u << SILMAP_S : 0);
}

static int is_link(unsigned arms) {
    return arms == 3 || arms == 5 || arms == 6 || arms == 9 || arms == 10 || arms == 12;
}

static int other_arm(unsigned arms, int in) {
    arms &= ~(1u << in);
    int arm = 0;
    while (!(arms >> arm & 1))
        arm++;
    return arm;
}

static int lowest_arm(unsigned arms) {
    return other_arm(arms, 31);
}

/* Goes on from a node through the arm `out` as long as there are links that are not taken. */
static void walk(chain_job *job, size_t c, int in) {
    for (;;) {
        unsigned arms = used_arms(job->labels, c);
        if (!is_link(arms) || job->taken[c])
            return;
        job->taken[c] = 1;
        int out = other_arm(arms, in);
        job->nodes[job->node_count++] = (chain_node){.cell = c, .in = (uint8_t)in, .out = (uint8_t)out};
        c = silmap_next(job->labels->grid, c, out);
        if (c == SIZE_MAX)
            return;
        in = out ^ 2;
    }
}

static void reverse(chain_node *nodes, size_t count) {
    for (size_t i = 0; i < count; i++) {
        uint8_t in = nodes[i].in;
        nodes[i].in = nodes[i].out;
        nodes[i].out = in;
    }
    for (size_t i = 0; i < count / 2; i++) {
        chain_node swap = nodes[i];
        nodes[i] = nodes[count - 1 - i];
        nodes[count - 1 - i] = swap;
    }
}

static void rotate(chain_node *nodes, size_t count, size_t by) {
    for (; by; by--) {
        chain_node first = nodes[0];
        memmove(nodes, nodes + 1, (count - 1) * sizeof *nodes);
        nodes[count - 1] = first;
    }
}

static void cut_pieces(chain_job *job, size_t first, size_t count, int closed, int odd) {
    size_t at = first, end = first + count;
    if (closed)
        rotate(job->nodes + first, count, odd ? (count < PIECE ? count / 2 : PIECE / 2) : 0);
    size_t stop = closed ? first : first + (odd ? PIECE / 2 : PIECE);
    while (at < end) {
        size_t to = stop < end ? stop : end;
        if (to > at)
            job->pieces[job->piece_count++] = (chain_piece){at, to - at};
        at = to + 1;
        stop = to + PIECE;
    }
}

static void trace_chains(chain_job *job, int odd) {
    const silmap_labels *labels = job->labels;
    for (size_t i = 0; i < labels->active_count; i++) {
        size_t c = labels->active[i], first = job->node_count;
        unsigned arms = used_arms(labels, c);
        if (!is_link(arms) || job->taken[c])
            continue;
        int in = lowest_arm(arms);
        walk(job, c, in);
        size_t forward = job->node_count - first;
        const chain_node *last = &job->nodes[job->node_count - 1];
        int closed = forward > 2 && silmap_next(labels->grid, last->cell, last->out) == c && (last->out ^ 2) == in;
        if (!closed) {
            reverse(job->nodes + first, forward);
            size_t back = silmap_next(labels->grid, c, in);
            if (back != SIZE_MAX)
                walk(job, back, in ^ 2);
        }
        cut_pieces(job, first, job->node_count - first, closed, odd);
    }
}

/* ---- the best points ------------------------------------------------------------------------------------ */

/* The line from cell c through an arm. */
static void set_link(const chain_job *job, size_t c, int arm, double *memory, silmap_line *line) {
    size_t next = silmap_next(job->labels->grid, c, arm);
    int back = arm == SILMAP_W || arm == SILMAP_N;
    silmap_line_set(job->labels, back ? next : c, back ? c : next, arm == SILMAP_N || arm == SILMAP_S, memory, line);
}

static double link_cost(const chain_job *job, const silmap_line *line, int arm, unsigned own, unsigned next) {
    int back = arm == SILMAP_W || arm == SILMAP_N;
    return silmap_line_cost(line, job->labels->edge, back ? next : own, back ? own : next);
}

/* The point that an arm leads to from a cell whose point is `own`. */
static unsigned point_beyond(const silmap_grid *grid, size_t c, int arm, unsigned own) {
    size_t next = silmap_next(grid, c, arm);
    return next == SIZE_MAX ? silmap_mirrored(own, arm == SILMAP_N || arm == SILMAP_S) : grid->cells[next] & POINT;
}

/* Adds to costs what the line to the fixed cell at an end of a piece costs. */
static void add_end(const chain_job *job, const chain_node *node, int arm, double *memory, double costs[STATES]) {
    silmap_line line;
    set_link(job, node->cell, arm, memory, &line);
    for (int s = 0; s < node->count; s++) {
        unsigned own = node->states[s];
        costs[s] += link_cost(job, &line, arm, own, point_beyond(job->labels->grid, node->cell, arm, own));
    }
}

/* The positions of a cell that cost least beside its neighbours' points as they are, and the one that it has. */
static void list_states(const chain_job *job, chain_node *node, double *memory) {
    double costs[STATES] = {0};
    uint8_t own = job->labels->grid->cells[node->cell] & POINT;
    for (int s = 0; s < STATES; s++)
        node->states[s] = (uint8_t)s;
    node->count = STATES;
    add_end(job, node, node->in, memory, costs);
    add_end(job, node, node->out, memory, costs);
    costs[own] = -INFINITY;
    for (int n = 0; n < KEPT; n++) {
        int best = n;
        for (int s = n + 1; s < STATES; s++)
            best = costs[s] < costs[best] ? s : best;
        double cost = costs[best];
        uint8_t state = node->states[best];
        /* Those before it move up: where two are as good, the order stays. */
        memmove(&costs[n + 1], &costs[n], (size_t)(best - n) * sizeof *costs);
        memmove(&node->states[n + 1], &node->states[n], (size_t)(best - n));
        costs[n] = cost;
        node->states[n] = state;
    }
    node->count = KEPT;
    node->now = 0;
}

static void step(const chain_job *job, const chain_node *before, chain_node *node, double *memory,
                 double costs[STATES]) {
    silmap_line line;
    double next[STATES];
    set_link(job, before->cell, before->out, memory, &line);
    for (int s = 0; s < node->count; s++) {
        next[s] = 0;
        for (int t = 0; t < before->count; t++) {
            double cost = costs[t] + link_cost(job, &line, before->out, before->states[t], node->states[s]);
            /* Where two are as good, what is stays. */
            int better = t == 0 || cost < next[s] - GAIN || (t == before->now && cost < next[s] + GAIN);
            if (better) {
                next[s] = cost;
                node->from[s] = (uint8_t)t;
            }
        }
    }
    memcpy(costs, next, sizeof next);
}

static int has_moved(const chain_job *job, size_t c) {
    return c != SIZE_MAX && job->moved[c] >= job->since;
}

static int piece_has_moved(const chain_job *job, const chain_node *nodes, size_t count) {
    const silmap_grid *grid = job->labels->grid;
    int moved = has_moved(job, silmap_next(grid, nodes[0].cell, nodes[0].in)) ||
                has_moved(job, silmap_next(grid, nodes[count - 1].cell, nodes[count - 1].out));
    for (size_t i = 0; i < count && !moved; i++)
        moved = has_moved(job, nodes[i].cell);
    return moved;
}

static author_result visit_piece(void *context, size_t index, unsigned worker) {
    chain_job *job = context;
    const chain_piece *piece = &job->pieces[index];
    chain_node *nodes = job->nodes + piece->first;
    double *memory = job->memory + worker * 2 * silmap_table_size(job->labels->edge);
    double costs[STATES] = {0};
    if (!piece_has_moved(job, nodes, piece->count))
        return AUTHOR_OK;
    for (size_t i = 0; i < piece->count; i++) {
        list_states(job, &nodes[i], memory);
        if (i == 0)
            add_end(job, &nodes[0], nodes[0].in, memory, costs);
        else
            step(job, &nodes[i - 1], &nodes[i], memory, costs);
    }
    chain_node *last = &nodes[piece->count - 1];
    add_end(job, last, last->out, memory, costs);
    int best = last->now;
    for (int s = 0; s < last->count; s++)
        if (costs[s] < costs[best] - GAIN)
            best = s;
    for (size_t i = piece->count; i-- > 0;) {
        uint8_t *cell = &job->labels->grid->cells[nodes[i].cell];
        *cell = (uint8_t)((*cell & ~POINT) | nodes[i].states[best]);
        best = nodes[i].from[best];
    }
    return AUTHOR_OK;
}

author_result silmap_chains_fit(author_run *run, silmap_labels *labels, const uint32_t *moved, uint32_t since) {
    size_t cells = (size_t)labels->grid->w * labels->grid->h, active = labels->active_count;
    chain_job job = {.labels = labels, .moved = moved, .since = since};
    job.nodes = author_alloc(run, active, sizeof *job.nodes);
    job.pieces = author_alloc(run, active, sizeof *job.pieces);
    job.memory = author_alloc(run, 2 * silmap_table_size(labels->edge) * author_workers(run), sizeof *job.memory);
    job.taken = author_alloc(run, cells, 1);
    author_result result = job.nodes && job.pieces && job.memory && job.taken ? AUTHOR_OK : AUTHOR_NO_MEMORY;
    for (int round = 0; round < 2 && result == AUTHOR_OK; round++) {
        memset(job.taken, 1, cells);
        for (size_t i = 0; i < active; i++)
            job.taken[labels->active[i]] = 0;
        job.node_count = job.piece_count = 0;
        trace_chains(&job, round & 1);
        result = job.piece_count ? silmap_each(run, "silhouettes", NULL, job.piece_count, visit_piece, &job)
                                 : AUTHOR_OK;
    }
    free(job.nodes);
    free(job.pieces);
    free(job.memory);
    free(job.taken);
    return result;
}
