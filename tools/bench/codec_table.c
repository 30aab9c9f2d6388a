/* SPDX-License-Identifier: Apache-2.0 */
/* Who takes part, and the versions of the libraries. */
#include <OpenEXR/openexr.h>
#include <jxl/version.h>
#include <png.h>
#include <spng.h>
#include <webp/decode.h>
#include <zstd.h>
#include <zt/zt.h>

#include "codec.h"

static int takes_8(const codec_picture *picture) {
    return picture->channel_bytes == 1;
}

static int takes_colour_8(const codec_picture *picture) {
    return picture->channel_bytes == 1 && picture->channels >= 3;
}

static int takes_half(const codec_picture *picture) {
    return picture->channel_bytes == 2;
}

#define OURS(effort, texels, label) \
    { .name = label, .encode = codec_zt_encode, .decode = codec_zt_decode, .level = effort, .edge = texels }
#define WALL(texels, count, label) \
    { .name = label, .encode = codec_zt_encode, .decode = codec_zt_decode, .edge = texels, .threads = count }
#define PEER(library, who, what, label)                                                                      \
    {                                                                                                        \
        .name = label, .takes = who, .encode = codec_##library##_encode, .decode = codec_##library##_decode, \
        .level = what                                                                                        \
    }

const codec_contender codec_contenders[CODEC_CONTENDERS] = {
    [CODEC_DEFAULT] = OURS(CODEC_EFFORT_DEFAULT, 256, "ztex, tiles of 256"),
    [CODEC_DEFAULT_512] = OURS(CODEC_EFFORT_DEFAULT, 512, "ztex, tiles of 512"),
    [CODEC_HIGHEST] = OURS(CODEC_EFFORT_HIGHEST, 256, "ztex, highest effort, tiles of 256"),
    [CODEC_CHOSEN] = OURS(CODEC_EFFORT_HIGHEST, 0, "ztex, highest effort, edge chosen"),
    [CODEC_WALL_1] = WALL(256, 1, "ztex, tiles of 256, 1 thread"),
    [CODEC_WALL_2] = WALL(256, 2, "ztex, tiles of 256, 2 threads"),
    [CODEC_WALL_BOTH] = {.name = "ztex, tiles of 256, 2 threads, a picture each",
                         .decode = codec_zt_both_decode,
                         .threads = 2,
                         .at_once = 2,
                         .bytes_of = CODEC_DEFAULT},
    [CODEC_WALL_1_512] = WALL(512, 1, "ztex, tiles of 512, 1 thread"),
    [CODEC_WALL_2_512] = WALL(512, 2, "ztex, tiles of 512, 2 threads"),
    [CODEC_PLAIN] = {.name = "ztex in plain C, tiles of 256",
                     .decode = codec_zt_plain_decode,
                     .bytes_of = CODEC_DEFAULT},
    [CODEC_COPY] = PEER(copy, NULL, 0, "memcpy"),
    [CODEC_ZSTD_1] = PEER(zstd, NULL, 1, "KTX2 way, zstd 1"),
    [CODEC_ZSTD_9] = PEER(zstd, NULL, 9, "KTX2 way, zstd 9"),
    [CODEC_ZSTD_19] = PEER(zstd, NULL, 19, "KTX2 way, zstd 19"),
    [CODEC_PNG] = PEER(png, takes_8, 9, "PNG 9, libpng"),
    [CODEC_SPNG] = {.name = "PNG 9, libspng", .takes = takes_8, .decode = codec_spng_decode, .bytes_of = CODEC_PNG},
    [CODEC_QOI] = PEER(qoi, takes_colour_8, 0, "QOI"),
    [CODEC_WEBP] = PEER(webp, takes_8, 6, "WebP lossless z6"),
    [CODEC_JXL_3] = PEER(jxl, NULL, 3, "JPEG XL e3"),
    [CODEC_JXL_7] = PEER(jxl, NULL, 7, "JPEG XL e7"),
    [CODEC_EXR_ZIP] = PEER(exr, takes_half, EXR_COMPRESSION_ZIP, "OpenEXR ZIP"),
    [CODEC_EXR_PIZ] = PEER(exr, takes_half, EXR_COMPRESSION_PIZ, "OpenEXR PIZ"),
};

const char *codec_row_name(int row) {
    return codec_contenders[row].name;
}

void codec_versions(FILE *out) {
    int major = 0, minor = 0, patch = 0;
    const char *extra = NULL;
    int webp = WebPGetDecoderVersion();
    exr_get_library_version(&major, &minor, &patch, &extra);
    fprintf(out,
            "libzt %s, libzstd %s, libpng %s, libspng %s, libwebp %d.%d.%d, libjxl %d.%d.%d, OpenEXR %d.%d.%d, QOI",
            zt_version_string(), ZSTD_versionString(), png_get_libpng_ver(NULL), spng_version_string(), webp >> 16,
            webp >> 8 & 255, webp & 255, JPEGXL_MAJOR_VERSION, JPEGXL_MINOR_VERSION, JPEGXL_PATCH_VERSION, major, minor,
            patch);
}
