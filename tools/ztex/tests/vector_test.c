/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: a flat drawing becomes shapes that have exactly the areas of what it draws: with transforms, nested groups,
 * styles, both fill rules, clips, what is seen through, strokes with their joins, caps and dashes. What is not flat is
 * named and not taken, and a drawing that was made to do harm ends in an error or a reason. It matters because silmaps
 * are fitted to these shapes and to nothing else.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../vector_module.h"

#define EDGE 512
#define PAGE (100.0 * 100.0)
#define PI 3.14159265358979

extern const vector_module ztex_vector_module;

static int failures;

static void check(int good, const char *name, const char *what) {
    if (good)
        return;
    failures++;
    printf("FAILED: %s: %s\n", name, what);
}

/* The leak check asks for this: cairo 1.16 loses some bytes in its SVG writer over each group that is seen through. */
const char *__lsan_default_suppressions(void);

const char *__lsan_default_suppressions(void) {
    return "leak:libcairo\n";
}

typedef struct figure {
    const char *name, *text; /* inside of a page of 100 x 100 */
    double areas[3];         /* of red, green and blue */
    double tolerance;        /* of the page */
} figure;

static const figure figures[] = {
    {"a rectangle", "<rect x='10' y='20' width='30' height='40' fill='#f00'/>", {1200, 0, 0}, 1e-7},
    {"transforms in nested groups",
     "<g transform='translate(10,10)'><g transform='scale(2,3)'><rect width='10' height='5' fill='#f00'/></g>"
     "<g transform='rotate(90) translate(30,-40)'><rect width='8' height='4' fill='#00f'/></g></g>",
     {300, 0, 32},
     1e-7},
    {"a reflection and a shear",
     "<g transform='matrix(-1,0,0.5,1,60,20)'><path d='M0 0h20v20h-20z' fill='#0f0'/></g>",
     {0, 400, 0},
     1e-7},
    {"a style sheet",
     "<style>.a { fill: #f00 } g .b { fill: #0f0 } #c { fill: rgb(0%,0%,100%) }</style><rect class='a' width='10' "
     "height='10'/>"
     "<g><rect class='b' x='20' width='20' height='10'/></g><rect id='c' x='50' width='30' height='10'/>",
     {100, 200, 300},
     1e-7},
    {"even-odd", "<path fill='#f00' fill-rule='evenodd' d='M10 10h40v40h-40z M20 20h20v20h-20z'/>", {1200, 0, 0}, 1e-7},
    {"non-zero, wound the same way", "<path fill='#f00' d='M10 10h40v40h-40z M20 20h50v10h-50z'/>", {1800, 0, 0}, 1e-7},
    {"non-zero, wound against each other",
     "<path fill='#f00' d='M10 10h40v40h-40z M20 20v20h20v-20z'/>",
     {1200, 0, 0},
     1e-7},
    {"what is above covers what is below",
     "<rect x='10' y='10' width='40' height='40' fill='#f00'/><rect x='30' y='30' width='40' height='40' fill='#0f0'/>"
     "<path fill='#00f' d='M40 40L60 40L40 60z'/>",
     {1200, 1400, 200},
     1e-6},
    {"what is seen through",
     "<rect width='50' height='40' fill='#f00'/><rect x='25' width='50' height='40' fill='#0f0' fill-opacity='0.2'/>",
     {1000 + 0.8 * 1000, 0.2 * 2000, 0},
     2e-3}, /* cairo has opacities of 8 bits */
    {"clips within each other",
     "<clipPath id='a'><rect x='10' y='10' width='50' height='50'/></clipPath><clipPath id='b'><path d='M30 "
     "30h50v50h-50z'/>"
     "</clipPath><g clip-path='url(#a)'><g clip-path='url(#b)'><rect width='100' height='100' fill='#f00'/></g>"
     "<rect width='20' height='20' fill='#0f0'/></g>",
     {900, 100, 0},
     1e-7},
    {"beyond the page", "<rect x='-50' y='80' width='100' height='100' fill='#f00'/>", {1000, 0, 0}, 1e-7},
    {"a drawing in the drawing and a second use",
     "<svg x='10' y='10' width='20' height='20' viewBox='0 0 10 10'><rect id='r' width='20' height='5' "
     "fill='#f00'/></svg>"
     "<use href='#r' x='40' y='50'/>",
     {200 + 100, 0, 0},
     1e-7},
    {"a stroke with a mitre",
     "<path fill='none' stroke='#0f0' stroke-width='4' d='M10 20L50 20L50 60'/>",
     {0, 4 * 42 + 4 * 38, 0},
     1e-7},
    {"a mitre beyond its limit",
     "<path fill='none' stroke='#0f0' stroke-width='4' stroke-miterlimit='1.2' d='M10 20L50 20L50 60'/>",
     {0, 4 * 42 + 4 * 38 - 2, 0},
     1e-7},
    {"a bevel",
     "<path fill='none' stroke='#0f0' stroke-width='4' stroke-linejoin='bevel' d='M10 20L50 20L50 60'/>",
     {0, 4 * 42 + 4 * 38 - 2, 0},
     1e-7},
    {"round join and caps",
     "<path fill='none' stroke='#00f' stroke-width='4' stroke-linejoin='round' stroke-linecap='round' d='M10 20L50 "
     "20L50 60'/>",
     {0, 0, 4 * 42 + 4 * 38 - 4 + PI + 4 * PI},
     1e-6},
    {"square caps",
     "<path stroke='#00f' stroke-width='4' stroke-linecap='square' d='M10 20L50 20'/>",
     {0, 0, 176},
     1e-7},
    {"a closed stroke over its area",
     "<path fill='#f00' stroke='#00f' stroke-width='2' d='M20 20h40v40h-40z'/>",
     {38 * 38, 0, 42 * 42 - 38 * 38},
     1e-7},
    {"a stroke that crosses itself",
     "<path fill='none' stroke='#0f0' stroke-width='4' stroke-opacity='1' d='M10 50H90M50 10V90'/>",
     {0, 320 + 320 - 16, 0},
     1e-7},
    {"a stretched stroke",
     "<g transform='scale(1,3)'><path fill='none' stroke='#0f0' stroke-width='2' d='M10 10H50V20'/></g>",
     {0, 41 * 6 + 9 * 6, 0},
     1e-7},
    {"dashes",
     "<path stroke='#f00' stroke-width='2' stroke-dasharray='6 4' stroke-dashoffset='2' d='M10 50H60'/>",
     {2 * (4 + 6 * 4 + 2), 0, 0},
     1e-6},
    {"dashes around a corner",
     "<rect x='20' y='20' width='30' height='30' fill='none' stroke='#f00' stroke-width='2' stroke-dasharray='20 20' "
     "stroke-dashoffset='10'/>",
     {3 * (9 * 2 + 11 * 2), 0, 0},
     1e-6},
    {"a circle", "<circle cx='50' cy='50' r='30' fill='#f00'/>", {900 * PI, 0, 0}, 2e-4},
};

typedef struct drawn {
    vector_drawing *drawing;
    vector_shapes shapes;
    char error[VECTOR_ERROR];
} drawn;

/* What drawing_shapes says; -2: it is no drawing. */
static int read_figure(const char *text, drawn *out) {
    static const char head[] =
        "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' width='100' height='100'>";
    size_t size = strlen(text) + sizeof head + 16;
    char *all = malloc(size);
    *out = (drawn){0};
    if (!all)
        abort();
    snprintf(all, size, "%s%s</svg>", head, text);
    int status = -2;
    if (!ztex_vector_module.drawing_open(all, strlen(all), 0, &out->drawing, out->error))
        status = ztex_vector_module.drawing_shapes(out->drawing, 1e-6, &out->shapes, out->error);
    ztex_vector_module.drawing_close(out->drawing);
    free(all);
    return status;
}

static void release(drawn *d) {
    free(d->shapes.paths.points);
    free(d->shapes.paths.paths);
    free(d->shapes.shapes);
}

/* Areas by the picture of the shapes, in which every texel is a mean. */
static void measure(const drawn *d, double areas[3]) {
    author_run run = {0};
    author_picture picture;
    author_silmap_input input = {.paths = d->shapes.paths.paths,
                                 .path_count = d->shapes.paths.count,
                                 .shapes = d->shapes.shapes,
                                 .shape_count = d->shapes.count};
    if (author_picture_create(&run, EDGE, EDGE, 4, &picture) != AUTHOR_OK)
        abort();
    check(author_silmap_draw(&run, &input, 1, &picture) == AUTHOR_OK, "drawing", run.error);
    for (int c = 0; c < 3; c++) {
        areas[c] = 0;
        for (size_t i = 0; i < (size_t)EDGE * EDGE; i++)
            areas[c] += (double)picture.texels[4 * i + (size_t)c] * (double)picture.texels[4 * i + 3];
        areas[c] *= PAGE / (EDGE * EDGE);
    }
    author_picture_release(&picture);
}

static void test_areas(void) {
    for (size_t i = 0; i < sizeof figures / sizeof figures[0]; i++) {
        const figure *f = &figures[i];
        drawn d;
        double areas[3] = {0};
        int status = read_figure(f->text, &d);
        check(status == 0, f->name, d.error);
        if (status == 0)
            measure(&d, areas);
        for (int c = 0; status == 0 && c < 3; c++) {
            char text[128];
            snprintf(text, sizeof text, "colour %d has an area of %.6f, not %.6f", c, areas[c], f->areas[c]);
            check(fabs(areas[c] - f->areas[c]) <= f->tolerance * PAGE, f->name, text);
        }
        release(&d);
    }
}

static void test_not_flat(void) {
    static const char *const cases[][2] = {
        {"gradient", "<linearGradient id='g'><stop offset='0' stop-color='red'/><stop offset='1' stop-color='blue'/>"
                     "</linearGradient><rect width='50' height='50' fill='url(#g)'/>"},
        {"gradient", "<radialGradient id='g'><stop offset='0' stop-color='red'/><stop offset='1' stop-color='blue'/>"
                     "</radialGradient><path d='M0 0L50 20' stroke-width='9' stroke='url(#g)'/>"},
        {"pattern",
         "<pattern id='g' width='9' height='9' patternUnits='userSpaceOnUse'><rect width='5' height='5'/></pattern>"
         "<rect width='50' height='50' fill='url(#g)'/>"},
        {"seen through",
         "<g opacity='0.5'><rect width='50' height='50'/><rect x='20' width='50' height='50' fill='red'/></g>"},
        {"mask", "<mask id='m'><circle r='30' fill='#888'/></mask><rect width='50' height='50' mask='url(#m)'/>"},
        {"filter",
         "<filter id='f'><feGaussianBlur stdDeviation='4'/></filter><rect width='50' height='50' filter='url(#f)'/>"},
        {"nothing", "<g/>"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        drawn d;
        check(read_figure(cases[i][1], &d) == VECTOR_NOT_FLAT, cases[i][0], "it counts as flat");
        check(strstr(d.error, cases[i][0]) != NULL, cases[i][0], d.error);
        check(!d.shapes.shapes && !d.shapes.paths.paths, cases[i][0], "shapes are left");
        release(&d);
    }
}

static void test_hostile(void) {
    static const char *const cases[] = {
        "<rect width='1e30' height='1e30' fill='red'/>",
        "<path d='M0 0L1e300 1e300L0 1e300z'/>",
        "<path stroke='red' stroke-width='1e30' d='M0 0L50 50L0 50z'/>",
        "<path stroke='red' stroke-width='1e-30' d='M0 0L50 50L0 50z'/>",
        "<path stroke='red' stroke-dasharray='1e-7' d='M0 0L100 100'/>",
        "<path stroke='red' stroke-dasharray='0 0' d='M0 0L100 100'/>",
        "<path stroke='red' stroke-dasharray='0 1e-3' stroke-linecap='round' d='M0 0L100 100L0 100z'/>",
        "<path stroke='red' stroke-linecap='round' stroke-linejoin='round' d='M50 50L50 50zM20 20zM10 10H90H10z'/>",
        "<g transform='scale(0)'><rect width='9' height='9' stroke='red'/></g>",
        "<g transform='matrix(1e-9,0,0,1e9,0,0)'><rect width='9' height='9' stroke='red'/></g>",
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        drawn d;
        int status = read_figure(cases[i], &d);
        check(status == 0 || d.error[0], cases[i], "there is no reason");
        if (status == 0) {
            double areas[3];
            measure(&d, areas);
            check(areas[0] >= 0 && areas[0] <= PAGE * 1.000001, cases[i], "it is no area");
        }
        release(&d);
    }
}

/* Letters may be large on a small page, and drawing them must not spoil the next drawing's. */
static void test_letters(void) {
    static const char text[] =
        "<svg xmlns='http://www.w3.org/2000/svg' width='1' height='1'><text y='0.9' font-size='0.9'>A</text></svg>";
    for (int i = 0; i < 2; i++) {
        drawn d = {0};
        static uint8_t pixels[4 * 64 * 64];
        int status = ztex_vector_module.drawing_open(text, sizeof text - 1, 0, &d.drawing, d.error);
        if (!status)
            status = ztex_vector_module.drawing_shapes(d.drawing, 1e-4, &d.shapes, d.error);
        check(status == 0, "a large letter", d.error);
        if (!status)
            status = ztex_vector_module.drawing_render(d.drawing, 64, 64, pixels, d.error);
        check(status == 0, "a letter that is drawn after that", d.error);
        ztex_vector_module.drawing_close(d.drawing);
        release(&d);
    }
}

/* Groups within groups, far more than a recursion or a list of fixed size would hold. */
static void test_deep(void) {
    enum { DEEP = 300 };
    static char text[DEEP * 64 + 256];
    size_t at = 0;
    at += (size_t)snprintf(text, sizeof text, "<clipPath id='c'><rect width='90' height='90'/></clipPath>");
    for (int i = 0; i < DEEP; i++)
        at += (size_t)snprintf(text + at, sizeof text - at, "<g clip-path='url(#c)'>");
    at += (size_t)snprintf(text + at, sizeof text - at, "<rect width='50' height='50'/>");
    for (int i = 0; i < DEEP; i++)
        at += (size_t)snprintf(text + at, sizeof text - at, "</g>");
    drawn d;
    check(read_figure(text, &d) != 0 && d.error[0], "deep groups", "they are taken");
    release(&d);
}

int main(void) {
    test_areas();
    test_not_flat();
    test_hostile();
    test_letters();
    test_deep();
    printf(failures ? "%d failures\n" : "all areas are right\n", failures);
    return failures != 0;
}
