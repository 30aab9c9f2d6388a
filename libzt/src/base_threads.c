/* SPDX-License-Identifier: Apache-2.0 */
/* The ready-made zt_parallel: a pool of POSIX threads. The calling thread works too, as worker 0. Runs are often
 * shorter than waking a thread takes, so all wait a moment in a loop before they sleep.
 *
 * Each worker begins with a share of neighbouring indices and then helps the others. Neighbours mostly lie together in
 * memory: when indices were given out in turns, lines of one tile row and of the scratch memory went from cache to
 * cache, and each tile took a fifth longer (docs/decode-speed.md). */
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base_diag.h"

/* Spins of 40 ns or so: in all as long as decoding a tile of 256 x 256 texels takes, which is how long threads wait for
 * each other at the end of a run. */
enum { MAX_THREADS = 256, SPINS = 4000, CACHE_LINE = 64 };

typedef void task_function(void *context, size_t index, unsigned worker);

struct worker {
    /* Its share of the indices, on a line of its own. Only `next` changes while others have joined the run. */
    _Alignas(CACHE_LINE) _Atomic size_t next; /* those of the share below it are given out */
    size_t end;
    zt_threads *threads;
    pthread_t thread;
    unsigned index;
};

struct zt_threads {
    pthread_mutex_t gate; /* one run at a time */
    pthread_mutex_t lock; /* for joining a run, and for sleeping */
    pthread_cond_t wake, done;
    /* Those of the run; they only change while no thread has joined it. */
    task_function *task;
    void *context;
    _Atomic size_t joined;  /* threads in the run, but for the calling one */
    _Atomic uint64_t round; /* counts runs, so that a waiting thread knows a new one */
    bool open;              /* may be joined */
    _Atomic bool quit;
    unsigned worker_count; /* with the calling thread */
    unsigned started;      /* threads that exist */
    struct worker workers[MAX_THREADS];
};

static void pause_briefly(void) {
#if defined(__x86_64__) || defined(__i386__)
    __builtin_ia32_pause();
#elif defined(__aarch64__)
    __asm__ volatile("isb");
#endif
}

static void work_on(zt_threads *threads, struct worker *share, unsigned worker) {
    for (;;) {
        size_t index = atomic_fetch_add_explicit(&share->next, 1, memory_order_relaxed);
        if (index >= share->end)
            return;
        threads->task(threads->context, index, worker);
    }
}

/* Takes indices until none is left, first those of its own share. */
static void work(zt_threads *threads, unsigned worker) {
    for (unsigned i = 0; i < threads->worker_count; i++)
        work_on(threads, &threads->workers[(worker + i) % threads->worker_count], worker);
}

static void share_out(zt_threads *threads, size_t count) {
    size_t each = count / threads->worker_count, more = count % threads->worker_count, next = 0;
    for (unsigned i = 0; i < threads->worker_count; i++) {
        struct worker *share = &threads->workers[i];
        atomic_store_explicit(&share->next, next, memory_order_relaxed);
        next += each + (i < more);
        share->end = next;
    }
}

static void leave(zt_threads *threads) {
    if (atomic_fetch_sub(&threads->joined, 1) != 1)
        return;
    pthread_mutex_lock(&threads->lock);
    pthread_cond_signal(&threads->done);
    pthread_mutex_unlock(&threads->lock);
}

/* Waits for a run later than *seen, or the end. */
static void await_round(zt_threads *threads, uint64_t seen) {
    for (int i = 0; i < SPINS && atomic_load(&threads->round) == seen && !atomic_load(&threads->quit); i++)
        pause_briefly();
    pthread_mutex_lock(&threads->lock);
    while (atomic_load(&threads->round) == seen && !atomic_load(&threads->quit))
        pthread_cond_wait(&threads->wake, &threads->lock);
}

static void *thread_main(void *argument) {
    const struct worker *self = argument;
    zt_threads *threads = self->threads;
    uint64_t seen = 0;
    for (;;) {
        await_round(threads, seen);
        bool quit = atomic_load(&threads->quit), join = threads->open && !quit;
        seen = atomic_load(&threads->round);
        if (join)
            atomic_fetch_add(&threads->joined, 1);
        pthread_mutex_unlock(&threads->lock);
        if (quit)
            return NULL;
        if (!join)
            continue;
        work(threads, self->index);
        leave(threads);
    }
}

static void begin_run(zt_threads *threads, size_t count, task_function *task, void *context) {
    pthread_mutex_lock(&threads->lock);
    threads->task = task;
    threads->context = context;
    share_out(threads, count);
    threads->open = true;
    atomic_fetch_add(&threads->round, 1);
    pthread_mutex_unlock(&threads->lock);
    if (count > threads->worker_count)
        pthread_cond_broadcast(&threads->wake);
    for (size_t i = 1; count <= threads->worker_count && i < count; i++)
        pthread_cond_signal(&threads->wake);
}

/* Nobody joins any more; waits for those who have. */
static void end_run(zt_threads *threads) {
    pthread_mutex_lock(&threads->lock);
    threads->open = false;
    pthread_mutex_unlock(&threads->lock);
    for (int i = 0; i < SPINS && atomic_load(&threads->joined) > 0; i++)
        pause_briefly();
    pthread_mutex_lock(&threads->lock);
    while (atomic_load(&threads->joined) > 0)
        pthread_cond_wait(&threads->done, &threads->lock);
    pthread_mutex_unlock(&threads->lock);
}

static void run(void *user, size_t count, task_function *task, void *context) {
    zt_threads *threads = user;
    pthread_mutex_lock(&threads->gate);
    begin_run(threads, count, task, context);
    work(threads, 0);
    end_run(threads);
    pthread_mutex_unlock(&threads->gate);
}

zt_result zt_threads_open(unsigned thread_count, zt_threads **out) {
    if (!out)
        return ZT_BAD_ARGUMENT;
    *out = NULL;
    if (thread_count > MAX_THREADS)
        return ZT_BAD_ARGUMENT;
    if (thread_count == 0) {
        long online = sysconf(_SC_NPROCESSORS_ONLN);
        thread_count = online < 1 ? 1 : online > MAX_THREADS ? MAX_THREADS : (unsigned)online;
    }
    zt_threads *threads = aligned_alloc(CACHE_LINE, sizeof *threads);
    if (!threads)
        return ZT_NO_MEMORY;
    memset(threads, 0, sizeof *threads);
    pthread_mutex_init(&threads->gate, NULL);
    pthread_mutex_init(&threads->lock, NULL);
    pthread_cond_init(&threads->wake, NULL);
    pthread_cond_init(&threads->done, NULL);
    threads->worker_count = thread_count;
    for (unsigned i = 1; i < thread_count; i++) {
        struct worker *worker = &threads->workers[i];
        worker->threads = threads;
        worker->index = i;
        if (pthread_create(&worker->thread, NULL, thread_main, worker) != 0) {
            zt_threads_close(threads);
            return ZT_NO_MEMORY;
        }
        threads->started++;
    }
    *out = threads;
    return ZT_OK;
}

zt_parallel zt_threads_parallel(zt_threads *threads) {
    zt_parallel parallel = {0};
    if (threads) {
        parallel.user = threads;
        parallel.run = run;
        parallel.workers = threads->worker_count;
    }
    return parallel;
}

void zt_threads_close(zt_threads *threads) {
    if (!threads)
        return;
    pthread_mutex_lock(&threads->lock);
    atomic_store(&threads->quit, true);
    pthread_cond_broadcast(&threads->wake);
    pthread_mutex_unlock(&threads->lock);
    for (unsigned i = 1; i <= threads->started; i++)
        pthread_join(threads->workers[i].thread, NULL);
    pthread_cond_destroy(&threads->done);
    pthread_cond_destroy(&threads->wake);
    pthread_mutex_destroy(&threads->lock);
    pthread_mutex_destroy(&threads->gate);
    free(threads);
}
