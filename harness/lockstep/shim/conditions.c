// Condition variables, semaphores and barriers. The real condition variables and barriers are not used: a waiting
// thread is kept in the schedule.
#include "shim.h"
#include <threads.h>

static int await_condition(pthread_cond_t *condition, pthread_mutex_t *mutex, int64_t deadline) {
    int result = pthread_mutex_unlock(mutex);
    if (result) return result;
    enum woken woken = block(&(struct wait){.kind = WAIT_ADDRESS,
                                            .giver = THREAD_OR_HANDLER,
                                            .deadline = deadline,
                                            .address = condition,
                                            .bitset = UINT32_MAX});
    result = pthread_mutex_lock(mutex);
    return result ? result : woken == TIMED_OUT ? ETIMEDOUT : 0;
}

// A thread outside the schedule can only wait for time.
static int await_outside(pthread_mutex_t *mutex) {
    pthread_mutex_unlock(mutex);
    REAL(usleep)(1000);
    return pthread_mutex_lock(mutex);
}

EXPORT int pthread_cond_wait(pthread_cond_t *restrict condition, pthread_mutex_t *restrict mutex) {
    if (!in_lockstep()) return await_outside(mutex);
    return await_condition(condition, mutex, NEVER);
}

EXPORT int pthread_cond_timedwait(pthread_cond_t *restrict condition, pthread_mutex_t *restrict mutex,
                                  const struct timespec *restrict at) {
    if (!in_lockstep()) return await_outside(mutex);
    return await_condition(condition, mutex, deadline_guessed(at));
}

EXPORT int pthread_cond_clockwait(pthread_cond_t *restrict condition, pthread_mutex_t *restrict mutex, clockid_t clock,
                                  const struct timespec *restrict at) {
    if (!in_lockstep()) return await_outside(mutex);
    return await_condition(condition, mutex, deadline_at(clock, at));
}

EXPORT int pthread_cond_signal(pthread_cond_t *condition) {
    wake(condition, 1, UINT32_MAX);
    return 0;
}

EXPORT int pthread_cond_broadcast(pthread_cond_t *condition) {
    wake(condition, UINT32_MAX, UINT32_MAX);
    return 0;
}

EXPORT int cnd_wait(cnd_t *condition, mtx_t *mutex) {
    return pthread_cond_wait((pthread_cond_t *)condition, (pthread_mutex_t *)mutex) ? thrd_error : thrd_success;
}
EXPORT int cnd_timedwait(cnd_t *restrict condition, mtx_t *restrict mutex, const struct timespec *restrict at) {
    int result = pthread_cond_timedwait((pthread_cond_t *)condition, (pthread_mutex_t *)mutex, at);
    return result == 0 ? thrd_success : result == ETIMEDOUT ? thrd_timedout : thrd_error;
}
EXPORT int cnd_signal(cnd_t *condition) { return pthread_cond_signal((pthread_cond_t *)condition); }
EXPORT int cnd_broadcast(cnd_t *condition) { return pthread_cond_broadcast((pthread_cond_t *)condition); }

static int await_semaphore(sem_t *semaphore, int64_t deadline) {
    for (;;) {
        if (!REAL(sem_trywait)(semaphore)) return 0;
        if (errno != EAGAIN) return -1;
        if (due(deadline) <= now_ns) return errno = ETIMEDOUT, -1;
        enum woken woken = block(&(struct wait){
            .kind = WAIT_SEMAPHORE, .giver = THREAD_OR_HANDLER, .deadline = deadline, .address = semaphore});
        if (woken == INTERRUPTED) return errno = EINTR, -1;
    }
}

EXPORT int sem_wait(sem_t *semaphore) {
    return in_lockstep() ? await_semaphore(semaphore, NEVER) : REAL(sem_wait)(semaphore);
}

EXPORT int sem_trywait(sem_t *semaphore) {
    int result = REAL(sem_trywait)(semaphore);
    if (result) {
        int kept = errno;
        question();
        errno = kept;
    }
    return result;
}

EXPORT int sem_timedwait(sem_t *restrict semaphore, const struct timespec *restrict at) {
    if (!in_lockstep()) return REAL(sem_timedwait)(semaphore, at);
    return await_semaphore(semaphore, deadline_at(CLOCK_REALTIME, at));
}

EXPORT int sem_clockwait(sem_t *restrict semaphore, clockid_t clock, const struct timespec *restrict at) {
    if (!in_lockstep()) return sem_timedwait(semaphore, at);
    return await_semaphore(semaphore, deadline_at(clock, at));
}

// Barriers by address: expected and arrived threads.
#define BARRIERS_MAX 64
static struct barrier {
    pthread_barrier_t *address;
    unsigned wanted, come;
} barriers[BARRIERS_MAX];

static struct barrier *barrier_at(pthread_barrier_t *address) {
    for (int i = 0; i < BARRIERS_MAX; i++)
        if (barriers[i].address == address) return &barriers[i];
    return NULL;
}

EXPORT int pthread_barrier_init(pthread_barrier_t *restrict barrier, const pthread_barrierattr_t *restrict attributes,
                                unsigned count) {
    int result = REAL(pthread_barrier_init)(barrier, attributes, count);
    struct barrier *place = barrier_at(NULL);
    if (!result && is_managed() && place) *place = (struct barrier){barrier, count, 0};
    return result;
}

EXPORT int pthread_barrier_destroy(pthread_barrier_t *barrier) {
    struct barrier *place = barrier_at(barrier);
    if (place) *place = (struct barrier){0};
    return REAL(pthread_barrier_destroy)(barrier);
}

EXPORT int pthread_barrier_wait(pthread_barrier_t *barrier) {
    struct barrier *place = barrier_at(barrier);
    if (!in_lockstep() || !place) return REAL(pthread_barrier_wait)(barrier);
    if (++place->come == place->wanted) {
        place->come = 0;
        wake(barrier, UINT32_MAX, UINT32_MAX);
        return PTHREAD_BARRIER_SERIAL_THREAD;
    }
    struct wait wait = {
        .kind = WAIT_ADDRESS, .giver = THREAD, .deadline = NEVER, .address = barrier, .bitset = UINT32_MAX};
    while (block(&wait) != WOKEN) {}
    return 0;
}
