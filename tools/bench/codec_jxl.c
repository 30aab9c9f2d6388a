/* SPDX-License-Identifier: Apache-2.0 */
/* JPEG XL, lossless, in the calling thread. */
#include <jxl/decode.h>
#include <jxl/encode.h>

#include "codec.h"

static JxlPixelFormat pixel_format(const codec_picture *picture, unsigned channels) {
    JxlDataType type = picture->channel_bytes == 2 ? JXL_TYPE_FLOAT16 : JXL_TYPE_UINT8;
    return (JxlPixelFormat){channels, type, JXL_LITTLE_ENDIAN, 0};
}

static int set_up(JxlEncoder *encoder, const codec_picture *picture, int effort, JxlEncoderFrameSettings **settings) {
    JxlBasicInfo info;
    JxlColorEncoding colour;
    unsigned channels = codec_channels(picture);
    JxlEncoderInitBasicInfo(&info);
    info.xsize = picture->width;
    info.ysize = picture->height;
    info.bits_per_sample = picture->channel_bytes * 8;
    info.exponent_bits_per_sample = picture->channel_bytes == 2 ? 5 : 0;
    info.num_color_channels = channels == 1 ? 1 : 3;
    info.uses_original_profile = JXL_TRUE;
    if (channels == 4) {
        info.num_extra_channels = 1;
        info.alpha_bits = info.bits_per_sample;
        info.alpha_exponent_bits = info.exponent_bits_per_sample;
    }
    if (picture->channel_bytes == 2)
        JxlColorEncodingSetToLinearSRGB(&colour, JXL_FALSE);
    else
        JxlColorEncodingSetToSRGB(&colour, channels == 1);
    if (JxlEncoderSetBasicInfo(encoder, &info) != JXL_ENC_SUCCESS ||
        JxlEncoderSetColorEncoding(encoder, &colour) != JXL_ENC_SUCCESS)
        return 0;
    *settings = JxlEncoderFrameSettingsCreate(encoder, NULL);
    return *settings && JxlEncoderSetFrameLossless(*settings, JXL_TRUE) == JXL_ENC_SUCCESS &&
           JxlEncoderFrameSettingsSetOption(*settings, JXL_ENC_FRAME_SETTING_EFFORT, effort) == JXL_ENC_SUCCESS;
}

static int encode(JxlEncoder *encoder, const codec_picture *picture, int effort, codec_bytes *out) {
    JxlEncoderFrameSettings *settings = NULL;
    JxlPixelFormat format = pixel_format(picture, codec_channels(picture));
    size_t size = picture->size / picture->channels * codec_channels(picture);
    if (!set_up(encoder, picture, effort, &settings) ||
        JxlEncoderAddImageFrame(settings, &format, picture->rgb, size) != JXL_ENC_SUCCESS)
        return 0;
    JxlEncoderCloseInput(encoder);
    JxlEncoderStatus status = JXL_ENC_NEED_MORE_OUTPUT;
    while (status == JXL_ENC_NEED_MORE_OUTPUT) {
        if (!codec_reserve(out, out->size + picture->size / 2 + 4096))
            return 0;
        uint8_t *next = out->data + out->size;
        size_t room = out->room - out->size;
        status = JxlEncoderProcessOutput(encoder, &next, &room);
        out->size = (size_t)(next - out->data);
    }
    return status == JXL_ENC_SUCCESS;
}

int codec_jxl_encode(const codec_contender *self, const codec_picture *picture, codec_bytes *out) {
    JxlEncoder *encoder = JxlEncoderCreate(NULL);
    out->size = 0;
    int done = encoder && encode(encoder, picture, self->level, out);
    JxlEncoderDestroy(encoder);
    return done;
}

int codec_jxl_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in, void *texels) {
    JxlDecoder *decoder = JxlDecoderCreate(NULL);
    JxlPixelFormat format = pixel_format(picture, picture->channels);
    (void)self;
    JxlDecoderStatus status = JXL_DEC_ERROR;
    if (decoder && JxlDecoderSubscribeEvents(decoder, JXL_DEC_FULL_IMAGE) == JXL_DEC_SUCCESS &&
        JxlDecoderSetInput(decoder, in->data, in->size) == JXL_DEC_SUCCESS) {
        JxlDecoderCloseInput(decoder);
        status = JxlDecoderProcessInput(decoder);
    }
    if (status == JXL_DEC_NEED_IMAGE_OUT_BUFFER &&
        JxlDecoderSetImageOutBuffer(decoder, &format, texels, picture->size) == JXL_DEC_SUCCESS)
        status = JxlDecoderProcessInput(decoder);
    JxlDecoderDestroy(decoder);
    return status == JXL_DEC_FULL_IMAGE;
}
