/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Property: pictures survive the way out and in again. Texels come back exactly wherever the format can hold them,
 * straight alpha is not multiplied on the way, equal input gives equal bytes, and a failed or abandoned write leaves no
 * trace. It matters because extract and make are only as exact as this layer. Usage: image_io_test FOLDER
 */
#include "../image_io.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define W 37
#define H 21

static int failures;

static void check(int good, const char *what, const char *detail) {
    if (good)
        return;
    failures++;
    printf("FAILED: %s: %s\n", what, detail);
}

static const char *path_of(const char *folder, const char *name) {
    static char paths[4][1024];
    static int next;
    char *path = paths[next++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", folder, name);
    return path;
}

static void fill(unsigned char *texels, img_type type, uint32_t channels) {
    for (uint32_t i = 0; i < W * H * channels; i++) {
        uint32_t value = (i * 2654435761u) >> 16; /* any 16 bits */
        if (type == IMG_U8)
            texels[i] = (unsigned char)value;
        else if (type == IMG_U16)
            memcpy(texels + 2 * i, &(uint16_t){(uint16_t)value}, 2);
        else if (type == IMG_HALF) /* finite, positive */
            memcpy(texels + 2 * i, &(uint16_t){(uint16_t)(value % 0x3C00)}, 2);
        else
            memcpy(texels + 4 * i, &(float){(float)value / 1000.0f}, 4);
    }
}

static void round_trip(const char *folder, const char *name, img_type type, uint32_t channels, img_alpha alpha) {
    static unsigned char out[W * H * 4 * 4], back[W * H * 4 * 4];
    char error[IMG_ERROR] = "";
    img_text text = {"Copyright", "the author"};
    img_create_options options = {.width = W,
                                  .height = H,
                                  .channels = channels,
                                  .type = type,
                                  .alpha = alpha,
                                  .transfer = type == IMG_FLOAT || type == IMG_HALF ? 8 : 13,
                                  .texts = &text,
                                  .text_count = 1};
    const char *path = path_of(folder, name);
    fill(out, type, channels);
    check(img_write(path, &options, type, out, 0, error) == 0, name, error);
    img_reader *reader = img_open(path, NULL, error);
    check(reader != NULL, name, error);
    if (!reader)
        return;
    const img_info *info = img_get_info(reader);
    check(info->width == W && info->height == H && info->channels == channels, name, "size");
    check(info->type == type, name, info->type_name);
    check(info->alpha == alpha, name, "alpha mode");
    check(strcmp(info->copyright, "the author") == 0, name, "copyright");
    /* In uneven bands, and once backwards. */
    size_t row = (size_t)W * channels * img_type_size(type);
    for (uint32_t y = 0; y < H; y += 5) {
        uint32_t count = H - y < 5 ? H - y : 5;
        check(img_read_rows(reader, 0, y, count, 0, IMG_NATIVE, back + y * row, 0, error) == 0, name, error);
    }
    check(memcmp(out, back, H * row) == 0, name, "texels");
    check(img_read_rows(reader, 0, 2, 1, 0, type, back, 0, error) == 0, name, error);
    check(memcmp(out + 2 * row, back, row) == 0, name, "texels, going back");
    img_close(reader);
}

static size_t load(const char *path, unsigned char *bytes, size_t size) {
    FILE *file = fopen(path, "rb");
    size_t count = file ? fread(bytes, 1, size, file) : 0;
    if (file)
        fclose(file);
    return count;
}

static void same_bytes(const char *folder, const char *first, const char *second) {
    static unsigned char a[1 << 18], b[1 << 18];
    size_t size = load(path_of(folder, first), a, sizeof a);
    check(size > 0 && size == load(path_of(folder, second), b, sizeof b) && memcmp(a, b, size) == 0, first,
          "two writes differ");
}

static int entries(const char *folder) {
    DIR *dir = opendir(folder);
    int count = 0;
    while (dir && readdir(dir))
        count++;
    if (dir)
        closedir(dir);
    return count;
}

static void failures_leave_nothing(const char *folder) {
    static const unsigned char texels[W * H * 4];
    char error[IMG_ERROR] = "";
    img_create_options options = {
        .width = W, .height = H, .channels = 4, .type = IMG_U8, .alpha = IMG_ALPHA_STRAIGHT, .transfer = 13};
    int before = entries(folder);
    img_writer *writer = img_create(path_of(folder, "rgba.png"), &options, error);
    check(writer != NULL, "abandoned write", error);
    check(img_write_rows(writer, 3, IMG_U8, texels, 0, error) == 0, "abandoned write", error);
    img_discard(writer);
    check(entries(folder) == before, "abandoned write", "left a file");
    writer = img_create(path_of(folder, "rgba.png"), &options, error);
    check(writer && img_finish(writer, error) != 0, "write without rows", "was accepted");
    check(entries(folder) == before, "write without rows", "left a file");
    check(img_create(path_of(folder, "x.jpg"), &options, error) == NULL, "JPEG with alpha", "was accepted");
    check(strstr(error, "alpha") != NULL, "JPEG with alpha", error);
    check(img_create(path_of(folder, "x.xyz"), &options, error) == NULL, "unknown extension", "was accepted");
    check(img_create(path_of(folder, "no/x.png"), &options, error) == NULL, "missing folder", "was accepted");
    check(entries(folder) == before, "refused writes", "left a file");
    round_trip(folder, "rgba.png", IMG_U8, 4, IMG_ALPHA_STRAIGHT);
}

static void crop_and_resize(const char *folder) {
    char error[IMG_ERROR] = "";
    unsigned char whole[W * H * 3], part[W * H * 3];
    img_open_options crop = {.crop = {5, 3, 11, 7}};
    img_open_options outside = {.crop = {30, 3, 11, 7}};
    img_open_options small = {.resize_width = 8, .resize_height = 4};
    img_open_options poor = {.resize_width = 8, .resize_height = 4, .memory = 100};
    const char *path = path_of(folder, "rgb.png");
    img_reader *reader = img_open(path, NULL, error);
    check(reader && img_read_rows(reader, 0, 0, H, 0, IMG_U8, whole, 0, error) == 0, "whole", error);
    img_close(reader);
    reader = img_open(path, &crop, error);
    check(reader && img_read_rows(reader, 0, 0, 7, 0, IMG_U8, part, 0, error) == 0, "crop", error);
    for (int y = 0; y < 7; y++)
        check(memcmp(part + y * 33, whole + ((y + 3) * W + 5) * 3, 33) == 0, "crop", "texels");
    img_close(reader);
    check(img_open(path, &outside, error) == NULL, "crop outside", "was accepted");
    reader = img_open(path, &small, error);
    check(reader && img_get_info(reader)->width == 8 && img_get_info(reader)->full_width == W, "resize", error);
    img_close(reader);
    check(img_open(path, &poor, error) == NULL && strstr(error, "--memory"), "resize in 100 bytes", error);
}

int main(int argc, char **argv) {
    if (argc != 2)
        return 2;
    const char *folder = argv[1];
    round_trip(folder, "grey.png", IMG_U8, 1, IMG_ALPHA_NONE);
    round_trip(folder, "rgb.png", IMG_U8, 3, IMG_ALPHA_NONE);
    round_trip(folder, "rgba16.png", IMG_U16, 4, IMG_ALPHA_STRAIGHT);
    round_trip(folder, "rgba.tif", IMG_U8, 4, IMG_ALPHA_STRAIGHT);
    round_trip(folder, "rgb16.tif", IMG_U16, 3, IMG_ALPHA_NONE);
    round_trip(folder, "float.tif", IMG_FLOAT, 3, IMG_ALPHA_NONE);
    round_trip(folder, "half.exr", IMG_HALF, 4, IMG_ALPHA_PREMULTIPLIED);
    round_trip(folder, "float.exr", IMG_FLOAT, 3, IMG_ALPHA_NONE);
    round_trip(folder, "rgba.png", IMG_U8, 4, IMG_ALPHA_STRAIGHT);
    round_trip(folder, "again.png", IMG_U8, 4, IMG_ALPHA_STRAIGHT);
    round_trip(folder, "again.exr", IMG_HALF, 4, IMG_ALPHA_PREMULTIPLIED);
    round_trip(folder, "again.tif", IMG_U8, 4, IMG_ALPHA_STRAIGHT);
    same_bytes(folder, "rgba.png", "again.png");
    same_bytes(folder, "half.exr", "again.exr");
    same_bytes(folder, "rgba.tif", "again.tif");
    failures_leave_nothing(folder);
    crop_and_resize(folder);
    check(img_can_write("png") && img_can_write("a/b.EXR") && !img_can_write("x"), "img_can_write", "");
    check(img_extension(0) != NULL && img_extension(100000) == NULL, "img_extension", "");
    printf("%d failures\n", failures);
    return failures != 0;
}
