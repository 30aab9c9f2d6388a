/* SPDX-License-Identifier: Apache-2.0 */
/* Signals, and the line that says how far the work is. */
#include "command_private.h"

#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#define TEMPORARY_SLOTS 16

static volatile sig_atomic_t interrupted;
/* Names that a second signal removes. Each slot is written before its flag is set. */
static char temporary_names[TEMPORARY_SLOTS][1024];
static volatile sig_atomic_t temporary_used[TEMPORARY_SLOTS];
static int line_shown;

static void on_signal(int number) {
    if (!interrupted) {
        interrupted = 1;
        return;
    }
    for (int i = 0; i < TEMPORARY_SLOTS; i++)
        if (temporary_used[i])
            unlink(temporary_names[i]);
    _exit(128 + number);
}

void cmd_signals_install(void) {
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = on_signal;
    sigemptyset(&action.sa_mask);
    /* No SA_RESTART: a read that waits for a pipe shall end. */
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGHUP, &action, NULL);
    /* A closed pipe shall come back as an error, so that temporary files go away. */
    action.sa_handler = SIG_IGN;
    sigaction(SIGPIPE, &action, NULL);
}

int cmd_interrupted(void) {
    return interrupted != 0;
}

int cmd_temporary_register(const char *name) {
    for (int i = 0; i < TEMPORARY_SLOTS; i++)
        if (!temporary_used[i] && strlen(name) < sizeof temporary_names[i]) {
            memcpy(temporary_names[i], name, strlen(name) + 1);
            temporary_used[i] = 1;
            return i;
        }
    return -1;
}

void cmd_temporary_forget(const char *name) {
    for (int i = 0; i < TEMPORARY_SLOTS; i++)
        if (temporary_used[i] && strcmp(temporary_names[i], name) == 0)
            temporary_used[i] = 0;
}

/* ---- progress ------------------------------------------------------------------------------------- */

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

void cmd_progress_clear(void) {
    if (line_shown)
        fputs("\r\033[K", stderr);
    line_shown = 0;
}

void cmd_progress_begin(cmd_progress *progress, const cmd_args *args, const char *label) {
    *progress = (cmd_progress){.label = label, .start = now(), .span = 1.0};
    progress->enabled = !args->quiet && isatty(STDERR_FILENO);
}

void cmd_progress_part(cmd_progress *progress, double from, double to) {
    if (!progress)
        return;
    progress->base = from;
    progress->span = to - from;
}

static void show(cmd_progress *p, double done, double time) {
    char left[32] = "";
    double passed = time - p->start;
    if (done > 0.02) {
        double seconds = passed * (1.0 - done) / done;
        snprintf(left, sizeof left, ", %d:%02d left", (int)(seconds / 60.0), (int)seconds % 60);
    }
    fprintf(stderr, "\r\033[K%s %3.0f %%%s", p->label, 100.0 * done, left);
    fflush(stderr);
    line_shown = 1;
    p->shown = 1;
    p->last_time = time;
}

int cmd_progress_step(void *progress, double done) {
    cmd_progress *p = progress;
    if (p && p->enabled) {
        double time = now();
        /* Short jobs show nothing, and long ones no more than people can read. */
        if (time - p->start > 0.5 && time - p->last_time > 0.1)
            show(p, p->base + p->span * done, time);
    }
    return cmd_interrupted();
}

void cmd_progress_end(cmd_progress *progress) {
    if (progress->shown)
        cmd_progress_clear();
    progress->shown = 0;
}
