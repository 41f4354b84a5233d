// Files of the C library on serial ports. The library bypasses our `read` and `write`, so we create such files
// ourselves, with functions that use them.
#include "shim.h"
#include <stdio.h>

#define FILES_MAX 64
static struct own {
    FILE *file;
    int fd;
} files[FILES_MAX];

static ssize_t read_own(void *own, char *data, size_t size) { return read(((struct own *)own)->fd, data, size); }

static ssize_t write_own(void *own, const char *data, size_t size) {
    return write(((struct own *)own)->fd, data, size);
}

static int close_own(void *own) {
    int fd = ((struct own *)own)->fd;
    *(struct own *)own = (struct own){0};
    return close(fd);
}

static FILE *file_of_own(int fd, const char *mode) {
    for (int i = 0; i < FILES_MAX; i++) {
        if (files[i].file) continue;
        files[i].fd = fd;
        files[i].file = fopencookie(&files[i], mode, (cookie_io_functions_t){read_own, write_own, NULL, close_own});
        return files[i].file;
    }
    return errno = EMFILE, NULL;
}

// A standard input that is fed in virtual time is awaited like any other descriptor.
void stdio_talks(void) {
    FILE *own = file_of_own(STDIN_FILENO, "r");
    if (own) stdin = own;
}

EXPORT FILE *fdopen(int fd, const char *mode) {
    if (!serial_of(fd)) return REAL(fdopen)(fd, mode);
    FILE *file = file_of_own(fd, mode);
    // Line-buffered, as on every terminal.
    if (file) setvbuf(file, NULL, _IOLBF, BUFSIZ);
    return file;
}

EXPORT FILE *fopen(const char *restrict path, const char *restrict mode) {
    int shown = is_managed() ? can_open_file(path, O_CLOEXEC) : -1;
    if (shown >= 0) return REAL(fdopen)(shown, "r");
    if (!is_managed() || !serial_real(path)) return REAL(fopen)(path, mode);
    int fd = serial_open(path, 0);
    return fd < 0 ? NULL : fdopen(fd, mode);
}

EXPORT FILE *fopen64(const char *restrict path, const char *restrict mode) { return fopen(path, mode); }

EXPORT int fileno(FILE *file) {
    for (int i = 0; file && i < FILES_MAX; i++)
        if (files[i].file == file) return files[i].fd;
    return REAL(fileno)(file);
}

EXPORT int fclose(FILE *file) {
    int fd = fileno(file);
    // The library's own close bypasses ours.
    if (!serial_of(fd)) descriptor_closed(fd);
    return REAL(fclose)(file);
}
