/* SPDX-License-Identifier: Apache-2.0 */
/* Reading pictures through OpenImageIO. */
#include "image_support.h"
#include "pyramid.h"

#include <algorithm>
#include <climits>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <sys/stat.h>
#include <vector>

#include <zt/zt.h>

namespace img {

using OIIO::TypeDesc;

const primaries_row primaries_rows[] = {{1, {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f}},
                                        {5, {0.64f, 0.33f, 0.29f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f}},
                                        {6, {0.630f, 0.340f, 0.310f, 0.595f, 0.155f, 0.070f, 0.3127f, 0.3290f}},
                                        {9, {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f}},
                                        {10, {1.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 1.0f / 3.0f, 1.0f / 3.0f}},
                                        {11, {0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, 0.314f, 0.351f}},
                                        {12, {0.680f, 0.320f, 0.265f, 0.690f, 0.150f, 0.060f, 0.3127f, 0.3290f}}};
const size_t primaries_count = sizeof primaries_rows / sizeof primaries_rows[0];

// One line, printable, cut to the buffer.
void set_error(char *error, const std::string &text) {
    if (!error)
        return;
    std::string line = text.substr(0, text.find('\n'));
    std::snprintf(error, IMG_ERROR, "%s", line.empty() ? "unknown failure" : line.c_str());
}

void prepare() {
    static const bool once = [] {
        OIIO::attribute("threads", 1);
        OIIO::attribute("exr_threads", -1);
        OIIO::attribute("log_times", 0);
        return true;
    }();
    (void)once;
}

TypeDesc type_of(img_type type) {
    switch (type) {
    case IMG_U8:
        return TypeDesc::UINT8;
    case IMG_U16:
        return TypeDesc::UINT16;
    case IMG_HALF:
        return TypeDesc::HALF;
    default:
        return TypeDesc::FLOAT;
    }
}

img_type type_of(TypeDesc type) {
    switch (type.basetype) {
    case TypeDesc::UINT8:
        return IMG_U8;
    case TypeDesc::UINT16:
        return IMG_U16;
    case TypeDesc::HALF:
        return IMG_HALF;
    default:
        return IMG_FLOAT;
    }
}

namespace {

template <size_t N> void copy_text(char (&dst)[N], const std::string &text) {
    std::snprintf(dst, N, "%s", text.c_str());
}

// CICP numbers out of the names that OpenImageIO gives to colour spaces.
void find_colour(const OIIO::ImageSpec &spec, img_info &info) {
    std::string space = spec.get_string_attribute("oiio:ColorSpace");
    copy_text(info.colour_space, space);
    float gamma = spec.get_float_attribute("oiio:Gamma", 0.0f);
    if (OIIO::Strutil::iequals(space, "sRGB"))
        info.transfer = ZT_TRANSFER_SRGB, info.primaries = 1;
    else if (OIIO::Strutil::iequals(space, "Linear") || OIIO::Strutil::iequals(space, "lin_srgb"))
        info.transfer = ZT_TRANSFER_LINEAR, info.primaries = 1;
    else if (OIIO::Strutil::iequals(space, "Rec709"))
        info.transfer = 1, info.primaries = 1;
    else if (std::fabs(gamma - 2.2f) < 0.01f)
        info.transfer = 4;
    else if (std::fabs(gamma - 2.8f) < 0.01f)
        info.transfer = 5;
    const OIIO::ParamValue *xy = spec.find_attribute("chromaticities");
    if (xy && xy->type() == TypeDesc(TypeDesc::FLOAT, 8)) {
        const float *values = static_cast<const float *>(xy->data());
        info.primaries = 0;
        for (size_t i = 0; i < primaries_count; i++)
            if (std::equal(values, values + 8, primaries_rows[i].xy,
                           [](float a, float b) { return std::fabs(a - b) < 0.002f; }))
                info.primaries = primaries_rows[i].number;
    }
    const OIIO::ParamValue *cicp = spec.find_attribute("CICP");
    if (cicp && cicp->type() == TypeDesc(TypeDesc::INT, 4)) {
        info.primaries = uint8_t(cicp->get_int_indexed(0));
        info.transfer = uint8_t(cicp->get_int_indexed(1));
    }
    if (spec.find_attribute("ICCProfile")) {
        std::string name = spec.get_string_attribute("ICCProfile:profile_description");
        copy_text(info.icc, name.empty() ? "unnamed" : name);
    }
}

// OpenImageIO's GIF reader counts the alpha from 1, outside the picture.
int alpha_of(const OIIO::ImageSpec &spec) {
    if (spec.alpha_channel >= 0 && spec.alpha_channel < spec.nchannels)
        return spec.alpha_channel;
    return spec.alpha_channel < 0 ? -1 : spec.channelindex("A");
}

void fill_info(const OIIO::ImageInput &in, const OIIO::ImageSpec &spec, img_info &info) {
    if (spec.deep)
        throw failure("deep pictures are not supported");
    if (spec.width < 1 || spec.height < 1 || spec.depth < 1 || spec.nchannels < 1)
        throw failure("the picture is empty");
    if (spec.nchannels > IMG_CHANNELS)
        throw failure("more than 64 channels");
    info.full_width = uint32_t(spec.width);
    info.full_height = uint32_t(spec.height);
    info.depth = uint32_t(spec.depth);
    info.channels = uint32_t(spec.nchannels);
    info.type = type_of(spec.format);
    copy_text(info.type_name, spec.format.c_str());
    copy_text(info.format, in.format_name());
    for (int c = 0; c < spec.nchannels; c++)
        copy_text(info.channel_names[c], spec.channel_name(c));
    info.alpha_channel = alpha_of(spec);
    bool straight = spec.get_int_attribute("oiio:UnassociatedAlpha", 0) != 0;
    if (info.alpha_channel >= 0)
        info.alpha = straight ? IMG_ALPHA_STRAIGHT : IMG_ALPHA_PREMULTIPLIED;
    info.orientation = uint32_t(std::clamp(spec.get_int_attribute("Orientation", 1), 1, 8));
    copy_text(info.copyright, spec.get_string_attribute("Copyright"));
    copy_text(info.artist, spec.get_string_attribute("Artist"));
    copy_text(info.description, spec.get_string_attribute("ImageDescription"));
    find_colour(spec, info);
}

} // namespace
} // namespace img

struct close_tiles {
    void operator()(pyramid *p) const {
        pyramid_close(p);
    }
};

struct img_reader {
    std::unique_ptr<OIIO::ImageInput> in;        // or
    std::unique_ptr<pyramid, close_tiles> tiles; // a folder of tiles
    uint32_t tile_level = 0;
    int subimage = 0, level = 0; // as OpenImageIO counts them
    OIIO::ImageSpec spec;        // of this subimage and level
    img_info info = {};
    img_open_options options = {};
    uint32_t turn = 1; // orientation that is to be undone
    uint32_t crop_x = 0, crop_y = 0;
    OIIO::TypeDesc type; // of band and whole
    size_t pixel_size = 0;
    std::vector<unsigned char> band; // rows band_y to band_end of slice band_z as stored
    uint32_t band_y = 0, band_end = 0, band_z = 0;
    std::vector<unsigned char> whole; // the upright picture, or what resizing made of it
    uint32_t whole_width = 0;
    bool divide = false; // the file's texels come premultiplied, but leave straight
};

namespace img {
namespace {

void check_memory(const img_reader &r, double bytes) {
    double allowed = r.options.memory ? double(r.options.memory) : 1073741824.0;
    if (bytes <= allowed)
        return;
    char text[IMG_ERROR];
    std::snprintf(text, sizeof text, "the picture must be held in memory: %.0f MiB, %.0f MiB are allowed (--memory)",
                  std::ceil(bytes / 1048576.0), allowed / 1048576.0);
    throw failure(text);
}

// Integer files hold coded colours, and where OpenImageIO has multiplied them by alpha (WebP, say, or a TIFF that
// is stored so), it has multiplied the coded values, which no texture format means. So they are divided again.
template <class T> void divide_by_alpha(T *texels, size_t count, int channels, int alpha) {
    const uint32_t most = std::numeric_limits<T>::max();
    for (size_t i = 0; i < count; i++) {
        T *p = texels + i * size_t(channels);
        uint32_t a = p[alpha];
        for (int c = 0; a > 0 && a < most && c < channels; c++)
            if (c != alpha)
                p[c] = T(std::min<uint64_t>(most, (uint64_t(p[c]) * most + a / 2) / a));
    }
}

void undo_alpha(img_reader &r) {
    size_t count = r.band.size() / r.pixel_size;
    int channels = int(r.info.channels);
    if (r.info.type == IMG_U8)
        divide_by_alpha(r.band.data(), count, channels, r.info.alpha_channel);
    else
        divide_by_alpha(reinterpret_cast<uint16_t *>(r.band.data()), count, channels, r.info.alpha_channel);
}

// Makes stored row y of slice z part of the band. Tiled files are read a row of tiles at a time.
void fetch_band(img_reader &r, uint32_t z, uint32_t y) {
    if (!r.band.empty() && z == r.band_z && y >= r.band_y && y < r.band_end)
        return;
    const OIIO::ImageSpec &s = r.spec;
    int sub = r.subimage, level = r.level;
    size_t row = size_t(s.width) * r.pixel_size;
    uint32_t height = uint32_t(s.height);
    bool tiled = s.tile_width > 0 && s.tile_height > 0;
    uint32_t step = tiled ? uint32_t(s.tile_height) : uint32_t(std::clamp<size_t>((size_t(1) << 20) / row, 1, 256));
    uint32_t begin = tiled ? y / step * step : y;
    uint32_t end = std::min(height, begin + step);
    size_t slices = tiled ? size_t(std::max(s.tile_depth, 1)) : 1;
    uint32_t first_slice = tiled ? z / uint32_t(slices) * uint32_t(slices) : z;
    check_memory(r, double(row) * (end - begin) * double(slices));
    r.band.assign(row * (end - begin) * slices, 0);
    r.band_end = 0;
    bool good;
    char error[IMG_ERROR];
    if (r.tiles && pyramid_read(r.tiles.get(), r.tile_level, begin / step, r.band.data(), error))
        throw failure(error);
    if (r.tiles)
        good = true;
    else if (tiled)
        good = r.in->read_tiles(sub, level, s.x, s.x + s.width, s.y + int(begin), s.y + int(end),
                                s.z + int(first_slice), s.z + std::min(int(first_slice + slices), s.depth), 0,
                                s.nchannels, r.type, r.band.data());
    else
        good = r.in->read_scanlines(sub, level, s.y + int(begin), s.y + int(end), s.z + int(z), 0, s.nchannels, r.type,
                                    r.band.data());
    if (!good)
        throw failure(r.in->geterror());
    if (r.divide)
        undo_alpha(r);
    if (z > first_slice)
        r.band.erase(r.band.begin(), r.band.begin() + std::ptrdiff_t(row * (end - begin) * (z - first_slice)));
    r.band_z = z;
    r.band_y = begin;
    r.band_end = end;
}

const unsigned char *stored_row(img_reader &r, uint32_t z, uint32_t y) {
    fetch_band(r, z, y);
    return r.band.data() + size_t(y - r.band_y) * size_t(r.spec.width) * r.pixel_size;
}

// Where the stored texel (x, y) of a w x h picture stands upright.
void upright_place(uint32_t turn, uint32_t w, uint32_t h, uint32_t x, uint32_t y, uint32_t &ux, uint32_t &uy) {
    uint32_t fx = w - 1 - x, fy = h - 1 - y;
    switch (turn) {
    case 2:
        ux = fx, uy = y;
        break;
    case 3:
        ux = fx, uy = fy;
        break;
    case 4:
        ux = x, uy = fy;
        break;
    case 5:
        ux = y, uy = x;
        break;
    case 6:
        ux = fy, uy = x;
        break;
    case 7:
        ux = fy, uy = fx;
        break;
    case 8:
        ux = y, uy = fx;
        break;
    default:
        ux = x, uy = y;
        break;
    }
}

void load_upright(img_reader &r) {
    uint32_t w = uint32_t(r.spec.width), h = uint32_t(r.spec.height);
    size_t n = r.pixel_size;
    if (r.spec.depth > 1)
        throw failure("a volume cannot be turned or resized");
    check_memory(r, double(w) * h * double(n));
    std::vector<unsigned char> whole(size_t(w) * h * n);
    r.whole_width = r.info.full_width;
    for (uint32_t y = 0; y < h; y++) {
        const unsigned char *row = stored_row(r, 0, y);
        for (uint32_t x = 0; x < w; x++) {
            uint32_t ux, uy;
            upright_place(r.turn, w, h, x, y, ux, uy);
            std::memcpy(&whole[(size_t(uy) * r.whole_width + ux) * n], row + x * n, n);
        }
    }
    r.whole.swap(whole);
    r.band.clear();
    r.band_end = 0;
}

// Colours to premultiplied linear light and back, around a filter.
struct colour_coding {
    uint32_t transfer, channels;
    int alpha; // channel, -1: none
    bool multiply;

    void to_linear(float *p) const {
        for (uint32_t c = 0; c < channels; c++)
            if (int(c) != alpha) {
                p[c] = zt_transfer_decode(transfer, p[c]);
                if (multiply)
                    p[c] *= p[alpha];
            }
    }
    void from_linear(float *p) const {
        if (alpha >= 0)
            p[alpha] = std::clamp(p[alpha], 0.0f, 1.0f);
        for (uint32_t c = 0; c < channels; c++)
            if (int(c) != alpha) {
                if (multiply)
                    p[c] = p[alpha] > 0.0f ? p[c] / p[alpha] : 0.0f;
                p[c] = zt_transfer_encode(transfer, p[c]);
            }
    }
};

colour_coding coding_of(const img_reader &r) {
    uint32_t transfer = r.info.transfer;
    bool integer = r.info.type == IMG_U8 || r.info.type == IMG_U16;
    if (transfer == 0 || !zt_transfer_known(transfer))
        transfer = integer ? ZT_TRANSFER_SRGB : ZT_TRANSFER_LINEAR;
    if (r.options.resize_data)
        transfer = ZT_TRANSFER_LINEAR;
    return {transfer, r.info.channels, r.info.alpha_channel,
            r.info.alpha == IMG_ALPHA_STRAIGHT && !r.options.resize_data};
}

void read_rows(img_reader &r, uint32_t z, uint32_t y, uint32_t count, uint32_t channels, OIIO::TypeDesc type, void *dst,
               size_t pitch);

void resize(img_reader &r) {
    uint32_t w = r.info.width, h = r.info.height, channels = r.info.channels;
    uint32_t to_w = r.options.resize_width, to_h = r.options.resize_height;
    if (r.spec.depth > 1)
        throw failure("a volume cannot be turned or resized");
    check_memory(r, 4.0 * channels * (double(w) * h + double(to_w) * to_h));
    colour_coding coding = coding_of(r);
    OIIO::ImageSpec from(int(w), int(h), int(channels), OIIO::TypeDesc::FLOAT);
    OIIO::ImageSpec to(int(to_w), int(to_h), int(channels), OIIO::TypeDesc::FLOAT);
    from.alpha_channel = to.alpha_channel = -1; // the alpha is our own business here
    std::vector<float> source(size_t(w) * h * channels);
    read_rows(r, 0, 0, h, channels, OIIO::TypeDesc::FLOAT, source.data(), size_t(w) * channels * sizeof(float));
    for (size_t i = 0; i < size_t(w) * h; i++)
        coding.to_linear(&source[i * channels]);
    std::vector<unsigned char> result(size_t(to_w) * to_h * channels * sizeof(float));
    OIIO::ImageBuf src("source", from, source.data());
    OIIO::ImageBuf dst("result", to, result.data());
    if (!OIIO::ImageBufAlgo::resize(dst, src, "", 0.0f, OIIO::ROI(), 1))
        throw failure(dst.geterror());
    float *texels = reinterpret_cast<float *>(result.data());
    for (size_t i = 0; i < size_t(to_w) * to_h; i++)
        coding.from_linear(&texels[i * channels]);
    r.whole.swap(result);
    r.whole_width = to_w;
    r.type = OIIO::TypeDesc::FLOAT;
    r.pixel_size = channels * sizeof(float);
    r.crop_x = r.crop_y = 0;
    r.info.width = to_w;
    r.info.height = to_h;
}

void apply_options(img_reader &r) {
    img_info &info = r.info;
    const img_open_options &o = r.options;
    r.turn = o.keep_orientation ? 1 : info.orientation;
    if (r.turn > 4)
        std::swap(info.full_width, info.full_height);
    info.width = r.tile_level > 0 ? uint32_t(r.spec.width) : info.full_width;
    info.height = r.tile_level > 0 ? uint32_t(r.spec.height) : info.full_height;
    if (o.crop.width > 0) {
        bool inside = o.crop.height > 0 && uint64_t(o.crop.x) + o.crop.width <= info.width &&
                      uint64_t(o.crop.y) + o.crop.height <= info.height;
        if (!inside)
            throw failure("the crop rectangle is not inside the picture of " + std::to_string(info.width) + " x " +
                          std::to_string(info.height));
        r.crop_x = o.crop.x;
        r.crop_y = o.crop.y;
        info.width = o.crop.width;
        info.height = o.crop.height;
    }
    if (r.turn > 2)
        load_upright(r);
    if (o.resize_width > 0 && o.resize_height > 0)
        resize(r);
}

// A picture that is resized is held in memory: where that is too much, the finest level that is not.
void choose_level(img_reader &r) {
    const img_open_options &o = r.options;
    uint64_t allowed = o.memory ? o.memory : uint64_t(1) << 30;
    uint32_t w = r.info.full_width, h = r.info.full_height;
    if (o.resize_width == 0 || o.resize_height == 0 || o.crop.width > 0)
        return;
    for (uint32_t level = 1; level < pyramid_levels(r.tiles.get()); level++) {
        double texels = double(w) * h + double(o.resize_width) * o.resize_height;
        uint32_t next_w, next_h;
        pyramid_size(r.tiles.get(), level, &next_w, &next_h);
        if (texels * 4.0 * r.info.channels <= double(allowed) || next_w < o.resize_width || next_h < o.resize_height)
            break;
        r.tile_level = level;
        w = next_w, h = next_h;
    }
}

void open_pyramid(img_reader &r, const char *path) {
    char error[IMG_ERROR];
    if (r.options.subimage > 0 || r.options.level > 0)
        throw failure("a folder of tiles has one picture");
    r.tiles.reset(pyramid_open(path, error));
    if (!r.tiles)
        throw failure(error);
    r.info = *pyramid_info(r.tiles.get());
    choose_level(r);
    uint32_t w, h;
    pyramid_size(r.tiles.get(), r.tile_level, &w, &h);
    r.type = type_of(r.info.type);
    r.spec = OIIO::ImageSpec(int(w), int(h), int(r.info.channels), r.type);
    r.spec.tile_width = int(w);
    r.spec.tile_height = int(pyramid_tile_height(r.tiles.get()));
    r.pixel_size = r.info.channels * r.type.size();
}

// MIP levels of the file; or subimages that a TIFF calls reduced, which is how most programs write pyramids.
bool seek_level(img_reader &r, uint32_t level) {
    r.subimage = int(r.options.subimage);
    r.level = int(level);
    if (r.in->seek_subimage(r.subimage, r.level))
        return true;
    if (level == 0 || std::strcmp(r.in->format_name(), "tiff") != 0)
        return false;
    r.subimage += r.level;
    r.level = 0;
    return r.in->seek_subimage(r.subimage, 0) && (r.in->spec().get_int_attribute("tiff:subfiletype") & 1) != 0;
}

void open_file(img_reader &r, const char *path) {
    struct stat status;
    prepare();
    if (stat(path, &status) != 0)
        throw failure(std::strerror(errno));
    if (!S_ISREG(status.st_mode))
        throw failure("not a regular file");
    if (pyramid_is(path))
        return open_pyramid(r, path);
    OIIO::ImageSpec wish;
    wish.attribute("oiio:UnassociatedAlpha", 1);
    r.in = OIIO::ImageInput::open(path, &wish);
    if (!r.in) {
        std::string text = OIIO::geterror();
        throw failure(text.empty() ? "not a picture" : text);
    }
    if (!seek_level(r, r.options.level))
        throw failure("there is no subimage " + std::to_string(r.options.subimage) + " with level " +
                      std::to_string(r.options.level));
    r.spec = r.in->spec();
    fill_info(*r.in, r.spec, r.info);
    for (r.info.levels = 1; seek_level(r, r.info.levels);)
        r.info.levels++;
    for (r.info.subimages = r.options.subimage + 1; r.in->seek_subimage(int(r.info.subimages), 0);)
        r.info.subimages++;
    r.in->geterror(); // the searches above ended with one
    if (!seek_level(r, r.options.level))
        throw failure(r.in->geterror());
    r.divide = r.info.alpha == IMG_ALPHA_PREMULTIPLIED && r.info.type != IMG_HALF && r.info.type != IMG_FLOAT;
    if (r.divide)
        r.info.alpha = IMG_ALPHA_STRAIGHT;
    r.type = type_of(r.info.type);
    r.pixel_size = r.info.channels * r.type.size();
}

// One row of the picture as it is read, from its first column.
const unsigned char *picture_row(img_reader &r, uint32_t z, uint32_t y) {
    if (!r.whole.empty())
        return &r.whole[(size_t(r.crop_y + y) * r.whole_width + r.crop_x) * r.pixel_size];
    const unsigned char *row = stored_row(r, z, r.crop_y + y);
    if (r.turn == 2) // mirrored: the last column that is wanted comes first in the file
        return row + size_t(r.info.full_width - r.crop_x - 1) * r.pixel_size;
    return row + size_t(r.crop_x) * r.pixel_size;
}

void read_rows(img_reader &r, uint32_t z, uint32_t y, uint32_t count, uint32_t channels, OIIO::TypeDesc type, void *dst,
               size_t pitch) {
    OIIO::stride_t step = OIIO::stride_t(r.pixel_size);
    if (r.whole.empty() && r.turn == 2)
        step = -step;
    for (uint32_t i = 0; i < count; i++) {
        unsigned char *to = static_cast<unsigned char *>(dst) + i * pitch;
        const unsigned char *from = picture_row(r, z, y + i);
        if (!OIIO::convert_image(int(channels), int(r.info.width), 1, 1, from, r.type, step, OIIO::AutoStride,
                                 OIIO::AutoStride, to, type, OIIO::stride_t(channels * type.size()), OIIO::AutoStride,
                                 OIIO::AutoStride))
            throw failure("the texels cannot be converted");
    }
}

} // namespace
} // namespace img

/* ---- the C side ----------------------------------------------------------------------------------- */

extern "C" img_reader *img_open(const char *path, const img_open_options *options, char *error) {
    img_reader *reader = nullptr;
    int failed = img::guard(error, [&] {
        reader = new img_reader;
        if (options)
            reader->options = *options;
        img::open_file(*reader, path);
        img::apply_options(*reader);
    });
    if (failed) {
        img_close(reader);
        return nullptr;
    }
    return reader;
}

extern "C" const img_info *img_get_info(const img_reader *reader) {
    return &reader->info;
}

extern "C" int img_read_rows(img_reader *reader, uint32_t z, uint32_t y, uint32_t count, uint32_t channels,
                             img_type type, void *dst, size_t pitch, char *error) {
    return img::guard(error, [&] {
        const img_info &info = reader->info;
        uint32_t wanted = channels ? channels : info.channels;
        if (z >= info.depth || y > info.height || count > info.height - y || wanted > info.channels)
            throw img::failure("rows outside the picture");
        OIIO::TypeDesc to = img::type_of(type == IMG_NATIVE ? info.type : type);
        size_t tight = size_t(info.width) * wanted * to.size();
        img::read_rows(*reader, z, y, count, wanted, to, dst, pitch ? pitch : tight);
    });
}

extern "C" void img_close(img_reader *reader) {
    img::guard(nullptr, [&] { delete reader; });
}
