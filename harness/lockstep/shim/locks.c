// Mutexes, read-write locks and `pthread_once`: the real ones, tried without blocking.
#include "shim.h"
#include <threads.h>

static enum woken await(const void *address, int64_t deadline) {
    return block(&(struct wait){
        .kind = WAIT_ADDRESS, .giver = THREAD, .deadline = deadline, .address = address, .bitset = UINT32_MAX});
}

// Tries until success or until the deadline.
#define UNTIL_HAD(try_it, address, deadline)                                                       \
    ({                                                                                             \
        int tried_;                                                                                \
        while ((tried_ = (try_it)) == EBUSY)                                                       \
            if (await(address, deadline) == TIMED_OUT) {                                           \
                tried_ = (try_it) == EBUSY ? ETIMEDOUT : 0;                                        \
                break;                                                                             \
            }                                                                                      \
        tried_;                                                                                    \
    })

EXPORT int pthread_mutex_lock(pthread_mutex_t *mutex) {
    if (!in_lockstep()) return REAL(pthread_mutex_lock)(mutex);
    return UNTIL_HAD(REAL(pthread_mutex_trylock)(mutex), mutex, NEVER);
}

EXPORT int pthread_mutex_trylock(pthread_mutex_t *mutex) {
    int result = REAL(pthread_mutex_trylock)(mutex);
    if (result == EBUSY) question();
    return result;
}

EXPORT int pthread_mutex_timedlock(pthread_mutex_t *restrict mutex, const struct timespec *restrict at) {
    if (!in_lockstep()) return REAL(pthread_mutex_timedlock)(mutex, at);
    int64_t deadline = deadline_at(CLOCK_REALTIME, at);
    return UNTIL_HAD(REAL(pthread_mutex_trylock)(mutex), mutex, deadline);
}

EXPORT int pthread_mutex_clocklock(pthread_mutex_t *restrict mutex, clockid_t clock,
                                   const struct timespec *restrict at) {
    if (!in_lockstep()) return pthread_mutex_timedlock(mutex, at);
    int64_t deadline = deadline_at(clock, at);
    return UNTIL_HAD(REAL(pthread_mutex_trylock)(mutex), mutex, deadline);
}

EXPORT int pthread_mutex_unlock(pthread_mutex_t *mutex) {
    int result = REAL(pthread_mutex_unlock)(mutex);
    if (in_lockstep()) wake(mutex, UINT32_MAX, UINT32_MAX);
    return result;
}

EXPORT int pthread_rwlock_rdlock(pthread_rwlock_t *lock) {
    if (!in_lockstep()) return REAL(pthread_rwlock_rdlock)(lock);
    return UNTIL_HAD(REAL(pthread_rwlock_tryrdlock)(lock), lock, NEVER);
}

EXPORT int pthread_rwlock_wrlock(pthread_rwlock_t *lock) {
    if (!in_lockstep()) return REAL(pthread_rwlock_wrlock)(lock);
    return UNTIL_HAD(REAL(pthread_rwlock_trywrlock)(lock), lock, NEVER);
}

EXPORT int pthread_rwlock_timedrdlock(pthread_rwlock_t *restrict lock, const struct timespec *restrict at) {
    if (!in_lockstep()) return REAL(pthread_rwlock_timedrdlock)(lock, at);
    int64_t deadline = deadline_at(CLOCK_REALTIME, at);
    return UNTIL_HAD(REAL(pthread_rwlock_tryrdlock)(lock), lock, deadline);
}

EXPORT int pthread_rwlock_timedwrlock(pthread_rwlock_t *restrict lock, const struct timespec *restrict at) {
    if (!in_lockstep()) return REAL(pthread_rwlock_timedwrlock)(lock, at);
    int64_t deadline = deadline_at(CLOCK_REALTIME, at);
    return UNTIL_HAD(REAL(pthread_rwlock_trywrlock)(lock), lock, deadline);
}

EXPORT int pthread_rwlock_clockrdlock(pthread_rwlock_t *restrict lock, clockid_t clock,
                                      const struct timespec *restrict at) {
    if (!in_lockstep()) return pthread_rwlock_timedrdlock(lock, at);
    int64_t deadline = deadline_at(clock, at);
    return UNTIL_HAD(REAL(pthread_rwlock_tryrdlock)(lock), lock, deadline);
}

EXPORT int pthread_rwlock_clockwrlock(pthread_rwlock_t *restrict lock, clockid_t clock,
                                      const struct timespec *restrict at) {
    if (!in_lockstep()) return pthread_rwlock_timedwrlock(lock, at);
    int64_t deadline = deadline_at(clock, at);
    return UNTIL_HAD(REAL(pthread_rwlock_trywrlock)(lock), lock, deadline);
}

EXPORT int pthread_rwlock_unlock(pthread_rwlock_t *lock) {
    int result = REAL(pthread_rwlock_unlock)(lock);
    if (in_lockstep()) wake(lock, UINT32_MAX, UINT32_MAX);
    return result;
}

// A once function may wait; other callers wait here for its end, not in the C library.
struct once {
    struct once *next;
    pthread_once_t *control;
};
static struct once *under_way;

EXPORT int pthread_once(pthread_once_t *control, void (*body)(void)) {
    if (!in_lockstep()) return REAL(pthread_once)(control, body);
    for (struct once *one = under_way; one;) {
        if (one->control != control) {
            one = one->next;
            continue;
        }
        await(control, NEVER);
        one = under_way;
    }
    struct once mine = {under_way, control};
    under_way = &mine;
    int result = REAL(pthread_once)(control, body);
    struct once **place = &under_way;
    while (*place != &mine) place = &(*place)->next;
    *place = mine.next;
    wake(control, UINT32_MAX, UINT32_MAX);
    return result;
}

static int thrd_result(int result) {
    return result == 0 ? thrd_success : result == EBUSY ? thrd_busy : result == ETIMEDOUT ? thrd_timedout : thrd_error;
}
EXPORT int mtx_lock(mtx_t *mutex) { return thrd_result(pthread_mutex_lock((pthread_mutex_t *)mutex)); }
EXPORT int mtx_trylock(mtx_t *mutex) { return thrd_result(pthread_mutex_trylock((pthread_mutex_t *)mutex)); }
EXPORT int mtx_unlock(mtx_t *mutex) { return thrd_result(pthread_mutex_unlock((pthread_mutex_t *)mutex)); }
EXPORT int mtx_timedlock(mtx_t *restrict mutex, const struct timespec *restrict at) {
    return thrd_result(pthread_mutex_timedlock((pthread_mutex_t *)mutex, at));
}
EXPORT void call_once(once_flag *flag, void (*body)(void)) { pthread_once((pthread_once_t *)flag, body); }
