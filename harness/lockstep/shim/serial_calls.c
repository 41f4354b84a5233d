// Descriptors of serial ports, and the C library's terminal calls.
#include "shim.h"
#include <termios.h>

// The program's descriptor for a port, and the socket behind it, which stays open.
int serial_connect(int number, int flags, int *way) {
    *way = serial_way(number);
    return *way < 0 ? -1 : REAL(fcntl)(*way, flags & O_CLOEXEC ? F_DUPFD_CLOEXEC : F_DUPFD, 0);
}

// Redirects the bytes of a descriptor to the pty, or back to the socket.
void serial_redirect(int fd, const struct serial *serial) {
    int closes = REAL(fcntl)(fd, F_GETFD) & FD_CLOEXEC;
    REAL(dup3)(serial->is_cooked ? serial->tty : serial->way, fd, closes ? O_CLOEXEC : 0);
}

static int tty_of(int fd) {
    struct serial *serial = serial_of(fd);
    return serial ? serial->tty : fd;
}

EXPORT int isatty(int fd) { return REAL(isatty)(tty_of(fd)); }
EXPORT int tcgetattr(int fd, struct termios *settings) {
    struct serial *serial = serial_of(fd);
    int result = REAL(tcgetattr)(tty_of(fd), settings);
    if (serial && result == 0) settings->c_cflag = serial_control_bits(serial, settings->c_cflag);
    return result;
}
EXPORT int tcsetattr(int fd, int actions, const struct termios *settings) {
    struct serial *serial = serial_of(fd);
    if (!serial) return REAL(tcsetattr)(fd, actions, settings);
    if (actions != TCSANOW && !serial_drain(serial)) return -1;
    // Another thread may have closed it meanwhile.
    if (serial_of(fd) != serial) return errno = EBADF, -1;
    if (actions == TCSAFLUSH) serial_forget_input(serial, TCIFLUSH);
    // The C library finds that a pty drops some bits, and calls that an error; a UART keeps them.
    struct termios of_pty = *settings;
    of_pty.c_cflag = (of_pty.c_cflag & ~(CSIZE | PARENB)) | CS8 | CREAD;
    int result = REAL(tcsetattr)(serial->tty, actions, &of_pty);
    if (result == 0) serial_framed(serial, settings->c_cflag), serial_settled(serial);
    return result;
}
EXPORT int tcflush(int fd, int queue) {
    if (serial_of(fd)) serial_forget_input(serial_of(fd), queue);
    return REAL(tcflush)(tty_of(fd), queue);
}
EXPORT int tcdrain(int fd) {
    struct serial *serial = serial_of(fd);
    if (!serial) return REAL(tcdrain)(fd);
    return serial_drain(serial) ? 0 : -1;
}
EXPORT int tcflow(int fd, int action) { return REAL(tcflow)(tty_of(fd), action); }
EXPORT int tcsendbreak(int fd, int duration) { return REAL(tcsendbreak)(tty_of(fd), duration); }

EXPORT int ttyname_r(int fd, char *name, size_t size) {
    int result = REAL(ttyname_r)(tty_of(fd), name, size);
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
