/* SPDX-License-Identifier: Apache-2.0 */
/* The list of pictures, and small things that all parts of the codec benchmark use. */
#include <ctype.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "codec.h"

const char *const codec_groups[CODEC_GROUPS + 1] = {"photo", "albedo", "albedo+alpha", "normal",   "orm/mask",
                                                    "flat",  "ui",     "hdr",          "all 8-bit"};

int codec_group_of(const codec_picture *picture) {
    for (int i = 0; i < CODEC_GROUPS; i++) {
        if (strcmp(picture->group, codec_groups[i]) == 0)
            return i;
    }
    return -1;
}

int codec_reserve(codec_bytes *bytes, size_t size) {
    if (size <= bytes->room)
        return 1;
    unsigned char *data = realloc(bytes->data, size);
    if (!data) {
        fprintf(stderr, "no memory\n");
        return 0;
    }
    bytes->data = data;
    bytes->room = size;
    return 1;
}

int codec_append(codec_bytes *bytes, const void *data, size_t size) {
    size_t needed = bytes->size + size;
    if (needed > bytes->room && !codec_reserve(bytes, needed + needed / 2))
        return 0;
    memcpy(bytes->data + bytes->size, data, size);
    bytes->size = needed;
    return 1;
}

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

double codec_cpu_seconds(void) {
    return seconds(CLOCK_THREAD_CPUTIME_ID);
}

double codec_wall_seconds(void) {
    return seconds(CLOCK_MONOTONIC);
}

static int compare_doubles(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double codec_median(double *values, size_t count) {
    if (count == 0)
        return 0;
    qsort(values, count, sizeof *values, compare_doubles);
    return count % 2 ? values[count / 2] : 0.5 * (values[count / 2 - 1] + values[count / 2]);
}

static char *trim(char *text) {
    while (isspace((unsigned char)*text))
        text++;
    char *end = text + strlen(text);
    while (end > text && isspace((unsigned char)end[-1]))
        end--;
    *end = 0;
    return text;
}

/* Alpha that is one everywhere is worth no channel to any of the peers. */
static int find_opaque(codec_picture *picture) {
    size_t step = picture->channel_bytes, count = picture->size / (4 * step);
    unsigned char one[2] = {0xFF, 0};
    picture->rgb = picture->texels;
    if (picture->channels != 4)
        return 1;
    if (step == 2)
        memcpy(one, (unsigned char[]){0x00, 0x3C}, 2);
    for (size_t i = 0; i < count; i++) {
        if (memcmp(picture->texels + (i * 4 + 3) * step, one, step) != 0)
            return 1;
    }
    picture->opaque = 1;
    picture->rgb = malloc(count * 3 * step);
    if (!picture->rgb)
        return 0;
    for (size_t i = 0; i < count; i++)
        memcpy(picture->rgb + i * 3 * step, picture->texels + i * 4 * step, 3 * step);
    return 1;
}

void codec_release_picture(codec_picture *picture) {
    if (picture->rgb != picture->texels)
        free(picture->rgb);
    free(picture->texels);
}

/* "photo | package | path or archive!path | conversion" */
static int read_line(char *line, const char *folder, codec_picture *out) {
    char *fields[4], path[1024], *rest = NULL;
    for (int i = 0; i < 4; i++) {
        fields[i] = strtok_r(i == 0 ? line : NULL, "|", &rest);
        if (!fields[i])
            return 0;
        fields[i] = trim(fields[i]);
    }
    const char *member = strchr(fields[2], '!');
    if (member)
        snprintf(path, sizeof path, "%s/%s", folder, member + 1);
    else
        snprintf(path, sizeof path, "%s", fields[2]);
    const char *name = strrchr(path, '/');
    snprintf(out->group, sizeof out->group, "%.15s", fields[0]);
    snprintf(out->name, sizeof out->name, "%.63s", name ? name + 1 : path);
    if (codec_group_of(out) < 0) {
        fprintf(stderr, "%s: unknown class\n", fields[0]);
        return 0;
    }
    if (access(path, R_OK) != 0) {
        fprintf(stderr, "%s: not there (package %s), left out\n", path, fields[1]);
        return 0;
    }
    return codec_read_picture(path, fields[3], out) && find_opaque(out);
}

int codec_read_list(const char *list, const char *folder, codec_picture **out, size_t *count) {
    char line[1024];
    FILE *file = fopen(list, "r");
    *out = NULL;
    *count = 0;
    if (!file) {
        perror(list);
        return 0;
    }
    while (fgets(line, sizeof line, file)) {
        codec_picture picture = {0};
        if (line[0] == '#' || line[0] == '\n' || !read_line(line, folder, &picture))
            continue;
        codec_picture *more = realloc(*out, (*count + 1) * sizeof **out);
        if (!more)
            break;
        *out = more;
        more[(*count)++] = picture;
    }
    fclose(file);
    return *count > 0;
}
