/* SPDX-License-Identifier: Apache-2.0 */
/* PNG: written by libpng at level 9, with adaptive filters and with none; read by libpng and by libspng. */
#include <setjmp.h>
#include <string.h>

#include <png.h>
#include <spng.h>

#include "codec.h"

static void write_bytes(png_structp png, png_bytep data, size_t size) {
    if (!codec_append(png_get_io_ptr(png), data, size))
        png_error(png, "no memory");
}

static void flush_bytes(png_structp png) {
    (void)png;
}

static int colour_type(const codec_picture *picture) {
    unsigned channels = codec_channels(picture);
    return channels == 1 ? PNG_COLOR_TYPE_GRAY : channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_RGB_ALPHA;
}

static int write_png(const codec_picture *picture, int level, int filters, codec_bytes *out) {
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    size_t pitch = (size_t)picture->width * codec_channels(picture);
    out->size = 0;
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_write_struct(&png, &info);
        return 0;
    }
    png_set_write_fn(png, out, write_bytes, flush_bytes);
    png_set_IHDR(png, info, picture->width, picture->height, 8, colour_type(picture), PNG_INTERLACE_NONE,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_compression_level(png, level);
    png_set_filter(png, PNG_FILTER_TYPE_BASE, filters);
    png_write_info(png, info);
    for (size_t y = 0; y < picture->height; y++)
        png_write_row(png, picture->rgb + y * pitch);
    png_write_end(png, NULL);
    png_destroy_write_struct(&png, &info);
    return 1;
}

int codec_png_encode(const codec_contender *self, const codec_picture *picture, codec_bytes *out) {
    static codec_bytes plain;
    if (!write_png(picture, self->level, PNG_ALL_FILTERS, out) ||
        !write_png(picture, self->level, PNG_FILTER_NONE, &plain))
        return 0;
    if (plain.size < out->size) {
        out->size = 0;
        return codec_append(out, plain.data, plain.size);
    }
    return 1;
}

static void read_bytes(png_structp png, png_bytep data, size_t size) {
    codec_bytes *left = png_get_io_ptr(png);
    if (size > left->size)
        png_error(png, "too short");
    memcpy(data, left->data, size);
    left->data += size;
    left->size -= size;
}

int codec_png_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in, void *texels) {
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL, NULL, NULL);
    png_infop info = png ? png_create_info_struct(png) : NULL;
    codec_bytes left = *in;
    unsigned char *row = texels;
    size_t pitch = (size_t)picture->width * picture->channels;
    (void)self;
    if (!info || setjmp(png_jmpbuf(png))) {
        png_destroy_read_struct(&png, &info, NULL);
        return 0;
    }
    png_set_read_fn(png, &left, read_bytes);
    png_read_info(png, info);
    if (picture->opaque)
        png_set_add_alpha(png, 0xFF, PNG_FILLER_AFTER);
    png_read_update_info(png, info);
    for (size_t y = 0; y < picture->height; y++)
        png_read_row(png, row + y * pitch, NULL);
    png_read_end(png, NULL);
    png_destroy_read_struct(&png, &info, NULL);
    return 1;
}

int codec_spng_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in, void *texels) {
    spng_ctx *png = spng_ctx_new(0);
    int format = picture->channels == 1 ? SPNG_FMT_G8 : picture->channels == 3 ? SPNG_FMT_RGB8 : SPNG_FMT_RGBA8;
    (void)self;
    int error = png ? spng_set_png_buffer(png, in->data, in->size) : SPNG_EMEM;
    if (!error)
        error = spng_decode_image(png, texels, picture->size, format, 0);
    spng_ctx_free(png);
    if (error)
        fprintf(stderr, "libspng: %s\n", spng_strerror(error));
    return !error;
}
