/* SPDX-License-Identifier: Apache-2.0 */
/* The ready-made zt_parallel: a pool of POSIX threads. The calling thread works too, as worker 0. */
#include <pthread.h>
#include <stdlib.h>
#include <unistd.h>

#include "base_diag.h"

enum { MAX_THREADS = 256 };

typedef void task_function(void *context, size_t index, unsigned worker);

struct zt_threads {
    pthread_mutex_t gate; /* one run at a time */
    pthread_mutex_t lock; /* guards all below */
    pthread_cond_t wake, done;
    task_function *task;
    void *context;
    size_t next, count; /* indices below next are given out */
    size_t running;     /* threads inside a task */
    uint64_t round;     /* counts runs, so that a sleeping thread knows a new one */
    int quit;
    unsigned worker_count; /* with the calling thread */
    unsigned started;      /* threads that exist */
    struct worker {
        zt_threads *threads;
        pthread_t thread;
        unsigned index;
    } workers[MAX_THREADS];
};

/* Takes indices until none is left. Called and returns with the lock held. */
static void work(zt_threads *threads, unsigned worker) {
    threads->running++;
    while (threads->next < threads->count) {
        size_t index = threads->next++;
        task_function *task = threads->task;
        void *context = threads->context;
        pthread_mutex_unlock(&threads->lock);
        task(context, index, worker);
        pthread_mutex_lock(&threads->lock);
    }
    threads->running--;
}

static void *thread_main(void *argument) {
    const struct worker *self = argument;
    zt_threads *threads = self->threads;
    uint64_t seen = 0;
    pthread_mutex_lock(&threads->lock);
    for (;;) {
        while (!threads->quit && threads->round == seen)
            pthread_cond_wait(&threads->wake, &threads->lock);
        if (threads->quit)
            break;
        seen = threads->round;
        work(threads, self->index);
        if (threads->running == 0)
            pthread_cond_signal(&threads->done);
    }
    pthread_mutex_unlock(&threads->lock);
    return NULL;
}

static void run(void *user, size_t count, task_function *task, void *context) {
    zt_threads *threads = user;
    pthread_mutex_lock(&threads->gate);
    pthread_mutex_lock(&threads->lock);
    threads->task = task;
    threads->context = context;
    threads->next = 0;
    threads->count = count;
    threads->round++;
    pthread_cond_broadcast(&threads->wake);
    work(threads, 0);
    while (threads->running > 0)
        pthread_cond_wait(&threads->done, &threads->lock);
    pthread_mutex_unlock(&threads->lock);
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
    zt_threads *threads = calloc(1, sizeof *threads);
    if (!threads)
        return ZT_NO_MEMORY;
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
    threads->quit = 1;
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
