// Threads join the schedule when they are made and leave it after their last destructor.
#include "shim.h"
#include <stdio.h>
#include <threads.h>

EXPORT int pthread_create(pthread_t *handle, const pthread_attr_t *attributes, void *(*body)(void *), void *argument) {
    if (!in_lockstep()) return REAL(pthread_create)(handle, attributes, body, argument);
    struct thread *made = thread_made(body, argument);
    if (!made) return EAGAIN;
    int state = PTHREAD_CREATE_JOINABLE;
    if (attributes) pthread_attr_getdetachstate(attributes, &state);
    made->detached = state == PTHREAD_CREATE_DETACHED;
    int result = REAL(pthread_create)(handle, attributes, thread_entry, made);
    if (result) thread_unmade(made);
    else made->handle = *handle;
    return result;
}

// Zero when it has ended; then the real join does not wait for long.
static int await_end(pthread_t handle, int64_t deadline) {
    struct thread *thread = thread_of(handle);
    if (!thread || thread == self) return 0;
    while (!thread->finished) {
        enum woken woken = block(&(struct wait){
            .kind = WAIT_ADDRESS, .giver = THREAD, .deadline = deadline, .address = thread, .bitset = UINT32_MAX});
        if (woken == TIMED_OUT) return ETIMEDOUT;
    }
    thread_forget(thread);
    return 0;
}

EXPORT int pthread_join(pthread_t handle, void **result) {
    if (in_lockstep()) await_end(handle, NEVER);
    return REAL(pthread_join)(handle, result);
}

EXPORT int pthread_timedjoin_np(pthread_t handle, void **result, const struct timespec *at) {
    if (!in_lockstep()) return REAL(pthread_timedjoin_np)(handle, result, at);
    int ended = await_end(handle, deadline_at(CLOCK_REALTIME, at));
    return ended ? ended : REAL(pthread_join)(handle, result);
}

EXPORT int pthread_clockjoin_np(pthread_t handle, void **result, clockid_t clock, const struct timespec *at) {
    if (!in_lockstep()) return pthread_timedjoin_np(handle, result, at);
    int ended = await_end(handle, deadline_at(clock, at));
    return ended ? ended : REAL(pthread_join)(handle, result);
}

EXPORT int pthread_tryjoin_np(pthread_t handle, void **result) {
    if (!in_lockstep()) return REAL(pthread_tryjoin_np)(handle, result);
    struct thread *thread = thread_of(handle);
    question();
    if (thread && !thread->finished) return EBUSY;
    return pthread_join(handle, result);
}

EXPORT int pthread_detach(pthread_t handle) {
    if (in_lockstep()) {
        struct thread *thread = thread_of(handle);
        if (thread && thread->finished) thread_forget(thread);
        else if (thread) thread->detached = true;
    }
    return REAL(pthread_detach)(handle);
}

// C11 threads, through those of POSIX: the C library creates them without calling `pthread_create`.
struct start {
    thrd_start_t body;
    void *argument;
};

static void *run_thrd(void *made) {
    struct start start = *(struct start *)made;
    free(made);
    return (void *)(intptr_t)start.body(start.argument);
}

EXPORT int thrd_create(thrd_t *handle, thrd_start_t body, void *argument) {
    if (!in_lockstep()) return REAL(thrd_create)(handle, body, argument);
    struct start *start = malloc(sizeof *start);
    if (!start) return thrd_nomem;
    *start = (struct start){body, argument};
    if (!pthread_create((pthread_t *)handle, NULL, run_thrd, start)) return thrd_success;
    free(start);
    return thrd_error;
}

EXPORT int thrd_join(thrd_t handle, int *result) {
    if (!in_lockstep()) return REAL(thrd_join)(handle, result);
    void *value;
    if (pthread_join((pthread_t)handle, &value)) return thrd_error;
    if (result) *result = (int)(intptr_t)value;
    return thrd_success;
}

EXPORT int thrd_detach(thrd_t handle) { return pthread_detach((pthread_t)handle) ? thrd_error : thrd_success; }
