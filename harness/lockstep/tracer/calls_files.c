// Files by name, and descriptors: opened, copied, controlled, closed.
#include "tracer.h"
#include <stdio.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <linux/sockios.h>
#include <termios.h>

static int64_t open_plain(struct tracee *of, uint64_t *a) {
    char path[PATH_MAX];
    return get_text(of, a[0], path, sizeof path) ? line_open(of, path, (int)a[1]) : LET_GO;
}

static int64_t open_at(struct tracee *of, uint64_t *a) { return open_plain(of, a + 1); }

// openat2 has its flags in a structure.
static int64_t open_how(struct tracee *of, uint64_t *a) {
    char path[PATH_MAX];
    uint64_t flags;
    if (!get_text(of, a[1], path, sizeof path) || !get(of, a[2], &flags, sizeof flags)) return LET_GO;
    return line_open(of, path, (int)flags);
}

static int64_t close_one(struct tracee *of, uint64_t *a) {
    unsigned fd = (unsigned)a[0];
    int kept = fd < DESCRIPTORS_MAX ? of->process->slots[fd].kept : 0;
    slot_drop(of->process, fd);
    if (kept <= 0) return LET_GO;
    CALL(of, SYS_close, (uint64_t)kept);
    return CALL(of, SYS_close, fd);
}

static int64_t close_many(struct tracee *of, uint64_t *a) {
    // CLOSE_RANGE_CLOEXEC closes nothing yet.
    if (a[2] & 4) return LET_GO;
    for (uint64_t fd = a[0]; fd <= a[1] && fd < DESCRIPTORS_MAX; fd++) slot_drop(of->process, (unsigned)fd);
    return LET_GO;
}

static int64_t duplicate(struct tracee *of, uint64_t *a) {
    if (!object_of(of, (int)a[0])) return LET_GO;
    int64_t made = CALL(of, SYS_dup, a[0]);
    if (made >= 0) slot_copied(of->process, (int)a[0], (int)made);
    return made;
}

static int64_t duplicate_to(struct tracee *of, uint64_t *a) {
    if (a[0] == a[1]) return LET_GO;
    bool is_object = object_of(of, (int)a[0]);
    slot_drop(of->process, (unsigned)a[1]);
    if (!is_object) return LET_GO;
    int64_t made = CALL(of, SYS_dup2, a[0], a[1]);
    if (made >= 0) slot_copied(of->process, (int)a[0], (int)made);
    return made;
}

static int64_t duplicate_to_with(struct tracee *of, uint64_t *a) {
    bool is_object = object_of(of, (int)a[0]);
    if (a[0] != a[1]) slot_drop(of->process, (unsigned)a[1]);
    if (!is_object) return LET_GO;
    int64_t made = CALL(of, SYS_dup3, a[0], a[1], a[2]);
    if (made >= 0) slot_copied(of->process, (int)a[0], (int)made);
    return made;
}

// A serial line never really blocks; the tracer keeps the blocking mode that the program sees.
static int64_t control(struct tracee *of, uint64_t *a) {
    struct descriptor *found = object_of(of, (int)a[0]);
    if (!found) return LET_GO;
    int command = (int)a[1], copy = ours(of, (int)a[0]);
    struct serial *serial = found->kind == FD_SERIAL ? found->object : NULL;
    if (command == F_DUPFD || command == F_DUPFD_CLOEXEC) {
        int64_t made = CALL(of, SYS_fcntl, a[0], a[1], a[2]);
        if (made >= 0) slot_copied(of->process, (int)a[0], (int)made);
        return made;
    }
    if (!serial || (command != F_GETFL && command != F_SETFL)) return LET_GO;
    if (command == F_SETFL) {
        serial->is_nonblocking = a[2] & O_NONBLOCK;
        return result_of(REAL(fcntl)(copy, F_SETFL, a[2] | O_NONBLOCK));
    }
    int flags = REAL(fcntl)(copy, F_GETFL);
    return serial->is_nonblocking ? flags : flags & ~O_NONBLOCK;
}

// Bytes that requests take and return; requests not listed take a number or nothing.
static const struct {
    unsigned long request;
    size_t takes, gives;
} sizes[] = {
    {TCGETS, 0, 36},  {TCSETS, 36, 0},  {TCSETSW, 36, 0}, {TCSETSF, 36, 0}, {0x802c542a, 0, 44}, {0x402c542b, 44, 0},
    {0x402c542c, 44, 0}, {0x402c542d, 44, 0}, {TIOCMGET, 0, 4}, {TIOCMSET, 4, 0}, {TIOCMBIS, 4, 0}, {TIOCMBIC, 4, 0},
    {FIONREAD, 0, 4}, {TIOCOUTQ, 0, 4}, {FIONBIO, 4, 0},  {TIOCGWINSZ, 0, 8}, {TIOCSWINSZ, 8, 0}, {TIOCGPGRP, 0, 4},
    {TIOCSPGRP, 4, 0}, {TIOCGSERIAL, 0, 72}, {TIOCSSERIAL, 72, 0}, {TIOCGEXCL, 0, 4}, {TIOCGSOFTCAR, 0, 4},
    {TIOCGRS485, 0, 32}, {TIOCSRS485, 32, 32},
};

static int64_t control_serial(struct tracee *of, int copy, uint64_t *a) {
    char data[128] = {0};
    size_t takes = 0, gives = 0;
    bool is_pointer = false;
    unsigned long request = (unsigned)a[1];
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        if (sizes[i].request == request) takes = sizes[i].takes, gives = sizes[i].gives, is_pointer = true;
    if (!get(of, a[2], data, takes)) return -EFAULT;
    // Whether descriptors are inherited is up to the program.
    if (request == FIOCLEX || request == FIONCLEX) return LET_GO;
    int64_t result = result_of(serial_control(copy, request, is_pointer ? data : (void *)a[2]));
    return result >= 0 && !put(of, a[2], data, gives) ? -EFAULT : restarted(of, result);
}

#define IFREQ_BYTES 40
static int64_t control_device(struct tracee *of, uint64_t *a) {
    unsigned long request = (unsigned)a[1];
    struct descriptor *found = object_of(of, (int)a[0]);
    if (found && found->kind == FD_SERIAL) return control_serial(of, ours(of, (int)a[0]), a);
    if (request < SIOCGIFNAME || request > SIOCGIFINDEX) return LET_GO;
    char asked[IFREQ_BYTES];
    int result;
    if (!get(of, a[2], asked, sizeof asked) || !can_interface_ioctl(request, asked, &result)) return LET_GO;
    if (result < 0) return -errno;
    return put(of, a[2], asked, sizeof asked) ? result : -EFAULT;
}

// The file behind a name with a special meaning; NULL for any other name.
static const char *meant(struct tracee *of, uint64_t at) {
    static char path[PATH_MAX];
    if (!get_text(of, at, path, sizeof path)) return NULL;
    const char *real = serial_real(path);
    return real ? real : can_file_like(path);
}

static int seen(struct tracee *of, int64_t fd) {
    struct descriptor *found = object_of(of, fd);
    return found && found->kind == FD_SERIAL ? ((struct serial *)found->object)->tty : -1;
}

static int64_t give_state(struct tracee *of, uint64_t to, int result, const struct stat *state) {
    if (result) return -errno;
    return put(of, to, state, sizeof *state) ? 0 : -EFAULT;
}

static int64_t state_of_fd(struct tracee *of, uint64_t *a) {
    struct stat state;
    int tty = seen(of, (int)a[0]);
    return tty < 0 ? LET_GO : give_state(of, a[1], REAL(fstat)(tty, &state), &state);
}

static int64_t state_of_path(struct tracee *of, uint64_t *a) {
    struct stat state;
    const char *path = meant(of, a[0]);
    return path ? give_state(of, a[1], REAL(stat)(path, &state), &state) : LET_GO;
}

static bool is_empty(struct tracee *of, uint64_t at) {
    char byte;
    return !at || (get(of, at, &byte, 1) && !byte);
}

static int64_t state_at(struct tracee *of, uint64_t *a) {
    if ((a[3] & AT_EMPTY_PATH) && is_empty(of, a[1])) return state_of_fd(of, (uint64_t[]){a[0], a[2]});
    return state_of_path(of, a + 1);
}

static int64_t state_more(struct tracee *of, uint64_t *a) {
    struct statx state;
    bool is_fd = (a[2] & AT_EMPTY_PATH) && is_empty(of, a[1]);
    int tty = is_fd ? seen(of, (int)a[0]) : -1;
    const char *path = is_fd ? NULL : meant(of, a[1]);
    if (tty < 0 && !path) return LET_GO;
    int result = tty >= 0 ? REAL(statx)(tty, "", AT_EMPTY_PATH, (unsigned)a[3], &state)
                          : REAL(statx)(AT_FDCWD, path, 0, (unsigned)a[3], &state);
    if (result) return -errno;
    return put(of, a[4], &state, sizeof state) ? 0 : -EFAULT;
}

// Programs find the name of a terminal by the link of its descriptor in /proc.
static int64_t read_link(struct tracee *of, uint64_t *a) {
    char path[64];
    int fd, length = 0;
    if (!get_text(of, a[0], path, sizeof path)) return LET_GO;
    if (sscanf(path, "/proc/self/fd/%d%n", &fd, &length) != 1) return LET_GO;
    struct descriptor *found = path[length] ? NULL : object_of(of, fd);
    if (!found || found->kind != FD_SERIAL) return LET_GO;
    const char *shown = serial_shown(serial_path(((struct serial *)found->object)->number));
    size_t size = strlen(shown) < a[2] ? strlen(shown) : a[2];
    return put(of, a[1], shown, size) ? (int64_t)size : -EFAULT;
}

static int64_t read_link_at(struct tracee *of, uint64_t *a) { return read_link(of, a + 1); }

static int64_t may_open(struct tracee *of, uint64_t *a) {
    const char *path = meant(of, a[0]);
    return path ? result_of(REAL(access)(path, (int)a[1])) : LET_GO;
}

static int64_t may_open_at(struct tracee *of, uint64_t *a) { return may_open(of, a + 1); }

const struct call calls_of_files[] = {
    {SYS_open, open_plain},     {SYS_openat, open_at},         {437, open_how},
    {SYS_close, close_one},     {436, close_many},             {SYS_dup, duplicate},
    {SYS_dup2, duplicate_to},   {SYS_dup3, duplicate_to_with}, {SYS_fcntl, control},
    {SYS_ioctl, control_device}, {SYS_fstat, state_of_fd},     {SYS_stat, state_of_path},
    {SYS_lstat, state_of_path}, {SYS_newfstatat, state_at},    {SYS_statx, state_more},
    {SYS_readlink, read_link},  {SYS_readlinkat, read_link_at},
    {SYS_access, may_open},     {SYS_faccessat, may_open_at},  {439, may_open_at},
    {0},
};
