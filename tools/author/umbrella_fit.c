/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The colours of a coarser level. What a pixel shows is linear in the colours of all vertices (but for clamping), so
 * the best ones are a least-squares problem: conjugate gradients, begun at the raised-cosine means of the paper, errors
 * weighted by how steep the sRGB curve is.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "umbrella_level.h"

#define STEPS 32           /* of conjugate gradients */
#define PASSES 8           /* before each, colours that would leave 0 to 1 are fixed */
#define DAMPING 0.002      /* of the mean diagonal: colours that nobody sees stay at their mean */
#define LEAST_LEFT 0x1p-16 /* of transmittance: what a lookup calls opaque */
#define SLOPE_STEP 0.002f

/* How much of a colour a pixel shows. */
typedef struct share {
    uint32_t colour;
    float weight;
} share;

/* An umbrella at a pixel. Its shares follow each other. */
typedef struct hit {
    float weight; /* coverage times what is left by those above */
    uint32_t count;
} hit;

/* One row of pixels. */
typedef struct row {
    share *shares;
    hit *hits;
    uint32_t *ends; /* of the pixels, in hits */
    float *left;    /* of the pixels: what shows the background */
    size_t share_count, share_room, hit_count, hit_room;
} row;

typedef struct fitting {
    author_run *run;
    umb_candidate *candidate;
    const zt_umbrella_info *info;
    zt_umbrella_colour_mode mode;
    double pixel[4]; /* derivatives */
    const author_picture *truth, *background;
    row *rows;
    double *colours[3];
    float *slopes[3]; /* of the pixels */
} fitting;

/* ---- what a pixel shows ---------------------------------------------------------------------------------------- */

static int add_share(row *r, uint32_t colour, double weight) {
    if (r->share_count == r->share_room) {
        size_t room = r->share_room ? 2 * r->share_room : 1024;
        share *more = realloc(r->shares, room * sizeof *more);
        if (!more)
            return -1;
        r->shares = more;
        r->share_room = room;
    }
    r->shares[r->share_count++] = (share){colour, (float)weight};
    return 0;
}

static int add_hit(row *r, double weight, size_t first_share) {
    if (r->hit_count == r->hit_room) {
        size_t room = r->hit_room ? 2 * r->hit_room : 256;
        hit *more = realloc(r->hits, room * sizeof *more);
        if (!more)
            return -1;
        r->hits = more;
        r->hit_room = room;
    }
    r->hits[r->hit_count++] = (hit){(float)weight, (uint32_t)(r->share_count - first_share)};
    return 0;
}

/* Section 3, step 5: equation 1 of the paper. */
static int share_by_distance(row *r, const fitting *f, const zt_umbrella *u, author_xy q) {
    author_xy d[AUTHOR_VERTICES];
    double total = 0, far[AUTHOR_VERTICES + 1];
    umb_polygon(f->info, u, f->candidate->level.bits, d);
    for (uint32_t i = 0; i <= u->vertex_count; i++) {
        author_xy v = i ? umb_less(q, d[i - 1]) : q;
        far[i] = sqrt(v.x * v.x + v.y * v.y);
        if (far[i] == 0)
            return add_share(r, u->first_colour + i, 1);
        total += 1 / far[i];
    }
    for (uint32_t i = 0; i <= u->vertex_count; i++)
        if (add_share(r, u->first_colour + i, 1 / far[i] / total))
            return -1;
    return 0;
}

static int share_by_sector(row *r, const zt_umbrella *u, const zt_umbrella_sector *s) {
    return add_share(r, u->first_colour, 1 - s->g - s->k) || add_share(r, u->first_colour + 1 + s->i, s->g) ||
           add_share(r, u->first_colour + 1 + s->j, s->k);
}

/* 0, or -1: no memory. */
static int look_at(const fitting *f, uint32_t entry, author_xy place, double *left, row *r) {
    const umb_candidate *c = f->candidate;
    const zt_umbrella *u = &c->umbrellas[entry & ZT_UMBRELLA_ENTRY];
    zt_umbrella_sector s;
    uint32_t shift = entry >> ZT_UMBRELLA_SHIFT;
    author_xy q = {place.x - u->x / 65536.0 - ((double)(shift % 3) - 1) * c->level.width,
                   place.y - u->y / 65536.0 - ((double)(shift / 3) - 1) * c->level.height};
    zt_umbrella_sector_at(f->info, &c->level, u, q.x, q.y, f->pixel, &s);
    double weight = *left * s.coverage;
    size_t before = r->share_count;
    if (weight == 0)
        return 0;
    *left *= 1 - s.coverage;
    if (f->mode == ZT_UMBRELLA_BARYCENTRIC ? share_by_sector(r, u, &s) : share_by_distance(r, f, u, q))
        return -1;
    return add_hit(r, weight, before);
}

static author_result look_at_row(void *context, size_t index, unsigned worker, char *error) {
    fitting *f = context;
    const umb_candidate *c = f->candidate;
    row *r = &f->rows[index];
    uint32_t width = f->truth->width, height = f->truth->height / 2, y = (uint32_t)index % height;
    double shift = index < height ? 0 : 0.5;
    (void)worker;
    r->ends = calloc(width, sizeof *r->ends);
    r->left = calloc(width, sizeof *r->left);
    int good = r->ends && r->left;
    for (uint32_t x = 0; good && x < width; x++) {
        author_xy place = {(x + shift) / UMB_PHASES, (y + shift) / UMB_PHASES};
        size_t cell = (size_t)(y / UMB_PHASES) * c->level.width + x / UMB_PHASES;
        double left = 1;
        for (uint32_t e = c->starts[cell + 1]; good && e > c->starts[cell] && left >= LEAST_LEFT; e--)
            good = look_at(f, c->entries[e - 1], place, &left, r) == 0;
        r->ends[x] = (uint32_t)r->hit_count;
        r->left[x] = left < LEAST_LEFT ? 0.0f : (float)left;
    }
    if (good)
        return AUTHOR_OK;
    memcpy(error, "no memory for the colours of a level", sizeof "no memory for the colours of a level");
    return AUTHOR_NO_MEMORY;
}

/* ---- first colours ---------------------------------------------------------------------------------------------- */

/* Raised cosine around a place, over the pixels; radius in cells. */
static void local_mean(const fitting *f, author_xy place, double radius, double mean[3]) {
    const author_picture *t = f->truth;
    double r = fmax(radius * UMB_PHASES, 1.5), x = place.x * UMB_PHASES, y = place.y * UMB_PHASES, total = 0;
    double sum[3] = {0, 0, 0};
    int64_t height = t->height / 2;
    for (int64_t j = (int64_t)ceil(y - r); j <= (int64_t)floor(y + r); j++)
        for (int64_t i = (int64_t)ceil(x - r); i <= (int64_t)floor(x + r); i++) {
            double dx = (double)i - x, dy = (double)j - y, c, s;
            double far = sqrt(dx * dx + dy * dy) / r;
            if (far >= 1)
                continue;
            umb_turn(far / 2, &c, &s);
            int64_t px = (i % t->width + t->width) % t->width, py = (j % height + height) % height;
            const float *texel = t->texels + (size_t)(py * t->width + px) * 4;
            total += 1 + c;
            for (int k = 0; k < 3; k++)
                sum[k] += (1 + c) * (double)texel[k];
        }
    for (int k = 0; k < 3; k++)
        mean[k] = total > 0 ? sum[k] / total : 0;
}

static author_result first_colours(void *context, size_t index, unsigned worker, char *error) {
    fitting *f = context;
    const zt_umbrella *u = &f->candidate->umbrellas[index];
    author_xy d[64], centre = {u->x / 65536.0, u->y / 65536.0};
    size_t count = umb_polygon(f->info, u, f->candidate->level.bits, d);
    double mean[3], radii = 0;
    (void)worker;
    (void)error;
    for (size_t i = count + 1; i-- > 0;) {
        author_xy v = i ? d[i - 1] : (author_xy){0, 0};
        double length = sqrt(v.x * v.x + v.y * v.y);
        radii += length;
        local_mean(f, (author_xy){centre.x + v.x, centre.y + v.y}, (i ? length : radii / (double)count) / 2, mean);
        for (int k = 0; k < 3; k++)
            f->colours[k][u->first_colour + i] = mean[k];
    }
    return AUTHOR_OK;
}

/* ---- least squares ---------------------------------------------------------------------------------------------- */

/* One channel. x is what is sought, in steps from the first colours. */
typedef struct solving {
    const fitting *f;
    int channel;
    size_t count;
    double damping;
    uint8_t *fixed;
    double *start, *residual, *direction, *product, *diagonal;
    double *line; /* scratch: a row of pixels */
} solving;

/* What a hit shows of values, those of the colours; *at goes past its shares. */
static double hit_sum(const row *r, size_t h, size_t *at, const double *values) {
    double sum = 0;
    for (uint32_t k = 0; k < r->hits[h].count; k++, (*at)++)
        sum += (double)r->shares[*at].weight * values[r->shares[*at].colour];
    return (double)r->hits[h].weight * sum;
}

/* The other way: value goes to the colours by their shares. */
static void hit_spread(const row *r, size_t h, size_t *at, double value, double *out) {
    for (uint32_t k = 0; k < r->hits[h].count; k++, (*at)++)
        out[r->shares[*at].colour] += (double)r->hits[h].weight * (double)r->shares[*at].weight * value;
}

/* out += A' W W (A in) of one row; with missing it stands for A in. */
static void through_row(const solving *s, size_t y, const double *in, const double *missing, double *out) {
    const fitting *f = s->f;
    const row *r = &f->rows[y];
    size_t gather_at = 0, spread_at = 0, hit_at = 0, width = f->truth->width;
    for (size_t x = 0; x < width; x++) {
        double sum = missing ? missing[y * width + x] : 0, slope = (double)f->slopes[s->channel][y * width + x];
        for (size_t h = hit_at; !missing && h < r->ends[x]; h++)
            sum += hit_sum(r, h, &gather_at, in);
        for (; hit_at < r->ends[x]; hit_at++)
            hit_spread(r, hit_at, &spread_at, sum * slope * slope, out);
    }
}

static void multiply(const solving *s, const double *in, const double *missing, double *out) {
    memset(out, 0, s->count * sizeof *out);
    for (size_t y = 0; y < s->f->truth->height; y++)
        through_row(s, y, in, missing, out);
    for (size_t i = 0; i < s->count; i++) {
        if (!missing)
            out[i] += s->damping * in[i];
        if (s->fixed[i])
            out[i] = 0;
    }
}

static double dot(const double *a, const double *b, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += a[i] * b[i];
    return sum;
}

/* What the colours leave to be wished, at each pixel. */
static void find_missing(const fitting *f, int channel, double *missing) {
    size_t width = f->truth->width;
    for (size_t y = 0; y < f->truth->height; y++) {
        const row *r = &f->rows[y];
        size_t at = 0, h = 0;
        for (size_t x = 0; x < width; x++) {
            size_t p = y * width + x;
            double sum = (double)r->left[x] * (double)f->background->texels[4 * p + (size_t)channel];
            while (h < r->ends[x])
                sum += hit_sum(r, h++, &at, f->colours[channel]);
            missing[p] = (double)f->truth->texels[4 * p + (size_t)channel] - sum;
        }
    }
}

static void add_squares(const solving *s, const row *r, const float *slopes) {
    size_t at = 0, x = 0;
    for (size_t h = 0; h < r->hit_count; h++) {
        while (h >= r->ends[x])
            x++;
        for (uint32_t k = 0; k < r->hits[h].count; k++, at++) {
            double part = (double)r->hits[h].weight * (double)r->shares[at].weight * (double)slopes[x];
            s->diagonal[r->shares[at].colour] += part * part;
        }
    }
}

static void find_diagonal(solving *s) {
    size_t used = 0;
    double sum = 0;
    memset(s->diagonal, 0, s->count * sizeof *s->diagonal);
    for (size_t y = 0; y < s->f->truth->height; y++)
        add_squares(s, &s->f->rows[y], s->f->slopes[s->channel] + y * s->f->truth->width);
    for (size_t i = 0; i < s->count; i++) {
        sum += s->diagonal[i];
        used += s->diagonal[i] > 0;
    }
    s->damping = used ? DAMPING * sum / (double)used : 1;
    for (size_t i = 0; i < s->count; i++)
        s->diagonal[i] = 1 / (s->diagonal[i] + s->damping);
}

/* Preconditioned by the diagonal. colours change by what is found. */
static void descend(const solving *s, const double *missing, double *colours) {
    double *r = s->residual, *p = s->direction, *q = s->product, *z = s->line;
    multiply(s, NULL, missing, r);
    for (size_t i = 0; i < s->count; i++)
        p[i] = z[i] = s->diagonal[i] * r[i];
    double before = dot(r, z, s->count), first = before;
    for (int step = 0; step < STEPS && before > first * 1e-12; step++) {
        multiply(s, p, NULL, q);
        double along = dot(p, q, s->count), length = along > 0 ? before / along : 0;
        for (size_t i = 0; i < s->count; i++) {
            colours[i] += length * p[i];
            r[i] -= length * q[i];
            z[i] = s->diagonal[i] * r[i];
        }
        double after = dot(r, z, s->count);
        for (size_t i = 0; i < s->count; i++)
            p[i] = z[i] + after / before * p[i];
        before = after;
    }
}

/* Colours at an end of 0 to 1 that would go beyond it stay there for a pass; the others are free. */
static void fix_ends(const solving *s, const double *missing) {
    const double *colours = s->f->colours[s->channel];
    memset(s->fixed, 0, s->count);
    multiply(s, NULL, missing, s->residual);
    for (size_t i = 0; i < s->count; i++)
        s->fixed[i] = (colours[i] <= 0 && s->residual[i] < 0) || (colours[i] >= 1 && s->residual[i] > 0);
}

static void solve(solving *s, double *missing) {
    double *colours = s->f->colours[s->channel];
    find_diagonal(s);
    for (int pass = 0; pass < PASSES; pass++) {
        size_t left = 0;
        find_missing(s->f, s->channel, missing);
        fix_ends(s, missing);
        descend(s, missing, colours);
        for (size_t i = 0; i < s->count; i++) {
            left += colours[i] < 0 || colours[i] > 1;
            colours[i] = fmin(fmax(colours[i], 0), 1);
        }
        if (left == 0)
            break;
    }
}

static author_result solve_channel(void *context, size_t index, unsigned worker, char *error) {
    fitting *f = context;
    solving s = {.f = f, .channel = (int)index, .count = f->candidate->colour_count};
    size_t pixels = (size_t)f->truth->width * f->truth->height;
    double *room = malloc((5 * s.count + pixels) * sizeof *room);
    (void)worker;
    s.fixed = calloc(s.count + 1, 1);
    int good = room && s.fixed;
    if (good) {
        s.residual = room;
        s.direction = room + s.count;
        s.product = room + 2 * s.count;
        s.diagonal = room + 3 * s.count;
        s.line = room + 4 * s.count;
        solve(&s, room + 5 * s.count);
    } else {
        memcpy(error, "no memory for the colours of a level", sizeof "no memory for the colours of a level");
    }
    free(room);
    free(s.fixed);
    return good ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

/* ---- how good it is ---------------------------------------------------------------------------------------------- */

/* As a lookup will find it: out of the file's codes, each umbrella clamped. */
static void measure_row(const fitting *f, size_t y, size_t c, author_phase_errors *errors) {
    const row *r = &f->rows[y];
    size_t at = 0, h = 0;
    for (size_t x = 0; x < f->truth->width; x++) {
        size_t p = 4 * (y * f->truth->width + x) + c;
        double sum = (double)r->left[x] * (double)f->background->texels[p];
        for (; c < 3 && h < r->ends[x]; h++) {
            double weight = (double)r->hits[h].weight;
            sum += fmin(fmax(hit_sum(r, h, &at, f->colours[c]), 0), weight);
        }
        if (c == 3)
            sum += 1 - (double)r->left[x];
        umb_add_error(errors, f->truth, p, sum);
    }
}

static void measure(const fitting *f, author_phase_errors *errors) {
    *errors = (author_phase_errors){0};
    for (size_t y = 0; y < f->truth->height; y++)
        for (size_t c = 0; c < 4; c++)
            measure_row(f, y, c, errors);
}

static void code_colours(const fitting *f) {
    umb_candidate *c = f->candidate;
    for (uint32_t i = 0; i < c->colour_count; i++) {
        uint8_t code[3];
        for (int k = 0; k < 3; k++) {
            code[k] = umb_colour_code(f->colours[k][i]);
            f->colours[k][i] = code[k] / 255.0 * (code[k] / 255.0);
        }
        c->colours[i] = (zt_umbrella_colour){code[0], code[1], code[2], 0};
    }
}

static void find_slopes(const fitting *f) {
    size_t pixels = (size_t)f->truth->width * f->truth->height;
    for (size_t p = 0; p < pixels; p++)
        for (size_t c = 0; c < 3; c++) {
            float value = f->truth->texels[4 * p + c];
            f->slopes[c][p] = (zt_transfer_encode(ZT_TRANSFER_SRGB, value + SLOPE_STEP) -
                               zt_transfer_encode(ZT_TRANSFER_SRGB, value)) /
                              SLOPE_STEP;
        }
}

static author_result allocate(fitting *f) {
    size_t pixels = (size_t)f->truth->width * f->truth->height, colours = f->candidate->colour_count;
    f->rows = author_alloc(f->run, f->truth->height, sizeof *f->rows);
    f->candidate->colours = author_alloc(f->run, colours, sizeof *f->candidate->colours);
    int good = f->rows && f->candidate->colours;
    for (int c = 0; c < 3; c++) {
        f->colours[c] = author_alloc(f->run, colours, sizeof *f->colours[c]);
        f->slopes[c] = author_alloc(f->run, pixels, sizeof *f->slopes[c]);
        good = good && f->colours[c] && f->slopes[c];
    }
    return good ? AUTHOR_OK : AUTHOR_NO_MEMORY;
}

static void release(fitting *f) {
    for (size_t y = 0; f->rows && y < f->truth->height; y++) {
        free(f->rows[y].shares);
        free(f->rows[y].hits);
        free(f->rows[y].ends);
        free(f->rows[y].left);
    }
    free(f->rows);
    for (int c = 0; c < 3; c++) {
        free(f->colours[c]);
        free(f->slopes[c]);
    }
}

author_result umb_fit_level(author_run *run, umb_candidate *candidate, zt_umbrella_colour_mode mode, author_xy pixel,
                            const author_picture *truth, const author_picture *background) {
    zt_umbrella_info info = umb_candidate_view(candidate);
    fitting f = {.run = run,
                 .candidate = candidate,
                 .info = &info,
                 .mode = mode,
                 .pixel = {pixel.x, 0, 0, pixel.y},
                 .truth = truth,
                 .background = background};
    author_result result = allocate(&f);
    if (result == AUTHOR_OK)
        result = author_for(run, "levels", truth->height, look_at_row, &f);
    if (result == AUTHOR_OK)
        result = author_for(run, "levels", candidate->level.umbrella_count, first_colours, &f);
    if (result == AUTHOR_OK) {
        find_slopes(&f);
        result = author_for(run, "levels", 3, solve_channel, &f);
    }
    if (result == AUTHOR_OK) {
        code_colours(&f);
        measure(&f, &candidate->errors);
    }
    release(&f);
    return result;
}
