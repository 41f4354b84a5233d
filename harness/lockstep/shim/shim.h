// Interfaces between the parts of the shim. The shim is preloaded into a program and serves it in the harness's virtual
// time; see docs/virtual-time.md.
#ifndef LOCKSTEP_SHIM_H
#define LOCKSTEP_SHIM_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#undef _FORTIFY_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/can.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#define EXPORT __attribute__((visibility("default")))
#define SECOND 1000000000LL
#define NEVER INT64_MAX

// The function that ours replaces. Looked up once at each place; threads that look it up concurrently find the same.
void *find_next(const char *name);
#define REAL(name)                                                                                 \
    ({                                                                                             \
        static __typeof__(&name) found;                                                            \
        if (!found) found = (__typeof__(&name))find_next(#name);                                   \
        found;                                                                                     \
    })

// link.c: the harness.
struct sent_frame {
    uint32_t interface;
    uint32_t is_local;
    // CANFD_FDF is set in the flags of a CAN FD frame; a classic frame has the same layout.
    struct canfd_frame frame;
};
enum request { REQUEST_FORK = 3, REQUEST_FORKED = 4, REQUEST_EXEC = 5, REQUEST_EXEC_FAILED = 6 };
extern int64_t now_ns;
extern int64_t realtime_base_ns;
extern unsigned spin_questions;
extern int64_t spin_step_ns;
extern bool link_is_busy;
void begin(void);
bool is_managed(void);
// `threads` of them wait for each other, if the program is stuck.
void link_run(int64_t deadline, bool is_stuck, unsigned threads);
bool link_request(enum request what, int64_t argument);
enum tell { TELL_OPENED = 8, TELL_COOKED = 9, TELL_WROTE = 10, TELL_FRAMED = 11 };
void link_tell(enum tell what, uint32_t port, int64_t argument);
void link_send_frame(const struct sent_frame *frame);
void link_after_fork(void);
// What has not yet left a serial port: the number of bytes, and when the last one will have.
unsigned link_unsent(uint32_t port, int64_t *until);
int link_guard(int fd);
const char *link_path(void);

// moments.c
int64_t deadline_after(int64_t span_ns);
int64_t deadline_at(clockid_t clock, const struct timespec *at);
int64_t due(int64_t deadline);
int64_t deadline_guessed(const struct timespec *at);
int64_t nanos(const struct timespec *span);
struct timespec timespec_of(int64_t ns);
struct timeval timeval_of(int64_t ns);
int64_t clock_ns(clockid_t clock);

// turns.c, schedule.c: threads, one of which runs at a time.
enum wait_kind { WAIT_NOTHING, WAIT_TIME, WAIT_FDS, WAIT_ADDRESS, WAIT_SEMAPHORE, WAIT_RUN };
enum woken { WOKEN, TIMED_OUT, INTERRUPTED, RESTART, LOOK_AGAIN };
// Who can end a wait: a handler of a signal is code that runs although all threads wait.
enum giver { ANYONE, THREAD_OR_HANDLER, THREAD, CHILD };
struct wait {
    enum wait_kind kind;
    enum giver giver;
    int64_t deadline;
    const void *address;
    uint32_t bitset;
    struct pollfd *fds;
    nfds_t count;
};
struct thread {
    struct thread *next;
    int go;
    bool woken, finished, detached;
    struct wait wait;
    uint64_t order;
    unsigned run_seen, questions, sendings;
    uint64_t signals;
    enum woken handled;
    pthread_t handle;
    void *(*body)(void *);
    void *argument;
    int destructor_rounds;
};
extern __thread struct thread *self;
extern bool progressed, has_children;
extern struct thread *first, *current;
extern uint64_t orders;
extern unsigned runs;
void run_to_deadline(void);
struct thread *next_thread(void);
bool in_lockstep(void);
enum woken block(const struct wait *wait);
enum woken block_until(int64_t deadline);
unsigned wake(const void *address, unsigned count, uint32_t bitset);
unsigned requeue(const void *from, const void *to, unsigned count);
void question(void);
void sending(void);
void give_way(void);
void schedule_begin(void);
void schedule_after_fork(void);
void schedule_signal(int signal);
struct thread *thread_made(void *(*body)(void *), void *argument);
void thread_unmade(struct thread *thread);
void *thread_entry(void *thread);
struct thread *thread_of(pthread_t handle);
void thread_forget(struct thread *thread);
void futex_wait(int *word, int value);
void futex_wake(int *word);

// stuck.c, and what it needs to know.
bool is_stuck(unsigned *threads);
bool has_handler(const struct thread *thread, int signal);
bool has_other_threads(void);
pid_t process_id_of(const struct thread *thread);
uintptr_t address_of(const struct thread *thread);

// timers.c: callbacks at a time.
struct virtual_timer {
    struct virtual_timer *next;
    int64_t deadline, interval;
    void (*fire)(struct virtual_timer *timer, uint64_t count);
};
void timer_add(struct virtual_timer *timer);
void timer_remove(struct virtual_timer *timer);
void timer_set(struct virtual_timer *timer, int64_t deadline, int64_t interval);
void timers_run(void);
int64_t timers_next(void);
void timer_arm(struct virtual_timer *timer, clockid_t clock, bool is_absolute, const struct itimerspec *to);
struct itimerspec timer_state(const struct virtual_timer *timer);
// A timerfd is an eventfd that is written when it expires: both read alike, and work with poll and epoll.
struct timer_fd {
    struct virtual_timer timer;
    int fd, users;
    clockid_t clock;
};
struct timer_fd *timer_fd_made(int fd, clockid_t clock);
void timer_fd_release(struct timer_fd *of);
void timer_fd_set(struct timer_fd *of, bool is_absolute, const struct itimerspec *to);
void timers_after_fork(void);

// descriptors.c: descriptors with a special meaning.
enum fd_kind { FD_PLAIN, FD_SERIAL, FD_CAN, FD_TIMER, FD_ROUTE };
struct descriptor {
    enum fd_kind kind;
    void *object;
};
#define DESCRIPTORS_MAX 4096
struct descriptor *descriptor(int fd);
void descriptor_set(int fd, enum fd_kind kind, void *object);
void descriptor_closed(int fd);
void descriptor_copied(int from, int to);
bool is_guarded(int fd);
unsigned next_guarded(unsigned from);
int guard(int fd);
void unguard(int fd);

// wait_fds.c: waiting for descriptors.
int wait_fds(struct pollfd *fds, nfds_t count, int64_t deadline);
int wait_fd(int fd, short events, int64_t deadline);
bool is_ready(int fd, short events);
bool is_nonblocking(int fd);
int64_t deadline_of(const struct timespec *span);
int64_t deadline_ms(int ms);
int64_t socket_deadline(int fd, short events);
// A writable pipe accepts this much without blocking.
#define PIPE_PIECE 4096

// serial_port.c, serial.c, serial_calls.c
struct serial {
    int users, number;
    // The pty, which has the settings, and the sockets for received and for sent bytes.
    int tty, way, out;
    bool is_nonblocking, is_cooked, is_marked;
    // VMIN and VTIME, and whether the port reads lines.
    uint8_t bytes_min, tenths;
    bool has_lines;
};
void serial_declare(const char *shown, const char *real);
void serial_flush(void);
int serial_open(const char *path, int flags);
int serial_way(int number);
int serial_connect(int number, int flags, int *way);
void serial_redirect(int fd, const struct serial *serial);
void serial_forget_input(const struct serial *serial, int queue);
void serial_release(struct serial *serial);
void serial_settled(struct serial *serial);
void serial_framed(const struct serial *serial, uint32_t control);
uint32_t serial_control_bits(const struct serial *serial, uint32_t control);
int serial_control(int fd, unsigned long request, void *argument);
struct serial *serial_of(int fd);
const char *serial_real(const char *path);
const char *serial_path(int number);
const char *serial_shown(const char *path);
bool serial_drain(const struct serial *serial);
ssize_t serial_transfer(int fd, struct descriptor *of, const struct iovec *parts, int count, bool is_read);

// stdio.c
void stdio_talks(void);

// static_programs.c: programs that the shim cannot be loaded into.
void tracer_declare(const char *path);
char **as_traced(const char **file, char *const *arguments);

// can_interface.c, can_socket.c, can_message.c, can_bcm.c
void can_declare(const char *name, bool takes_fd);
bool can_takes_fd(int index);
bool can_is_off(int index);
void can_errs(int index, canid_t id);
int can_index(const char *name);
const char *can_name(int index);
int can_interfaces(void);
int can_first(void);
int can_flags(int index);
struct can_socket;
int can_open(int type, int protocol);
void can_deliver(const struct sent_frame *sent, const struct can_socket *from);
void can_after_fork(void);
void can_release(struct can_socket *can);
void can_retain(struct can_socket *can);
ssize_t can_read(int fd, struct descriptor *of, void *data, size_t size);
ssize_t can_write(int fd, struct descriptor *of, const void *data, size_t size);
ssize_t can_receive(int fd, struct descriptor *of, struct msghdr *message, int flags);
ssize_t can_send(int fd, struct descriptor *of, const struct msghdr *message, int flags);
bool can_file_text(const char *path, char text[32]);
int can_open_file(const char *path, int flags);
const char *can_file_like(const char *path);
bool can_interface_ioctl(unsigned long request, void *argument, int *result);

// can_links.c: netlink sockets that list interfaces.
struct route_socket;
bool is_route(int family, int protocol);
void route_open(int fd);
void route_retain(struct route_socket *route);
void route_release(struct route_socket *route);
void route_asks(const struct descriptor *of, const void *data, size_t size);
bool route_answers(const struct descriptor *of);
ssize_t route_receive(int fd, struct descriptor *of, struct msghdr *message, int flags);

#endif
