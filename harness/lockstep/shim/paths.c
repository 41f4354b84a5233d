// The names of serial ports, wherever a program may ask for a file by name.
#include "shim.h"
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <sys/stat.h>

// Ports of other processes that this one inherits (a shell's redirections) are known by their names.
static int opened(const char *real, int fd, int flags) {
    if (fd < 0) return fd;
    descriptor_closed(fd);
    if (real) serial_opened(fd, flags & O_NONBLOCK);
    return fd;
}

static int open_at(int folder, const char *path, int flags, mode_t mode) {
    const char *real = is_managed() ? serial_real(path) : NULL;
    if (real) return opened(real, REAL(openat)(AT_FDCWD, real, flags | O_NONBLOCK | O_NOCTTY, mode), flags);
    return opened(NULL, REAL(openat)(folder, path, flags, mode), flags);
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
EXPORT int open64(const char *path, int flags, ...) {
    MODE_ARGUMENT(flags, mode)
    return open_at(AT_FDCWD, path, flags, mode);
}
EXPORT int openat(int folder, const char *path, int flags, ...) {
    MODE_ARGUMENT(flags, mode)
    return open_at(folder, path, flags, mode);
}
EXPORT int openat64(int folder, const char *path, int flags, ...) {
    MODE_ARGUMENT(flags, mode)
    return open_at(folder, path, flags, mode);
}
EXPORT int __open_2(const char *path, int flags) { return open_at(AT_FDCWD, path, flags, 0); }
EXPORT int __open64_2(const char *path, int flags) { return open_at(AT_FDCWD, path, flags, 0); }
EXPORT int __openat_2(int folder, const char *path, int flags) { return open_at(folder, path, flags, 0); }
EXPORT int __openat64_2(int folder, const char *path, int flags) { return open_at(folder, path, flags, 0); }

static const char *meant(const char *path) {
    const char *real = is_managed() ? serial_real(path) : NULL;
    return real ? real : path;
}

EXPORT FILE *fopen(const char *restrict path, const char *restrict mode) {
    return REAL(fopen)(meant(path), mode);
}
EXPORT FILE *fopen64(const char *restrict path, const char *restrict mode) {
    return REAL(fopen64)(meant(path), mode);
}

EXPORT int stat(const char *restrict path, struct stat *restrict state) { return REAL(stat)(meant(path), state); }
EXPORT int lstat(const char *restrict path, struct stat *restrict state) { return REAL(lstat)(meant(path), state); }
EXPORT int stat64(const char *restrict path, struct stat64 *restrict state) {
    return REAL(stat64)(meant(path), state);
}
EXPORT int lstat64(const char *restrict path, struct stat64 *restrict state) {
    return REAL(lstat64)(meant(path), state);
}
EXPORT int fstatat(int folder, const char *restrict path, struct stat *restrict state, int flags) {
    return REAL(fstatat)(folder, meant(path), state, flags);
}
EXPORT int fstatat64(int folder, const char *restrict path, struct stat64 *restrict state, int flags) {
    return REAL(fstatat64)(folder, meant(path), state, flags);
}
EXPORT int statx(int folder, const char *restrict path, int flags, unsigned mask, struct statx *restrict state) {
    return REAL(statx)(folder, meant(path), flags, mask, state);
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

EXPORT int ttyname_r(int fd, char *name, size_t size) {
    int result = REAL(ttyname_r)(fd, name, size);
    const char *shown = result == 0 ? serial_shown(name) : NULL;
    if (!shown) return result;
    if (strlen(shown) >= size) return ERANGE;
    strcpy(name, shown);
    return 0;
}
EXPORT char *ttyname(int fd) {
    static char name[PATH_MAX];
    int result = ttyname_r(fd, name, sizeof name);
    return result ? errno = result, NULL : name;
}
