/* SPDX-License-Identifier: Apache-2.0 */
/* Small pictures for the report, as texts that a page can hold. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "heap_report.h"
#include "load_linear.h"
#include "render.h"
#include "report_parts.h"

#define PHOTO_TEXELS (UINT64_C(220) * 165)
#define VIEW_EDGE 300    /* pixels */
#define MASK_TEXELS 300u /* the level of the mask is the first that is no wider or higher */
#define SURROUNDINGS 0.2 /* of the patch, on each side */

static char *encode_picture(const heap_report *report, const float *rgb, uint32_t width, uint32_t height) {
    return report_picture(report->heap->args, report->output, "jpeg", rgb, width, height);
}

char *heap_look_photo(const heap_report *report, uint32_t photo) {
    char error[IMG_ERROR];
    author_picture small;
    const char *path = report->heap->photos[photo].path;
    if (load_linear(path, PHOTO_TEXELS, &small, error) != AUTHOR_OK) {
        cmd_error("%s: %s", path, error);
        return NULL;
    }
    size_t count = (size_t)small.width * small.height;
    float *rgb = malloc(count * 3 * sizeof *rgb);
    for (size_t i = 0; rgb && i < 3 * count; i++)
        rgb[i] = zt_transfer_encode(ZT_TRANSFER_SRGB, small.texels[small.channels == 1 ? i / 3 : i]);
    char *text = rgb ? encode_picture(report, rgb, small.width, small.height) : NULL;
    free(rgb);
    author_picture_release(&small);
    return text;
}

/* The rectangle of the root around a patch. */
static int view_of(const zt_file *file, const heap_seam *seam, render_view *view) {
    double u[4], v[4];
    for (int i = 0; i < 4; i++)
        if (heap_patch_corner(file, seam->texture, seam->patch, i, &u[i], &v[i]))
            return -1;
    *view = (render_view){u[0], v[0], u[0], v[0]};
    for (int i = 1; i < 4; i++) {
        view->u0 = fmin(view->u0, u[i]);
        view->u1 = fmax(view->u1, u[i]);
        view->v0 = fmin(view->v0, v[i]);
        view->v1 = fmax(view->v1, v[i]);
    }
    double width = (view->u1 - view->u0) * SURROUNDINGS, height = (view->v1 - view->v0) * SURROUNDINGS;
    *view = (render_view){view->u0 - width, view->v0 - height, view->u1 + width, view->v1 + height};
    return 0;
}

static char *render_text(const heap_report *report, const zt_sampler *sampler, const render_view *view,
                         const zt_image_info *root) {
    render_style style = {.supersample = 1, .gain = 1.0f, .transfer = ZT_TRANSFER_SRGB};
    zt_diag diag = {.offset = UINT64_MAX};
    char *text = NULL;
    render_size_complete(view, root->width, root->height, VIEW_EDGE, &style.width, &style.height);
    double scale = VIEW_EDGE / (double)(style.width > style.height ? style.width : style.height);
    style.width = (uint32_t)fmax(1.0, style.width * scale);
    style.height = (uint32_t)fmax(1.0, style.height * scale);
    size_t count = (size_t)style.width * style.height;
    float *rgba = malloc(count * 4 * sizeof *rgba);
    if (!rgba)
        return NULL;
    zt_result result = render_rows(sampler, &style, view, 0, style.height, rgba, 4 * (size_t)style.width,
                                   cmd_parallel(report->heap->args), &diag);
    for (size_t i = 0; i < count; i++)
        memmove(rgba + 3 * i, rgba + 4 * i, 3 * sizeof *rgba);
    if (result == ZT_OK)
        text = encode_picture(report, rgba, style.width, style.height);
    else
        cmd_fail_result("report", result, &diag);
    free(rgba);
    return text;
}

char *heap_look_view(const heap_report *report, const zt_file *file, const heap_seam *seam) {
    zt_sampler_options how = {.size = sizeof how, .filter = ZT_FILTER_TRILINEAR};
    zt_diag diag = {.offset = UINT64_MAX};
    zt_sampler *sampler = NULL;
    zt_layer_info layer;
    zt_image_info root;
    render_view view;
    /* The place is that of the result, also for the file before it. */
    if (view_of(report->after, seam, &view) || zt_get_layer(file, seam->texture, 0, &layer) != ZT_OK ||
        zt_get_image(file, layer.image, &root) != ZT_OK) {
        cmd_error("report: patch %u cannot be shown", (unsigned)seam->patch);
        return NULL;
    }
    zt_result result = zt_sampler_open(file, seam->texture, &how, &diag, &sampler);
    if (result != ZT_OK) {
        cmd_fail_result("report", result, &diag);
        return NULL;
    }
    char *text = render_text(report, sampler, &view, &root);
    zt_sampler_close(sampler);
    return text;
}

char *heap_look_mask(const heap_report *report, const heap_seam *seam) {
    uint32_t image = zt_get_patch_image(report->after, seam->texture, seam->patch, 0), level = 0;
    zt_image_info info;
    heap_flat flat = {0};
    if (zt_get_image(report->after, image, &info) != ZT_OK)
        return NULL;
    while (level + 1 < info.levels && (info.width >> level > MASK_TEXELS || info.height >> level > MASK_TEXELS))
        level++;
    if (heap_flat_coverage(report->after, seam->texture, seam->patch, level, &flat) != CMD_OK)
        return NULL;
    for (size_t i = 0; i < (size_t)flat.width * flat.height; i++)
        for (size_t c = 0; c < 3; c++)
            flat.texels[3 * i + c] = flat.texels[4 * i + 3];
    char *text = encode_picture(report, flat.texels, flat.width, flat.height);
    free(flat.texels);
    return text;
}
