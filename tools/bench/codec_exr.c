/* SPDX-License-Identifier: Apache-2.0 */
/* OpenEXR, half pictures in scan line files, through the C library and its default compression level. */
#include <string.h>

#include <OpenEXR/openexr.h>

#include "codec.h"

static int64_t write_at(exr_const_context_t context, void *user, const void *data, uint64_t size, uint64_t offset,
                        exr_stream_error_func_ptr_t failed) {
    codec_bytes *out = user;
    (void)context;
    (void)failed;
    if (!codec_reserve(out, offset + size))
        return -1;
    memcpy(out->data + offset, data, size);
    if (out->size < offset + size)
        out->size = offset + size;
    return (int64_t)size;
}

static int64_t read_at(exr_const_context_t context, void *user, void *data, uint64_t size, uint64_t offset,
                       exr_stream_error_func_ptr_t failed) {
    const codec_bytes *in = user;
    (void)context;
    (void)failed;
    if (offset > in->size)
        return -1;
    if (size > in->size - offset)
        size = in->size - offset;
    memcpy(data, in->data + offset, size);
    return (int64_t)size;
}

static int64_t size_of(exr_const_context_t context, void *user) {
    (void)context;
    return (int64_t)((const codec_bytes *)user)->size;
}

/* Files keep their channels sorted by name. */
static int channel_place(const char *name) {
    return name[0] == 'R' ? 0 : name[0] == 'G' ? 1 : name[0] == 'B' ? 2 : 3;
}

static int write_header(exr_context_t file, const codec_picture *picture, int compression) {
    static const char *const names[] = {"A", "B", "G", "R"};
    int part = 0;
    exr_result_t error = exr_add_part(file, "", EXR_STORAGE_SCANLINE, &part);
    if (!error)
        error = exr_initialize_required_attr_simple(file, part, (int)picture->width, (int)picture->height,
                                                    (exr_compression_t)compression);
    for (int i = picture->opaque ? 1 : 0; i < 4 && !error; i++)
        error = exr_add_channel(file, part, names[i], EXR_PIXEL_HALF, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1);
    return !error && exr_write_header(file) == EXR_ERR_SUCCESS;
}

static int write_chunks(exr_context_t file, const codec_picture *picture) {
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    int step = 0;
    size_t pitch = (size_t)picture->width * 8;
    exr_result_t error = exr_get_scanlines_per_chunk(file, 0, &step);
    for (int y = 0; y < (int)picture->height && !error; y += step) {
        error = exr_write_scanline_chunk_info(file, 0, y, &chunk);
        if (!error)
            error = y == 0 ? exr_encoding_initialize(file, 0, &chunk, &pipe)
                           : exr_encoding_update(file, 0, &chunk, &pipe);
        for (int c = 0; c < pipe.channel_count && !error; c++) {
            exr_coding_channel_info_t *channel = &pipe.channels[c];
            channel->encode_from_ptr = picture->texels + (size_t)y * pitch +
                                       (size_t)channel_place(channel->channel_name) * 2;
            channel->user_pixel_stride = 8;
            channel->user_line_stride = (int32_t)pitch;
        }
        if (!error && y == 0)
            error = exr_encoding_choose_default_routines(file, 0, &pipe);
        if (!error)
            error = exr_encoding_run(file, 0, &pipe);
    }
    exr_encoding_destroy(file, &pipe);
    return !error;
}

int codec_exr_encode(const codec_contender *self, const codec_picture *picture, codec_bytes *out) {
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t file;
    init.user_data = out;
    init.write_fn = write_at;
    out->size = 0;
    if (exr_start_write(&file, "memory", EXR_WRITE_FILE_DIRECTLY, &init) != EXR_ERR_SUCCESS)
        return 0;
    int done = write_header(file, picture, self->level) && write_chunks(file, picture);
    return exr_finish(&file) == EXR_ERR_SUCCESS && done;
}

/* Half to half, interleaved: to float, version 3.1.5 gives the channels in the wrong order. */
static int read_chunks(exr_context_t file, const codec_picture *picture, unsigned char *texels) {
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    int step = 0;
    size_t pitch = (size_t)picture->width * 8;
    exr_result_t error = exr_get_scanlines_per_chunk(file, 0, &step);
    for (int y = 0; y < (int)picture->height && !error; y += step) {
        error = exr_read_scanline_chunk_info(file, 0, y, &chunk);
        if (!error)
            error = y == 0 ? exr_decoding_initialize(file, 0, &chunk, &pipe)
                           : exr_decoding_update(file, 0, &chunk, &pipe);
        for (int c = 0; c < pipe.channel_count && !error; c++) {
            exr_coding_channel_info_t *channel = &pipe.channels[c];
            channel->decode_to_ptr = texels + (size_t)y * pitch + (size_t)channel_place(channel->channel_name) * 2;
            channel->user_pixel_stride = 8;
            channel->user_line_stride = (int32_t)pitch;
            channel->user_bytes_per_element = 2;
            channel->user_data_type = EXR_PIXEL_HALF;
        }
        if (!error && y == 0)
            error = exr_decoding_choose_default_routines(file, 0, &pipe);
        if (!error)
            error = exr_decoding_run(file, 0, &pipe);
    }
    exr_decoding_destroy(file, &pipe);
    return !error;
}

int codec_exr_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in, void *texels) {
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    exr_context_t file;
    codec_bytes copy = *in;
    unsigned char *to = texels;
    (void)self;
    init.user_data = &copy;
    init.read_fn = read_at;
    init.size_fn = size_of;
    if (exr_start_read(&file, "memory", &init) != EXR_ERR_SUCCESS)
        return 0;
    int done = read_chunks(file, picture, to);
    exr_finish(&file);
    for (size_t i = 6; picture->opaque && i < picture->size; i += 8) {
        to[i] = 0;
        to[i + 1] = 0x3C;
    }
    return done;
}
