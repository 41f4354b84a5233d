// Intercepts the names of serial ports and CAN interfaces in all calls that take a file name.
#include "shim.h"
#include <stdarg.h>
#include <sys/mman.h>
#include <sys/stat.h>

// Opens a file of /sys about one of our interfaces; negative for any other file.
int can_open_file(const char *path, int flags) {
    char text[32];
    if (!can_file_text(path, text)) return -1;
    int fd = memfd_create("interface", flags & O_CLOEXEC ? MFD_CLOEXEC : 0);
    if (fd < 0) return fd;
    REAL(write)(fd, text, strlen(text));
    lseek(fd, 0, SEEK_SET);
    descriptor_closed(fd);
    return fd;
}

static int open_at(int folder, const char *path, int flags, mode_t mode) {
    if (is_managed() && serial_real(path)) return serial_open(path, flags);
    int shown = is_managed() ? can_open_file(path, flags) : -1;
    if (shown >= 0) return shown;
    int fd = REAL(openat)(folder, path, flags, mode);
    if (fd >= 0) descriptor_closed(fd);
    return fd;
}

#define MODE_ARGUMENT(flags, mode)                                                                 \
    mode_t mode = 0;                                                                               \
    if (__OPEN_NEEDS_MODE(flags)) {                                                                \
        va_list rest;                                                                              \
        va_start(rest, flags);                                                                     \
        mode = va_arg(rest, mode_t);                                                               \
        va_end(rest);                                                                              \
    }
#ifndef __OPEN_NEEDS_MODE
#define __OPEN_NEEDS_MODE(flags) ((flags) & (O_CREAT | O_TMPFILE))
#endif

EXPORT int open(const char *path, int flags, ...) {
    MODE_ARGUMENT(flags, mode)
    return open_at(AT_FDCWD, path, flags, mode);
}
EXPORT int open64(const char *path, int flags, ...) __attribute__((alias("open")));
EXPORT int openat(int folder, const char *path, int flags, ...) {
    MODE_ARGUMENT(flags, mode)
    return open_at(folder, path, flags, mode);
}
EXPORT int openat64(int folder, const char *path, int flags, ...) __attribute__((alias("openat")));
EXPORT int __open_2(const char *path, int flags) { return open_at(AT_FDCWD, path, flags, 0); }
EXPORT int __open64_2(const char *path, int flags) { return open_at(AT_FDCWD, path, flags, 0); }
EXPORT int __openat_2(int folder, const char *path, int flags) { return open_at(folder, path, flags, 0); }
EXPORT int __openat64_2(int folder, const char *path, int flags) { return open_at(folder, path, flags, 0); }

static const char *meant(const char *path) {
    const char *real = is_managed() ? serial_real(path) : NULL;
    if (is_managed() && !real) real = can_file_like(path);
    return real ? real : path;
}

EXPORT int stat(const char *restrict path, struct stat *restrict state) { return REAL(stat)(meant(path), state); }
EXPORT int lstat(const char *restrict path, struct stat *restrict state) { return REAL(lstat)(meant(path), state); }
EXPORT int stat64(const char *restrict path, struct stat64 *restrict state) {
    return REAL(stat64)(meant(path), state);
}
EXPORT int lstat64(const char *restrict path, struct stat64 *restrict state) {
    return REAL(lstat64)(meant(path), state);
}
// An empty path means the descriptor itself: a port is represented by its pty.
static int seen(int fd) { return serial_of(fd) ? serial_of(fd)->tty : fd; }

EXPORT int fstat(int fd, struct stat *state) { return REAL(fstat)(seen(fd), state); }
EXPORT int fstat64(int fd, struct stat64 *state) { return REAL(fstat64)(seen(fd), state); }
EXPORT int fstatat(int folder, const char *restrict path, struct stat *restrict state, int flags) {
    return REAL(fstatat)(seen(folder), meant(path), state, flags);
}
EXPORT int fstatat64(int folder, const char *restrict path, struct stat64 *restrict state, int flags) {
    return REAL(fstatat64)(seen(folder), meant(path), state, flags);
}
EXPORT int statx(int folder, const char *restrict path, int flags, unsigned mask, struct statx *restrict state) {
    return REAL(statx)(seen(folder), meant(path), flags, mask, state);
}

EXPORT int access(const char *path, int mode) { return REAL(access)(meant(path), mode); }
EXPORT int euidaccess(const char *path, int mode) { return REAL(euidaccess)(meant(path), mode); }
EXPORT int faccessat(int folder, const char *path, int mode, int flags) {
    return REAL(faccessat)(folder, meant(path), mode, flags);
}

EXPORT char *realpath(const char *restrict path, char *restrict resolved) {
    if (!is_managed() || !serial_real(path)) return REAL(realpath)(path, resolved);
    return resolved ? strcpy(resolved, path) : strdup(path);
}
EXPORT char *__realpath_chk(const char *path, char *resolved, size_t size) {
    (void)size;
    return realpath(path, resolved);
}
EXPORT char *canonicalize_file_name(const char *path) { return realpath(path, NULL); }
