// Waiting for a word in memory, for descriptors and for signals, and yielding.
#include "tracer.h"
#include <linux/futex.h>
#include <sys/epoll.h>
#include <sys/select.h>
#include <sys/syscall.h>

#define FUTEX_OPERATION(op) ((op) & ~(FUTEX_PRIVATE_FLAG | FUTEX_CLOCK_REALTIME))

static int64_t await_word(struct tracee *of, uint64_t word, uint32_t value, int64_t deadline, uint32_t bitset) {
    uint32_t is;
    if (!get(of, word, &is, sizeof is)) return -EFAULT;
    if (is != value) {
        question();
        return -EAGAIN;
    }
    switch (block(&(struct wait){.kind = WAIT_ADDRESS,
                                 .giver = THREAD_OR_HANDLER,
                                 .deadline = deadline,
                                 .address = key_of(of->process, word),
                                 .bitset = bitset})) {
    case TIMED_OUT: return -ETIMEDOUT;
    case INTERRUPTED: return deadline == NEVER ? restarted(of, -EINTR) : -EINTR;
    default: return 0;
    }
}

// FUTEX_WAKE_OP: changes the second word, and wakes its waiters if the old value satisfies the comparison.
static int64_t wake_two(struct tracee *of, const uint64_t *a) {
    uint32_t code = (uint32_t)a[5], was, is;
    int32_t argument = (int32_t)(code << 8) >> 20, than = (int32_t)(code << 20) >> 20;
    if (!get(of, a[4], &was, sizeof was)) return -EFAULT;
    if (code >> 28 & FUTEX_OP_OPARG_SHIFT) argument = (int32_t)(1U << (argument & 31));
    switch (code >> 28 & 7) {
    case FUTEX_OP_SET: is = (uint32_t)argument; break;
    case FUTEX_OP_ADD: is = was + (uint32_t)argument; break;
    case FUTEX_OP_OR: is = was | (uint32_t)argument; break;
    case FUTEX_OP_ANDN: is = was & ~(uint32_t)argument; break;
    case FUTEX_OP_XOR: is = was ^ (uint32_t)argument; break;
    default: return -ENOSYS;
    }
    if (!put(of, a[4], &is, sizeof is)) return -EFAULT;
    bool holds;
    switch (code >> 24 & 15) {
    case FUTEX_OP_CMP_EQ: holds = (int32_t)was == than; break;
    case FUTEX_OP_CMP_NE: holds = (int32_t)was != than; break;
    case FUTEX_OP_CMP_LT: holds = (int32_t)was < than; break;
    case FUTEX_OP_CMP_LE: holds = (int32_t)was <= than; break;
    case FUTEX_OP_CMP_GT: holds = (int32_t)was > than; break;
    case FUTEX_OP_CMP_GE: holds = (int32_t)was >= than; break;
    default: return -ENOSYS;
    }
    int64_t woken = wake(key_of(of->process, a[0]), (unsigned)a[2], UINT32_MAX);
    return woken + (holds ? wake(key_of(of->process, a[4]), (unsigned)a[3], UINT32_MAX) : 0);
}

static int64_t futex(struct tracee *of, uint64_t *a) {
    int operation = FUTEX_OPERATION((int)a[1]);
    clockid_t clock = a[1] & FUTEX_CLOCK_REALTIME ? CLOCK_REALTIME : CLOCK_MONOTONIC;
    const void *key = key_of(of->process, a[0]);
    uint32_t value = (uint32_t)a[2], is;
    struct timespec at;
    bool waits = operation == FUTEX_WAIT || operation == FUTEX_WAIT_BITSET;
    if (waits && a[3] && !get(of, a[3], &at, sizeof at)) return -EFAULT;
    switch (operation) {
    case FUTEX_WAIT:
        return await_word(of, a[0], value, a[3] ? deadline_after(nanos(&at)) : NEVER, UINT32_MAX);
    case FUTEX_WAIT_BITSET:
        return await_word(of, a[0], value, a[3] ? deadline_at(clock, &at) : NEVER, (uint32_t)a[5]);
    case FUTEX_WAKE: return wake(key, value, UINT32_MAX);
    case FUTEX_WAKE_BITSET: return wake(key, value, (uint32_t)a[5]);
    case FUTEX_WAKE_OP: return wake_two(of, a);
    case FUTEX_CMP_REQUEUE:
        if (!get(of, a[0], &is, sizeof is)) return -EFAULT;
        if (is != (uint32_t)a[5]) return -EAGAIN;
        __attribute__((fallthrough));
    case FUTEX_REQUEUE: {
        unsigned woken = wake(key, value, UINT32_MAX);
        return woken + requeue(key, key_of(of->process, a[4]), (unsigned)a[3]);
    }
    // Priority-inheriting locks are not supported; programs that try them get an error.
    default: return -ENOSYS;
    }
}

static int64_t yield(struct tracee *of, uint64_t *a) {
    (void)of, (void)a;
    question();
    give_way();
    return 0;
}

static bool take_span(struct tracee *of, uint64_t at, int64_t *deadline) {
    struct timespec span;
    *deadline = NEVER;
    if (!at) return true;
    if (!get(of, at, &span, sizeof span)) return false;
    *deadline = deadline_of(&span);
    return true;
}

// The call's own mask replaces the mask of the thread.
static bool take_mask(struct tracee *of, uint64_t at) {
    if (!at) return true;
    of->is_masked = true;
    return get(of, at, &of->mask, sizeof of->mask);
}

// A signal has come under the call's own mask: the kernel makes the call and delivers the signal under that mask.
static int64_t masked(struct tracee *of, int64_t result, int number, uint64_t *a, int span) {
    if (result != -EINTR || !of->is_masked) return result;
    uint64_t args[6];
    memcpy(args, a, sizeof args);
    if (span >= 0) {
        struct timespec none = {0};
        put(of, of->process->scratch, &none, sizeof none);
        args[span] = number == SYS_epoll_pwait ? 0 : of->process->scratch;
    }
    make_call(of, number, args);
    return KEPT;
}

static int64_t poll_until(struct tracee *of, uint64_t at, uint64_t count, int64_t deadline) {
    if (count > DESCRIPTORS_MAX) return -EINVAL;
    struct pollfd *asked = calloc(2 * count + 1, sizeof *asked), *fds = asked + count;
    int64_t result = asked && get(of, at, asked, count * sizeof *asked) ? 0 : -EFAULT;
    for (uint64_t i = 0; i < count && result == 0; i++) {
        fds[i] = asked[i];
        if (asked[i].fd < 0) continue;
        fds[i].fd = ours(of, asked[i].fd);
        // An unused number: the kernel reports the error.
        if (fds[i].fd < 0) fds[i].fd = INT_MAX;
    }
    if (result == 0) result = result_of(wait_fds(fds, count, deadline));
    for (uint64_t i = 0; i < count && result >= 0; i++) asked[i].revents = asked[i].fd < 0 ? 0 : fds[i].revents;
    if (result >= 0 && !put(of, at, asked, count * sizeof *asked)) result = -EFAULT;
    free(asked);
    return result;
}

static int64_t poll_ms(struct tracee *of, uint64_t *a) { return poll_until(of, a[0], a[1], deadline_ms((int)a[2])); }

static int64_t poll_masked(struct tracee *of, uint64_t *a) {
    int64_t deadline;
    if (!take_span(of, a[2], &deadline) || !take_mask(of, a[3])) return -EFAULT;
    return masked(of, poll_until(of, a[0], a[1], deadline), SYS_ppoll, a, 2);
}

#define SET_WORDS (DESCRIPTORS_MAX / 64)
static int64_t select_until(struct tracee *of, uint64_t *a, int64_t deadline) {
    static const short kinds[3] = {POLLIN, POLLOUT, POLLPRI};
    static const short answers[3] = {POLLIN | POLLHUP | POLLERR, POLLOUT | POLLERR, POLLPRI};
    int count = (int)a[0];
    if (count < 0) return -EINVAL;
    if (count > DESCRIPTORS_MAX) count = DESCRIPTORS_MAX;
    size_t size = ((size_t)count + 63) / 64 * 8;
    uint64_t sets[3][SET_WORDS] = {0};
    struct pollfd *fds = calloc((size_t)count + 1, sizeof *fds);
    int *numbers = calloc((size_t)count + 1, sizeof *numbers);
    nfds_t used = 0;
    int64_t result = fds && numbers ? 0 : -ENOMEM;
    for (int kind = 0; kind < 3 && result == 0; kind++)
        if (a[kind + 1] && !get(of, a[kind + 1], sets[kind], size)) result = -EFAULT;
    for (int fd = 0; fd < count && result == 0; fd++) {
        short events = 0;
        for (int kind = 0; kind < 3; kind++)
            if (sets[kind][fd / 64] >> fd % 64 & 1) events |= kinds[kind];
        if (!events) continue;
        int copy = ours(of, fd);
        if (copy < 0) result = -EBADF;
        fds[used] = (struct pollfd){.fd = copy, .events = events}, numbers[used++] = fd;
    }
    if (result == 0) result = result_of(wait_fds(fds, used, deadline));
    if (result >= 0) {
        result = 0;
        for (int kind = 0; kind < 3; kind++) {
            uint64_t ready[SET_WORDS] = {0};
            for (nfds_t i = 0; i < used; i++) {
                if (!(fds[i].events & kinds[kind]) || !(fds[i].revents & answers[kind])) continue;
                ready[numbers[i] / 64] |= 1ULL << numbers[i] % 64;
                result++;
            }
            if (a[kind + 1]) put(of, a[kind + 1], ready, size);
        }
    }
    free(fds), free(numbers);
    return result;
}

static int64_t select_plain(struct tracee *of, uint64_t *a) {
    struct timeval span;
    int64_t deadline = NEVER;
    if (a[4] && !get(of, a[4], &span, sizeof span)) return -EFAULT;
    if (a[4]) deadline = deadline_after(span.tv_sec * SECOND + span.tv_usec * 1000);
    int64_t result = select_until(of, a, deadline);
    // Linux returns the time left.
    span = timeval_of(deadline > now_ns ? deadline - now_ns : 0);
    if (a[4]) put(of, a[4], &span, sizeof span);
    return result;
}

static int64_t select_masked(struct tracee *of, uint64_t *a) {
    int64_t deadline;
    uint64_t mask[2] = {0};
    if (!take_span(of, a[4], &deadline) || (a[5] && !get(of, a[5], mask, sizeof mask)) || !take_mask(of, mask[0]))
        return -EFAULT;
    int64_t result = masked(of, select_until(of, a, deadline), SYS_pselect6, a, 4);
    struct timespec left = timespec_of(deadline > now_ns ? deadline - now_ns : 0);
    if (a[4] && result != KEPT) put(of, a[4], &left, sizeof left);
    return result;
}

#define EVENTS_MAX 1024
static int64_t epoll_until(struct tracee *of, uint64_t *a, int64_t deadline) {
    int fd = ours(of, (int)a[0]), max = (int)a[2] < EVENTS_MAX ? (int)a[2] : EVENTS_MAX;
    if (fd < 0) return -EBADF;
    if (max <= 0) return -EINVAL;
    for (;;) {
        struct epoll_event events[EVENTS_MAX];
        int count = REAL(epoll_wait)(fd, events, max, 0);
        if (count < 0) return -errno;
        if (count == 0 && deadline <= now_ns) return question(), 0;
        if (count > 0) return put(of, a[1], events, (size_t)count * sizeof *events) ? count : -EFAULT;
        // Another thread may only check for data: taking it would lose it.
        struct pollfd one = {.fd = fd, .events = POLLIN};
        enum woken woken = block(&(struct wait){.kind = WAIT_FDS, .deadline = deadline, .fds = &one, .count = 1});
        if (woken == INTERRUPTED) return -EINTR;
    }
}

static int64_t epoll_plain(struct tracee *of, uint64_t *a) { return epoll_until(of, a, deadline_ms((int)a[3])); }

static int64_t epoll_masked(struct tracee *of, uint64_t *a) {
    if (!take_mask(of, a[4])) return -EFAULT;
    return masked(of, epoll_until(of, a, deadline_ms((int)a[3])), SYS_epoll_pwait, a, 3);
}

static int64_t epoll_masked_ns(struct tracee *of, uint64_t *a) {
    int64_t deadline;
    if (!take_span(of, a[3], &deadline) || !take_mask(of, a[4])) return -EFAULT;
    return masked(of, epoll_until(of, a, deadline), SYS_epoll_pwait2, a, 3);
}

static void await_signal(void) {
    while (block(&(struct wait){.kind = WAIT_TIME, .deadline = NEVER}) != INTERRUPTED) {}
}

static int64_t pause_for_signal(struct tracee *of, uint64_t *a) {
    (void)of, (void)a;
    await_signal();
    return -EINTR;
}

static int64_t suspend(struct tracee *of, uint64_t *a) {
    if (!take_mask(of, a[0])) return -EFAULT;
    await_signal();
    return masked(of, -EINTR, SYS_rt_sigsuspend, a, -1);
}

// Signals taken by a call instead of a handler: the kernel is polled at each turn.
static int64_t take_signal(struct tracee *of, uint64_t *a) {
    int64_t deadline;
    if (!take_span(of, a[2], &deadline)) return -EFAULT;
    struct timespec none = {0};
    put(of, of->process->scratch, &none, sizeof none);
    for (;;) {
        int64_t result = CALL(of, SYS_rt_sigtimedwait, a[0], a[1], of->process->scratch, a[3]);
        if (result != -EAGAIN || deadline <= now_ns) return result;
        enum woken woken = block(&(struct wait){.kind = WAIT_RUN, .deadline = deadline});
        if (woken == INTERRUPTED) return -EINTR;
    }
}

const struct call calls_of_waiting[] = {
    {SYS_futex, futex},
    {SYS_sched_yield, yield},
    {SYS_poll, poll_ms},
    {SYS_ppoll, poll_masked},
    {SYS_select, select_plain},
    {SYS_pselect6, select_masked},
    {SYS_epoll_wait, epoll_plain},
    {SYS_epoll_pwait, epoll_masked},
    {441, epoll_masked_ns},
    {SYS_pause, pause_for_signal},
    {SYS_rt_sigsuspend, suspend},
    {SYS_rt_sigtimedwait, take_signal},
    {0},
};
