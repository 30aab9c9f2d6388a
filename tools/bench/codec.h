/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parts of the benchmark of tile codecs (./dev bench codec): pictures, contenders, figures.
 * Functions that can fail return 1 for success and 0 for failure, after saying why on stderr.
 */
#ifndef CODEC_H
#define CODEC_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef struct codec_bytes {
    unsigned char *data;
    size_t size, room;
} codec_bytes;

/* Makes room for size bytes in all. */
int codec_reserve(codec_bytes *bytes, size_t size);
int codec_append(codec_bytes *bytes, const void *data, size_t size);

typedef struct codec_picture {
    char group[16], name[64];
    uint32_t width, height;
    unsigned channels;      /* 1, 3 or 4 */
    unsigned channel_bytes; /* 1: UNORM, 2: half */
    int opaque;             /* 1: four channels, alpha one everywhere: peers get three, and decode to four */
    size_t size;            /* of texels */
    unsigned char *texels;
    unsigned char *rgb; /* without alpha when opaque, else the texels themselves */
} codec_picture;

/* Channels that a peer is given: without an alpha that says nothing. */
static inline unsigned codec_channels(const codec_picture *picture) {
    return picture->opaque ? 3 : picture->channels;
}

/* Reads a file and converts it as pictures.txt says; sets all but group, name, opaque and rgb. */
int codec_read_picture(const char *path, const char *conversion, codec_picture *out);

/* Reads the list; pictures of archives are in folder. Those that are not there are left out with a warning. */
int codec_read_list(const char *list, const char *folder, codec_picture **out, size_t *count);

void codec_release_picture(codec_picture *picture);

/* ---- contenders ---- */

typedef struct codec_contender codec_contender;
struct codec_contender {
    const char *name;
    int (*takes)(const codec_picture *picture); /* NULL: any */
    /* NULL: decodes what contender `bytes_of` has encoded */
    int (*encode)(const codec_contender *self, const codec_picture *picture, codec_bytes *out);
    int (*decode)(const codec_contender *self, const codec_picture *picture, const codec_bytes *in, void *texels);
    int level;     /* the peer's effort or level */
    unsigned edge; /* ours: texels, 0: chosen */
    int threads;   /* ours: 0: in the calling thread, measured in its CPU time; else wall time */
    int at_once;   /* pictures that one call decodes; 0: one */
    int bytes_of;
};

enum {
    CODEC_DEFAULT, /* ours at the default effort, tile edge 256 */
    CODEC_DEFAULT_512,
    CODEC_HIGHEST, /* edge 256 */
    CODEC_CHOSEN,  /* highest effort, the edge that libzt chooses */
    CODEC_WALL_1,  /* edge 256, one thread, wall time */
    CODEC_WALL_2,
    CODEC_WALL_BOTH, /* two threads that each decode the picture, alone: how much of two processors there is */
    CODEC_WALL_1_512,
    CODEC_WALL_2_512,
    CODEC_PLAIN, /* the files of CODEC_DEFAULT, decoded without vector instructions of our own */
    CODEC_COPY,
    CODEC_ZSTD_1,
    CODEC_ZSTD_9,
    CODEC_ZSTD_19,
    CODEC_PNG,
    CODEC_SPNG,
    CODEC_QOI,
    CODEC_WEBP,
    CODEC_JXL_3,
    CODEC_JXL_7,
    CODEC_EXR_ZIP,
    CODEC_EXR_PIZ,
    CODEC_CONTENDERS
};

extern const codec_contender codec_contenders[CODEC_CONTENDERS];
const char *codec_row_name(int row);

#define CODEC_DECLARE(name)                                                                                     \
    int codec_##name##_encode(const codec_contender *self, const codec_picture *picture, codec_bytes *out);     \
    int codec_##name##_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in, \
                              void *texels)
/* Bytes of a KTX2 file beside its levels. */
size_t codec_ktx2_overhead(unsigned levels, unsigned channels);

CODEC_DECLARE(zt);
int codec_zt_both_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in,
                         void *texels);
int codec_zt_plain_decode(const codec_contender *self, const codec_picture *picture, const codec_bytes *in,
                          void *texels);
CODEC_DECLARE(copy);
CODEC_DECLARE(zstd);
CODEC_DECLARE(png);
CODEC_DECLARE(spng);
CODEC_DECLARE(qoi);
CODEC_DECLARE(webp);
CODEC_DECLARE(jxl);
CODEC_DECLARE(exr);

enum { CODEC_EFFORT_DEFAULT = 0, CODEC_EFFORT_HIGHEST = 9 };

/* A whole texture of 4096 x 4096 with all levels, loaded from memory into memory. */
typedef struct codec_load {
    int there;
    unsigned sources; /* different pictures in it */
    size_t texels, ours, peer;
    double ours_cpu, peer_cpu, ours_wall, ours_wall_2, copy_cpu;
} codec_load;

int codec_load_test(const codec_picture *pictures, size_t count, unsigned rounds, codec_load *out);

/* Versions of the libraries, one a line. */
void codec_versions(FILE *out);

/* ---- time ---- */

double codec_cpu_seconds(void);
double codec_wall_seconds(void);
double codec_median(double *values, size_t count); /* sorts them */

/* ---- figures ---- */

typedef struct codec_figure {
    int there;
    int wrong; /* 1: the decoded texels differ from the source; 2: only subnormal half floats do */
    size_t size;
    double encode, decode; /* seconds; encode 0: not measured */
} codec_figure;

typedef struct codec_report {
    const codec_picture *pictures;
    size_t count;
    codec_figure (*figures)[CODEC_CONTENDERS]; /* for each picture */
    codec_load load;
    unsigned rounds;
    const char *command;
} codec_report;

/* A set of pictures: the index of a class, CODEC_ALL_8, or CODEC_ONE + the index of a picture. */
enum { CODEC_GROUPS = 8, CODEC_HDR = 7, CODEC_ALL_8 = CODEC_GROUPS, CODEC_ONE = CODEC_GROUPS + 1 };
extern const char *const codec_groups[CODEC_GROUPS + 1];
int codec_group_of(const codec_picture *picture); /* -1: unknown */

/* Sums over the pictures of the set that `row` and `also` (-1: none) both take. */
typedef struct codec_sum {
    size_t pictures, raw, size;
    double encode, decode;
} codec_sum;
codec_sum codec_add_up(const codec_report *report, int set, int row, int also);

void codec_write_report(const codec_report *report, FILE *out);
void codec_write_goals(const codec_report *report, FILE *out);
void codec_write_plot(const codec_report *report, FILE *out);

#ifdef __cplusplus
}
#endif

#endif
