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

// The calls that wait for a lock: without a limit, until a time of day, and until a time of a clock.
#define CALLS_THAT_LOCK(type, to_try, to_lock, to_lock_timed, to_lock_clocked)                                          \
    EXPORT int to_lock(type *lock) {                                                                                   \
        if (!in_lockstep()) return REAL(to_lock)(lock);                                                                \
        return UNTIL_HAD(REAL(to_try)(lock), lock, NEVER);                                                             \
    }                                                                                                                  \
    EXPORT int to_lock_timed(type *restrict lock, const struct timespec *restrict at) {                                \
        if (!in_lockstep()) return REAL(to_lock_timed)(lock, at);                                                      \
        int64_t deadline = deadline_at(CLOCK_REALTIME, at);                                                            \
        return UNTIL_HAD(REAL(to_try)(lock), lock, deadline);                                                          \
    }                                                                                                                  \
    EXPORT int to_lock_clocked(type *restrict lock, clockid_t clock, const struct timespec *restrict at) {             \
        if (!in_lockstep()) return to_lock_timed(lock, at);                                                            \
        int64_t deadline = deadline_at(clock, at);                                                                     \
        return UNTIL_HAD(REAL(to_try)(lock), lock, deadline);                                                          \
    }

CALLS_THAT_LOCK(pthread_mutex_t, pthread_mutex_trylock, pthread_mutex_lock, pthread_mutex_timedlock,
                pthread_mutex_clocklock)
CALLS_THAT_LOCK(pthread_rwlock_t, pthread_rwlock_tryrdlock, pthread_rwlock_rdlock, pthread_rwlock_timedrdlock,
                pthread_rwlock_clockrdlock)
CALLS_THAT_LOCK(pthread_rwlock_t, pthread_rwlock_trywrlock, pthread_rwlock_wrlock, pthread_rwlock_timedwrlock,
                pthread_rwlock_clockwrlock)

EXPORT int pthread_mutex_trylock(pthread_mutex_t *mutex) {
    int result = REAL(pthread_mutex_trylock)(mutex);
    if (result == EBUSY) question();
    return result;
}

EXPORT int pthread_mutex_unlock(pthread_mutex_t *mutex) {
    int result = REAL(pthread_mutex_unlock)(mutex);
    if (in_lockstep()) wake(mutex, UINT32_MAX, UINT32_MAX);
    return result;
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
