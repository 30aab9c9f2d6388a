/* SPDX-License-Identifier: Apache-2.0 */
/* Writing pictures through OpenImageIO: whole or not at all. */
#include "image_support.h"

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <fcntl.h>
#include <memory>
#include <sys/stat.h>
#include <unistd.h>
#include <vector>

#include <zt/zt.h>

struct img_writer {
    std::unique_ptr<OIIO::ImageOutput> out;
    std::string path, temporary;
    int to_stream = 0; // copied to standard output or a device instead of renamed
    uint32_t width = 0, height = 0, channels = 0, next = 0;
    img_type type = IMG_U8;
    int premultiply = 0; // the format knows no straight alpha
    uint8_t transfer = 0;
};

namespace img {
namespace {

int (*hook_added)(const char *);
void (*hook_gone)(const char *);

std::string extension_of(const std::string &path) {
    size_t dot = path.find_last_of("./");
    std::string end = dot == std::string::npos || path[dot] == '/' ? "" : path.substr(dot + 1);
    OIIO::Strutil::to_lower(end);
    return end;
}

// Every extension that can be written, in OpenImageIO's order.
const std::vector<std::string> &extensions() {
    static const std::vector<std::string> list = [] {
        std::vector<std::string> names;
        std::string all = std::string(OIIO::get_string_attribute("extension_list"));
        std::string outputs = "," + std::string(OIIO::get_string_attribute("output_format_list")) + ",";
        for (const std::string &entry : OIIO::Strutil::splits(all, ";")) {
            std::vector<std::string> halves = OIIO::Strutil::splits(entry, ":");
            if (halves.size() != 2 || halves[0] == "null" || outputs.find("," + halves[0] + ",") == std::string::npos)
                continue;
            for (const std::string &name : OIIO::Strutil::splits(halves[1], ","))
                names.push_back(name);
        }
        return names;
    }();
    return list;
}

bool is_special(const std::string &path) {
    struct stat info;
    return stat(path.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

mode_t mode_for(const std::string &path) {
    struct stat info;
    if (stat(path.c_str(), &info) == 0 && S_ISREG(info.st_mode))
        return info.st_mode & 0777;
    mode_t mask = umask(0);
    umask(mask);
    return 0666 & ~mask;
}

void make_temporary(img_writer &w, const std::string &extension) {
    std::string folder = w.path.substr(0, w.path.find_last_of('/') + 1);
    if (w.to_stream) {
        const char *set = std::getenv("TMPDIR");
        folder = std::string(set && *set ? set : "/tmp") + "/";
    }
    std::string name = folder + ".ztex-XXXXXX." + extension;
    int fd = mkstemps(name.data(), int(extension.size()) + 1);
    if (fd < 0)
        throw failure(std::string("cannot write to its folder: ") + std::strerror(errno));
    w.temporary = name;
    if (hook_added)
        hook_added(name.c_str());
    fchmod(fd, mode_for(w.path));
    close(fd);
}

void forget_temporary(img_writer &w) {
    if (hook_gone && !w.temporary.empty())
        hook_gone(w.temporary.c_str());
    w.temporary.clear();
}

void check_channels(const OIIO::ImageOutput &out, const img_create_options &o) {
    static const char advice[] = ": png, tif and exr can";
    std::string name = out.format_name();
    bool plain = o.channels == 1 || o.channels == 3;
    if (o.alpha != IMG_ALPHA_NONE && !out.supports("alpha"))
        throw failure(name + " files cannot hold alpha" + advice);
    if (!plain && !out.supports("alpha") && !out.supports("nchannels"))
        throw failure(name + " files cannot hold " + std::to_string(o.channels) + " channels" + advice);
    if (o.channels > 4 && !out.supports("nchannels"))
        throw failure(name + " files cannot hold " + std::to_string(o.channels) + " channels: tif and exr can");
}

// Both put the time of day into the file when nobody gives them one; equal input shall give equal bytes.
void fix_time(OIIO::ImageSpec &spec) {
    spec.attribute("DateTime", "1970:01:01 00:00:00");
    spec.attribute("Software", "ztex");
}

void set_colour(OIIO::ImageSpec &spec, const img_create_options &o, bool exr) {
    if (o.transfer == ZT_TRANSFER_SRGB)
        spec.attribute("oiio:ColorSpace", "sRGB");
    else if (o.transfer == ZT_TRANSFER_LINEAR)
        spec.attribute("oiio:ColorSpace", "Linear");
    else if (o.transfer == 1)
        spec.attribute("oiio:ColorSpace", "Rec709");
    else if (o.transfer == 4 || o.transfer == 5) {
        spec.attribute("oiio:ColorSpace", o.transfer == 4 ? "Gamma2.2" : "Gamma2.8");
        spec.attribute("oiio:Gamma", o.transfer == 4 ? 2.2f : 2.8f);
    }
    for (size_t i = 0; exr && o.primaries > 1 && i < primaries_count; i++)
        if (primaries_rows[i].number == o.primaries)
            spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), primaries_rows[i].xy);
}

std::vector<std::string> channel_names(const img_create_options &o) {
    static const char *const usual[5][4] = {{}, {"Y"}, {"Y", "A"}, {"R", "G", "B"}, {"R", "G", "B", "A"}};
    std::vector<std::string> names;
    for (uint32_t c = 0; c < o.channels; c++)
        if (o.channel_names)
            names.push_back(o.channel_names[c]);
        else
            names.push_back(o.channels <= 4 ? usual[o.channels][c] : "C" + std::to_string(c));
    return names;
}

OIIO::ImageSpec spec_of(const img_create_options &o, const std::string &format) {
    OIIO::ImageSpec spec(int(o.width), int(o.height), int(o.channels), type_of(o.type));
    spec.channelnames = channel_names(o);
    spec.alpha_channel = o.alpha == IMG_ALPHA_NONE ? -1 : int(o.channels) - 1;
    // Without it writers of straight formats would divide by the last channel.
    if (o.alpha != IMG_ALPHA_PREMULTIPLIED)
        spec.attribute("oiio:UnassociatedAlpha", 1);
    set_colour(spec, o, format == "openexr");
    fix_time(spec);
    if (o.compression)
        spec.attribute("compression", o.compression);
    else if (format == "jpeg" || format == "webp")
        spec.attribute("CompressionQuality", o.quality ? o.quality : 95);
    for (size_t i = 0; i < o.text_count; i++)
        spec.attribute(o.texts[i].name, o.texts[i].value);
    return spec;
}

void create(img_writer &w, const char *path, const img_create_options &o) {
    prepare();
    w.path = path;
    w.to_stream = w.path == "-" || is_special(w.path);
    w.width = o.width;
    w.height = o.height;
    w.channels = o.channels;
    w.transfer = o.transfer;
    std::string extension = extension_of(o.format ? "." + std::string(o.format) : w.path);
    if (!img_can_write(extension.c_str()))
        throw failure(extension.empty()
                          ? "the name has no extension that says the picture format"
                          : "pictures of type '" + extension + "' cannot be written: try png, tif or exr");
    w.out = OIIO::ImageOutput::create("x." + extension);
    if (!w.out)
        throw failure(OIIO::geterror());
    check_channels(*w.out, o);
    std::string format = w.out->format_name();
    w.premultiply = o.alpha == IMG_ALPHA_STRAIGHT && format == "openexr";
    OIIO::ImageSpec spec = spec_of(o, format);
    make_temporary(w, extension);
    if (!w.out->open(w.temporary, spec))
        throw failure(w.out->geterror());
    w.type = type_of(w.out->spec().format);
}

void premultiply(img_writer &w, uint32_t count, OIIO::TypeDesc type, const void *src, size_t pitch,
                 std::vector<float> &rows) {
    size_t texels = size_t(w.width) * count;
    rows.resize(texels * w.channels);
    OIIO::convert_image(int(w.channels), int(w.width), int(count), 1, src, type,
                        OIIO::stride_t(w.channels * type.size()), OIIO::stride_t(pitch), OIIO::AutoStride, rows.data(),
                        OIIO::TypeDesc::FLOAT, OIIO::AutoStride, OIIO::AutoStride, OIIO::AutoStride);
    for (size_t i = 0; i < texels; i++) {
        float *p = &rows[i * w.channels];
        for (uint32_t c = 0; c + 1 < w.channels; c++)
            p[c] *= p[w.channels - 1];
    }
}

void write_rows(img_writer &w, uint32_t count, img_type type, const void *src, size_t pitch) {
    if (count > w.height - w.next)
        throw failure("more rows than the picture has");
    OIIO::TypeDesc from = type_of(type);
    size_t step = pitch ? pitch : size_t(w.width) * w.channels * from.size();
    std::vector<float> rows;
    if (w.premultiply) {
        premultiply(w, count, from, src, step, rows);
        src = rows.data();
        from = OIIO::TypeDesc::FLOAT;
        step = size_t(w.width) * w.channels * sizeof(float);
    }
    int y = int(w.next);
    if (!w.out->write_scanlines(y, y + int(count), 0, from, src, OIIO::AutoStride, OIIO::stride_t(step)))
        throw failure(w.out->geterror());
    w.next += count;
}

void copy_to_stream(const img_writer &w) {
    std::unique_ptr<FILE, int (*)(FILE *)> in(std::fopen(w.temporary.c_str(), "rb"), std::fclose);
    FILE *out = w.path == "-" ? stdout : std::fopen(w.path.c_str(), "wb");
    std::vector<char> buffer(65536);
    bool good = in && out;
    size_t count = 0;
    while (good && (count = std::fread(buffer.data(), 1, buffer.size(), in.get())) > 0)
        good = std::fwrite(buffer.data(), 1, count, out) == count;
    good = good && !std::ferror(in.get()) && std::fflush(out) == 0;
    if (out && out != stdout)
        good = std::fclose(out) == 0 && good;
    if (!good)
        throw failure(std::string("writing failed: ") + std::strerror(errno));
}

// libpng complains on standard error when a picture is given up; nobody needs to know.
struct silence {
    int kept = dup(STDERR_FILENO);
    silence() {
        int null = open("/dev/null", O_WRONLY | O_CLOEXEC);
        if (kept >= 0 && null >= 0)
            dup2(null, STDERR_FILENO);
        if (null >= 0)
            close(null);
    }
    ~silence() {
        if (kept < 0)
            return;
        dup2(kept, STDERR_FILENO);
        close(kept);
    }
    silence(const silence &) = delete;
    silence &operator=(const silence &) = delete;
};

void finish(img_writer &w) {
    if (w.next != w.height)
        throw failure("rows are missing");
    if (!w.out->close())
        throw failure(w.out->geterror());
    if (w.to_stream) {
        copy_to_stream(w);
        return;
    }
    int fd = open(w.temporary.c_str(), O_RDONLY | O_CLOEXEC);
    bool good = fd >= 0 && fsync(fd) == 0;
    if (fd >= 0)
        close(fd);
    if (!good || rename(w.temporary.c_str(), w.path.c_str()) != 0)
        throw failure(std::strerror(errno));
    forget_temporary(w);
}

} // namespace
} // namespace img

extern "C" img_writer *img_create(const char *path, const img_create_options *options, char *error) {
    img_writer *writer = nullptr;
    int failed = img::guard(error, [&] {
        if (options->width < 1 || options->height < 1 || options->channels < 1 || options->channels > IMG_CHANNELS ||
            options->type == IMG_NATIVE)
            throw img::failure("no such picture");
        writer = new img_writer;
        img::create(*writer, path, *options);
    });
    if (failed) {
        img_discard(writer);
        return nullptr;
    }
    return writer;
}

extern "C" img_type img_writer_type(const img_writer *writer) {
    return writer->type;
}

extern "C" int img_write_rows(img_writer *writer, uint32_t count, img_type type, const void *src, size_t pitch,
                              char *error) {
    return img::guard(error, [&] { img::write_rows(*writer, count, type, src, pitch); });
}

extern "C" int img_finish(img_writer *writer, char *error) {
    int failed = img::guard(error, [&] { img::finish(*writer); });
    img_discard(writer);
    return failed;
}

extern "C" void img_discard(img_writer *writer) {
    if (!writer)
        return;
    std::string temporary = writer->temporary;
    img::guard(nullptr, [&] {
        img::silence quiet;
        writer->out.reset();
    });
    if (!temporary.empty()) {
        unlink(temporary.c_str());
        img::forget_temporary(*writer);
    }
    delete writer;
}

extern "C" int img_write(const char *path, const img_create_options *options, img_type type, const void *src,
                         size_t pitch, char *error) {
    img_writer *writer = img_create(path, options, error);
    if (!writer)
        return -1;
    if (img_write_rows(writer, options->height, type, src, pitch, error)) {
        img_discard(writer);
        return -1;
    }
    return img_finish(writer, error);
}

extern "C" int img_can_write(const char *name) {
    int found = 0;
    img::guard(nullptr, [&] {
        std::string end = img::extension_of(name);
        if (end.empty())
            end = name;
        OIIO::Strutil::to_lower(end);
        const std::vector<std::string> &list = img::extensions();
        found = std::find(list.begin(), list.end(), end) != list.end();
    });
    return found;
}

extern "C" const char *img_extension(uint32_t i) {
    const char *name = nullptr;
    img::guard(nullptr, [&] {
        if (i < img::extensions().size())
            name = img::extensions()[i].c_str();
    });
    return name;
}

extern "C" void img_set_temporary_hooks(int (*added)(const char *name), void (*gone)(const char *name)) {
    img::hook_added = added;
    img::hook_gone = gone;
}
