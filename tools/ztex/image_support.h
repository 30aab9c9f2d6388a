/* SPDX-License-Identifier: Apache-2.0 */
/* What image_io.cpp (reading) and image_write.cpp share. C++ and OpenImageIO stay behind image_io.h. */
#ifndef ZTEX_IMAGE_SUPPORT_H
#define ZTEX_IMAGE_SUPPORT_H

#include "image_io.h"

#include <cstdio>
#include <exception>
#include <new>
#include <stdexcept>
#include <string>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wshadow"
#pragma GCC diagnostic ignored "-Wundef"
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#pragma GCC diagnostic pop

namespace img {

struct failure : std::runtime_error {
    using std::runtime_error::runtime_error;
};

void set_error(char *error, const std::string &text);
void prepare(); // the global settings of OpenImageIO, once
OIIO::TypeDesc type_of(img_type type);
img_type type_of(OIIO::TypeDesc type);

// CICP primaries and the eight numbers of OpenEXR's chromaticities.
struct primaries_row {
    uint8_t number;
    float xy[8];
};
extern const primaries_row primaries_rows[];
extern const size_t primaries_count;

// Runs work, and turns whatever it throws into a text. Returns 0 or -1.
template <class Work> int guard(char *error, Work &&work) noexcept {
    try {
        work();
        return 0;
    } catch (const std::bad_alloc &) {
        set_error(error, "out of memory");
    } catch (const std::exception &e) {
        set_error(error, e.what());
    } catch (...) {
        set_error(error, "unknown failure");
    }
    return -1;
}

} // namespace img

#endif
