/* SPDX-License-Identifier: Apache-2.0 */
/* QOI, and WebP lossless. */
#include <stdlib.h>
#include <string.h>

#include <webp/decode.h>
#include <webp/encode.h>

#include "codec.h"

/* QOI allocates its results; here it is given the memory where they belong, so that nothing is copied. */
static codec_bytes qoi_target;

static void *qoi_memory(size_t size) {
    return size <= qoi_target.room ? qoi_target.data : NULL;
}

#define QOI_IMPLEMENTATION
#define QOI_NO_STDIO
#define QOI_MALLOC(size) qoi_memory((size_t)(size))
#define QOI_FREE(memory) ((void)(memory))
#include <qoi.h>

int codec_qoi_encode(const codec_contender *self, const codec_picture *picture, codec_bytes *out) {
    qoi_desc desc = {picture->width, picture->height, (unsigned char)picture->channels, QOI_SRGB};
    int size = 0;
    (void)self;
    if (!codec_reserve(out, picture->size + picture->size / picture->channels + 64))
        return 0;
    qoi_target = *out;
    if (!qoi_encode(picture->texels, &desc, &size))
        return 0;
    out->size = (size_t)size;
    return 1;
}

int codec_qoi_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in, void *texels) {
    qoi_desc desc;
    (void)self;
    qoi_target = (codec_bytes){.data = texels, .room = picture->size};
    return qoi_decode(in->data, (int)in->size, &desc, (int)picture->channels) != NULL;
}

static int write_webp(const uint8_t *data, size_t size, const WebPPicture *picture) {
    return codec_append(picture->custom_ptr, data, size);
}

/* WebP has no pictures of one channel: it is given three equal ones. */
static int import(const codec_picture *picture, WebPPicture *webp) {
    int pitch = (int)(picture->width * picture->channels);
    if (picture->channels == 4)
        return (picture->opaque ? WebPPictureImportRGBX : WebPPictureImportRGBA)(webp, picture->texels, pitch);
    if (picture->channels == 3)
        return WebPPictureImportRGB(webp, picture->texels, pitch);
    unsigned char *rgb = malloc(picture->size * 3);
    if (!rgb)
        return 0;
    for (size_t i = 0; i < picture->size; i++)
        memset(rgb + i * 3, picture->texels[i], 3);
    int done = WebPPictureImportRGB(webp, rgb, pitch * 3);
    free(rgb);
    return done;
}

int codec_webp_encode(const codec_contender *self, const codec_picture *picture, codec_bytes *out) {
    WebPConfig config;
    WebPPicture webp;
    out->size = 0;
    if (!WebPConfigInit(&config) || !WebPPictureInit(&webp) || !WebPConfigLosslessPreset(&config, self->level))
        return 0;
    config.exact = 1; /* keep the colour of transparent texels */
    webp.use_argb = 1;
    webp.width = (int)picture->width;
    webp.height = (int)picture->height;
    webp.writer = write_webp;
    webp.custom_ptr = out;
    int done = import(picture, &webp) && WebPEncode(&config, &webp);
    WebPPictureFree(&webp);
    return done;
}

int codec_webp_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in, void *texels) {
    static codec_bytes scratch;
    unsigned char *to = texels;
    int pitch = (int)(picture->width * picture->channels);
    (void)self;
    if (picture->channels == 4)
        return WebPDecodeRGBAInto(in->data, in->size, to, picture->size, pitch) != NULL;
    if (picture->channels == 3)
        return WebPDecodeRGBInto(in->data, in->size, to, picture->size, pitch) != NULL;
    if (!codec_reserve(&scratch, picture->size * 3) ||
        !WebPDecodeRGBInto(in->data, in->size, scratch.data, picture->size * 3, pitch * 3))
        return 0;
    for (size_t i = 0; i < picture->size; i++)
        to[i] = scratch.data[i * 3];
    return 1;
}
