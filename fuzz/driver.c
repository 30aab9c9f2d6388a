/* SPDX-License-Identifier: Apache-2.0 */
/*
 * main() for builds without libFuzzer.
 *
 *     fuzz_open FILE|FOLDER...                              each file once
 *     fuzz_open --mutate COUNT [--seed N] [FILE|FOLDER...]  COUNT mutations of them, always the same ones for a seed;
 *                                                           without files, of an empty input
 *
 * With --mutate, an input that ends the process is written to crash-input first.
 */
#include <dirent.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include "support.h"

enum { LARGEST_INPUT = 1 << 16, MOST_STACKED = 3 };

typedef struct input {
    uint8_t *data;
    size_t size;
} input;

static input *inputs;
static size_t input_count, input_capacity;
static uint8_t current[LARGEST_INPUT]; /* what is being tested, for the handler below */
static size_t current_size;

/* Takes the place of libFuzzer's byte mutations. */
size_t LLVMFuzzerMutate(uint8_t *data, size_t size, size_t max_size) {
    static fuzz_random random = {UINT64_C(0x9E3779B97F4A7C15)};
    size_t at = size > 0 ? fuzz_below(&random, (uint32_t)size) : 0;
    size_t n = 1 + fuzz_below(&random, 8);
    switch (size == 0 ? 3 : fuzz_below(&random, 5)) {
    case 0:
        data[at] ^= (uint8_t)(1u << fuzz_below(&random, 8));
        return size;
    case 1:
        data[at] = (uint8_t)fuzz_next(&random);
        return size;
    case 2: /* cut out */
        n = n < size - at ? n : size - at;
        memmove(data + at, data + at + n, size - at - n);
        return size - n > 0 ? size - n : 1;
    case 3: /* put in */
        if (n > max_size - size)
            return size;
        memmove(data + at + n, data + at, size - at);
        for (size_t i = 0; i < n; i++)
            data[at + i] = (uint8_t)fuzz_next(&random);
        return size + n;
    default: /* copy within */
        n = n < size - at ? n : size - at;
        memmove(data + fuzz_below(&random, (uint32_t)(size - n + 1)), data + at, n);
        return size;
    }
}

static void add_file(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file) {
        fprintf(stderr, "%s: cannot be opened\n", path);
        exit(2);
    }
    input one = {fuzz_malloc(LARGEST_INPUT), 0};
    one.size = fread(one.data, 1, LARGEST_INPUT, file);
    fclose(file);
    if (input_count == input_capacity) {
        input_capacity = input_capacity ? 2 * input_capacity : 256;
        inputs = realloc(inputs, input_capacity * sizeof *inputs);
        REQUIRE(inputs != NULL);
    }
    inputs[input_count++] = one;
}

static int compare_names(const void *a, const void *b) {
    return strcmp(*(char *const *)a, *(char *const *)b);
}

/* The .ztex and .tile files of a folder by name, so that a campaign is the same everywhere. A folder that is not there
 * is empty. */
static void add_folder(const char *path, DIR *folder) {
    char *names[4096], full[4096];
    size_t count = 0;
    for (struct dirent *entry = readdir(folder); entry; entry = readdir(folder)) {
        REQUIRE(count < sizeof names / sizeof *names);
        const char *end = strrchr(entry->d_name, '.');
        if (end && (strcmp(end, ".ztex") == 0 || strcmp(end, ".tile") == 0))
            names[count++] = strdup(entry->d_name);
    }
    qsort(names, count, sizeof *names, compare_names);
    for (size_t i = 0; i < count; i++) {
        snprintf(full, sizeof full, "%s/%s", path, names[i]);
        add_file(full);
        free(names[i]);
    }
}

static void add_path(const char *path) {
    struct stat info;
    if (stat(path, &info) != 0)
        return;
    DIR *folder = S_ISDIR(info.st_mode) ? opendir(path) : NULL;
    if (!folder) {
        add_file(path);
        return;
    }
    add_folder(path, folder);
    closedir(folder);
}

/* Signals of failing requirements and of memory that cannot be accessed, and who handled them before. */
static const int deadly[] = {SIGABRT, SIGSEGV, SIGBUS};
static void (*handled[sizeof deadly / sizeof *deadly])(int);

/* Returning goes on to the handler before, which is the sanitizer's or the end. */
static void on_deadly(int signal_number) {
    FILE *file = fopen("crash-input", "wb");
    if (file) {
        fwrite(current, 1, current_size, file);
        fclose(file);
    }
    for (size_t i = 0; i < sizeof deadly / sizeof *deadly; i++)
        if (deadly[i] == signal_number)
            signal(signal_number, handled[i]);
}

static volatile sig_atomic_t stopped;

static void on_stop(int signal_number) {
    (void)signal_number;
    stopped = 1;
}

/* Returns how many there were: all of them, or fewer when it was told to stop. */
static unsigned long long mutate(unsigned long long count, unsigned long seed) {
    fuzz_random random = {seed * UINT64_C(0x9E3779B97F4A7C15) | 1};
    for (size_t i = 0; i < sizeof deadly / sizeof *deadly; i++)
        handled[i] = signal(deadly[i], on_deadly);
    signal(SIGINT, on_stop);
    signal(SIGTERM, on_stop);
    unsigned long long i = 0;
    for (; i < count && !stopped; i++) {
        current_size = 0;
        if (input_count > 0) {
            const input *from = &inputs[fuzz_below(&random, (uint32_t)input_count)];
            current_size = from->size;
            memcpy(current, from->data, from->size);
        }
        for (uint32_t n = 1 + fuzz_below(&random, MOST_STACKED); n > 0; n--)
            current_size = LLVMFuzzerCustomMutator(current, current_size, sizeof current, (unsigned)fuzz_next(&random));
        LLVMFuzzerTestOneInput(current, current_size);
    }
    return i;
}

#pragma weak LLVMFuzzerInitialize

int main(int argc, char **argv) {
    unsigned long long count = 0;
    unsigned long seed = 0;
    int first = 1;
    for (; first + 1 < argc && strncmp(argv[first], "--", 2) == 0; first += 2) {
        if (strcmp(argv[first], "--mutate") == 0)
            count = strtoull(argv[first + 1], NULL, 10);
        else if (strcmp(argv[first], "--seed") == 0)
            seed = strtoul(argv[first + 1], NULL, 10);
    }
    for (int i = first; i < argc; i++)
        add_path(argv[i]);
    if (LLVMFuzzerInitialize)
        LLVMFuzzerInitialize(&argc, &argv);
    if (input_count == 0 && count == 0) {
        fprintf(stderr, "%s: no inputs\n", argv[0]);
        return 2;
    }
    unsigned long long done = count > 0 ? mutate(count, seed) : input_count;
    for (size_t i = 0; i < input_count; i++) {
        if (count == 0)
            LLVMFuzzerTestOneInput(inputs[i].data, inputs[i].size);
        free(inputs[i].data);
    }
    free(inputs);
    printf("%llu inputs\n", done);
    return 0;
}
