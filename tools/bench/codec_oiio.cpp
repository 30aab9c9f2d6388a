// SPDX-License-Identifier: Apache-2.0
// Reading the pictures of the codec benchmark: files through OpenImageIO, conversions as in pictures.txt.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <sstream>
#include <string>
#include <vector>

#include <OpenImageIO/imageio.h>

#include "codec.h"

namespace {

struct Raster {
    uint32_t width = 0, height = 0;
    std::vector<unsigned char> texels; // always RGBA
    unsigned char *at(uint32_t x, uint32_t y) {
        return texels.data() + (static_cast<size_t>(y) * width + x) * 4;
    }
    // Rec. 601 luma; the value itself for grey pictures.
    int grey(uint32_t x, uint32_t y) {
        const unsigned char *t = at(x, y);
        return (299 * t[0] + 587 * t[1] + 114 * t[2] + 500) / 1000;
    }
};

template <typename T>
bool read_channels(const char *path, OIIO::TypeDesc type, OIIO::ImageSpec &spec, std::vector<T> &out) {
    OIIO::ImageSpec config;
    config.attribute("oiio:UnassociatedAlpha", 1);
    auto in = OIIO::ImageInput::open(path, &config);
    if (!in) {
        fprintf(stderr, "%s: %s\n", path, OIIO::geterror().c_str());
        return false;
    }
    spec = in->spec();
    out.resize(static_cast<size_t>(spec.image_pixels()) * static_cast<size_t>(spec.nchannels));
    if (!in->read_image(0, 0, 0, spec.nchannels, type, out.data())) {
        fprintf(stderr, "%s: %s\n", path, in->geterror().c_str());
        return false;
    }
    return true;
}

bool read_rgba(const char *path, Raster &out) {
    OIIO::ImageSpec spec;
    std::vector<unsigned char> in;
    if (!read_channels(path, OIIO::TypeDesc::UINT8, spec, in))
        return false;
    size_t n = static_cast<size_t>(spec.nchannels), texels = static_cast<size_t>(spec.image_pixels());
    out.width = static_cast<uint32_t>(spec.width);
    out.height = static_cast<uint32_t>(spec.height);
    out.texels.resize(texels * 4);
    for (size_t i = 0; i < texels; i++) {
        const unsigned char *from = in.data() + i * n;
        unsigned char *to = out.texels.data() + i * 4;
        to[0] = from[0];
        to[1] = n < 3 ? from[0] : from[1];
        to[2] = n < 3 ? from[0] : from[2];
        to[3] = n == 2 || n >= 4 ? from[n == 2 ? 1 : 3] : 255;
    }
    return true;
}

void crop(Raster &raster, uint32_t width, uint32_t height) {
    Raster out;
    out.width = width < raster.width ? width : raster.width;
    out.height = height < raster.height ? height : raster.height;
    out.texels.resize(static_cast<size_t>(out.width) * out.height * 4);
    uint32_t left = (raster.width - out.width) / 2, top = (raster.height - out.height) / 2;
    for (uint32_t y = 0; y < out.height; y++)
        memcpy(out.at(0, y), raster.at(left, top + y), static_cast<size_t>(out.width) * 4);
    raster = out;
}

unsigned char unit_byte(double value) {
    return static_cast<unsigned char>(std::lround(value * 127.5 + 127.5));
}

void make_normals(Raster &raster) {
    Raster out = raster;
    uint32_t w = raster.width, h = raster.height;
    for (uint32_t y = 0; y < h; y++) {
        for (uint32_t x = 0; x < w; x++) {
            double dx = (raster.grey((x + 1) % w, y) - raster.grey((x + w - 1) % w, y)) / 255.0;
            double dy = (raster.grey(x, (y + 1) % h) - raster.grey(x, (y + h - 1) % h)) / 255.0;
            double length = std::sqrt(4 * dx * dx + 4 * dy * dy + 1);
            unsigned char *to = out.at(x, y);
            to[0] = unit_byte(-2 * dx / length);
            to[1] = unit_byte(-2 * dy / length);
            to[2] = unit_byte(1 / length);
            to[3] = 255;
        }
    }
    raster = out;
}

bool make_orm(Raster &raster, const char *other_path) {
    Raster other;
    if (!read_rgba(other_path, other) || other.width != raster.width || other.height != raster.height)
        return false;
    for (uint32_t y = 0; y < raster.height; y++) {
        for (uint32_t x = 0; x < raster.width; x++) {
            unsigned char *to = raster.at(x, y);
            int roughness = raster.grey(x, y);
            to[0] = to[3] = 255;
            to[1] = static_cast<unsigned char>(roughness);
            to[2] = static_cast<unsigned char>(other.grey(x, y));
        }
    }
    return true;
}

void take_alpha(Raster &raster) {
    for (size_t i = 0; i < raster.texels.size(); i += 4)
        memset(raster.texels.data() + i, raster.texels[i + 3], 3);
}

bool give(const unsigned char *texels, size_t size, unsigned channels, unsigned channel_bytes, codec_picture *out) {
    out->texels = static_cast<unsigned char *>(malloc(size));
    if (!out->texels)
        return false;
    memcpy(out->texels, texels, size);
    out->size = size;
    out->channels = channels;
    out->channel_bytes = channel_bytes;
    return true;
}

bool give_raster(Raster &raster, unsigned channels, codec_picture *out) {
    std::vector<unsigned char> packed;
    packed.reserve(raster.texels.size());
    for (uint32_t y = 0; y < raster.height; y++) {
        for (uint32_t x = 0; x < raster.width; x++) {
            if (channels == 1)
                packed.push_back(static_cast<unsigned char>(raster.grey(x, y)));
            else
                packed.insert(packed.end(), raster.at(x, y), raster.at(x, y) + channels);
        }
    }
    out->width = raster.width;
    out->height = raster.height;
    return give(packed.data(), packed.size(), channels, 1, out);
}

bool read_half(const char *path, codec_picture *out) {
    OIIO::ImageSpec spec;
    std::vector<uint16_t> in;
    if (!read_channels(path, OIIO::TypeDesc::HALF, spec, in) || spec.nchannels < 3)
        return false;
    size_t n = static_cast<size_t>(spec.nchannels), texels = static_cast<size_t>(spec.image_pixels());
    std::vector<uint16_t> rgba(texels * 4, 0x3C00);
    for (size_t i = 0; i < texels; i++)
        memcpy(rgba.data() + i * 4, in.data() + i * n, 6);
    out->width = static_cast<uint32_t>(spec.width);
    out->height = static_cast<uint32_t>(spec.height);
    return give(reinterpret_cast<const unsigned char *>(rgba.data()), rgba.size() * 2, 4, 2, out);
}

bool read_and_convert(const char *path, const char *conversion, codec_picture *out) {
    std::istringstream words{std::string(conversion)};
    std::string word;
    if (strcmp(conversion, "half") == 0)
        return read_half(path, out);
    Raster raster;
    if (!read_rgba(path, raster))
        return false;
    unsigned channels = 4, width, height;
    while (words >> word) {
        if (word == "r8")
            channels = 1;
        else if (word == "rgb8")
            channels = 3;
        else if (word == "normal")
            make_normals(raster);
        else if (word == "alpha")
            take_alpha(raster);
        else if (sscanf(word.c_str(), "crop=%u,%u", &width, &height) == 2)
            crop(raster, width, height);
        else if (word.compare(0, 4, "orm=") == 0 ? !make_orm(raster, word.c_str() + 4) : word != "rgba8")
            return false;
    }
    return give_raster(raster, channels, out);
}

} // namespace

int codec_read_picture(const char *path, const char *conversion, codec_picture *out) {
    try {
        return read_and_convert(path, conversion, out);
    } catch (const std::exception &error) {
        fprintf(stderr, "%s: %s\n", path, error.what());
        return 0;
    }
}
