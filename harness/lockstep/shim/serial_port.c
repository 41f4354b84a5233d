// Serial ports under names that are the same in every run. Each is a pty, which keeps the settings, beside a local
// socket, which carries the bytes: a pty passes bytes on through a kernel thread, which would dominate the run time. If
// the settings have a line discipline (echo, lines, line endings), the bytes go through the pty.
#include "shim.h"
#include <linux/serial.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <sys/un.h>
#include <termios.h>

#define PORTS_MAX 32
static struct port {
    char shown[108], real[32];
    // Data bits and parity as the program set them, which a pty drops, and what the harness was told.
    uint32_t dropped;
    bool is_framed;
    int64_t told;
    struct serial_rs485 rs485;
} ports[PORTS_MAX];
static int port_count;

void serial_declare(const char *shown, const char *real) {
    if (port_count >= PORTS_MAX) return;
    snprintf(ports[port_count].shown, sizeof ports[0].shown, "%s", shown);
    snprintf(ports[port_count].real, sizeof ports[0].real, "%s", real);
    port_count++;
}

static int number_of(const char *path) {
    for (int i = 0; path && i < port_count; i++)
        if (!strcmp(path, ports[i].shown)) return i;
    return -1;
}

// The real path of a declared name; NULL for any other path.
const char *serial_real(const char *path) {
    int number = number_of(path);
    return number < 0 ? NULL : ports[number].real;
}

const char *serial_path(int number) { return ports[number].real; }

const char *serial_shown(const char *path) {
    for (int i = 0; path && i < port_count; i++)
        if (!strcmp(path, ports[i].real)) return ports[i].shown;
    return NULL;
}

// A pty passes bytes on in its own time. Polling for bytes waits until it has done so: then epoll also sees what the
// harness wrote.
void serial_flush(void) {
    for (int fd = 0; fd < DESCRIPTORS_MAX; fd++)
        if (serial_of(fd) && serial_of(fd)->is_cooked) is_ready(fd, POLLIN);
}

struct serial *serial_of(int fd) {
    struct descriptor *of = descriptor(fd);
    return of && of->kind == FD_SERIAL ? of->object : NULL;
}

// A socket to the harness for the bytes of a port.
int serial_way(int number) {
    struct sockaddr_un to = {.sun_family = AF_UNIX};
    if (snprintf(to.sun_path, sizeof to.sun_path, "%s%d", link_path(), number) >= (int)sizeof to.sun_path) return -1;
    int fd = REAL(socket)(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd >= 0 && !REAL(connect)(fd, (struct sockaddr *)&to, sizeof to)) return fd;
    if (fd >= 0) REAL(close)(fd);
    return -1;
}

// Opens the port of a declared name.
int serial_open(const char *path, int flags) {
    int number = number_of(path);
    int tty = REAL(openat)(AT_FDCWD, ports[number].real, O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (tty < 0) return -1;
    struct serial *made = calloc(1, sizeof *made);
    int way, fd = serial_connect(number, flags, &way);
    // Writes use a separate socket: the harness takes them at a time that differs between runs, and room that appears
    // then must not show at the program's descriptor (where `epoll` would report it, with EPOLLET).
    int out = serial_way(number);
    if (!made || fd < 0 || out < 0) return errno = EIO, -1;
    shutdown(out, SHUT_RD);
    *made = (struct serial){.number = number, .tty = guard(tty), .way = guard(way), .out = guard(out)};
    made->is_nonblocking = flags & O_NONBLOCK;
    descriptor_set(fd, FD_SERIAL, made);
    link_tell(TELL_OPENED, (uint32_t)number, 0);
    link_tell(TELL_OPENED, (uint32_t)number, 0);
    serial_settled(made);
    return fd;
}

void serial_release(struct serial *serial) {
    if (--serial->users > 0) return;
    unguard(serial->tty);
    unguard(serial->way);
    unguard(serial->out);
    free(serial);
}

// The settings may have changed: from now on the bytes take the path that they require.
void serial_settled(struct serial *serial) {
    struct termios is;
    if (REAL(tcgetattr)(serial->tty, &is)) return;
    serial->bytes_min = is.c_cc[VMIN], serial->tenths = is.c_cc[VTIME];
    serial->has_lines = is.c_lflag & ICANON;
    bool is_cooked = (is.c_lflag & (ICANON | ECHO | ISIG)) || (is.c_oflag & OPOST)
        || (is.c_iflag & (ICRNL | INLCR | IGNCR | ISTRIP | IXON));
    // Errors are marked in the stream, so the harness doubles each byte of all ones.
    bool is_marked = is.c_iflag & PARMRK;
    if (is_cooked == serial->is_cooked && is_marked == serial->is_marked) return;
    serial->is_marked = is_marked;
    link_tell(TELL_COOKED, (uint32_t)serial->number, is_cooked | is_marked << 1);
    if (is_cooked == serial->is_cooked) return;
    serial->is_cooked = is_cooked;
    for (int fd = 0; fd < DESCRIPTORS_MAX; fd++)
        if (serial_of(fd) == serial) serial_redirect(fd, serial);
}

// The kernel's `struct termios2`: its header excludes the C library's. Older structures begin with the same words.
struct settings {
    uint32_t input, output, control, local;
    uint8_t line, characters[19];
    uint32_t input_rate, output_rate;
};
#define GET_SETTINGS _IOR('T', 0x2A, struct settings)
#define SET_SETTINGS _IOW('T', 0x2B, struct settings)
#define SET_SETTINGS_DRAINED _IOW('T', 0x2C, struct settings)
#define SET_SETTINGS_FLUSHED _IOW('T', 0x2D, struct settings)
#define DROPPED (CSIZE | PARENB)

// The program has set its UART: the harness compares that with the line.
void serial_framed(const struct serial *serial, uint32_t control) {
    struct port *port = &ports[serial->number];
    struct settings is;
    if (REAL(ioctl)(serial->tty, GET_SETTINGS, &is)) return;
    port->dropped = control & DROPPED;
    port->is_framed = true;
    uint32_t size = control & CSIZE;
    int64_t bits = size == CS5 ? 5 : size == CS6 ? 6 : size == CS7 ? 7 : 8;
    int64_t parity = !(control & PARENB) ? 0 : control & PARODD ? 1 : 2;
    int64_t framing = is.output_rate | bits << 32 | parity << 36 | (control & CSTOPB ? 2ll : 1ll) << 40;
    if (framing == port->told) return;
    port->told = framing;
    link_tell(TELL_FRAMED, (uint32_t)serial->number, framing);
}

// `c_cflag` of the pty with what it drops, as a UART would keep it.
uint32_t serial_control_bits(const struct serial *serial, uint32_t control) {
    const struct port *port = &ports[serial->number];
    return port->is_framed ? (control & ~DROPPED) | port->dropped : control;
}

void serial_forget_input(const struct serial *serial, int queue) {
    char data[512];
    is_ready(serial->tty, POLLIN);
    while (queue != TCOFLUSH && REAL(recv)(serial->way, data, sizeof data, MSG_DONTWAIT) > 0) {}
}

static int bytes_unsent(const struct serial *serial) {
    int64_t until;
    unsigned count = link_unsent((uint32_t)serial->number, &until);
    if (count) question();
    return count < INT32_MAX ? (int)count : INT32_MAX;
}

// Whether a request waits until all bytes have left. TCSBRK with an argument is what `tcdrain` makes.
static bool is_drained(unsigned long request, const void *argument) {
    return request == TCSETSW || request == TCSETSF || request == SET_SETTINGS_DRAINED
        || request == SET_SETTINGS_FLUSHED || (request == TCSBRK && argument);
}

// As drivers do: what belongs to a mode that is off is forgotten, RTS has one level while sending and another after it, and
// no delay is longer than a tenth of a second. The harness's line needs no driver to be switched.
static void set_rs485(struct port *port, struct serial_rs485 *asked) {
    const uint32_t levels = SER_RS485_RTS_ON_SEND | SER_RS485_RTS_AFTER_SEND;
    struct serial_rs485 kept = {0};
    if (asked->flags & SER_RS485_ENABLED) {
        kept.flags = asked->flags;
        bool is_on = kept.flags & SER_RS485_RTS_ON_SEND, is_after = kept.flags & SER_RS485_RTS_AFTER_SEND;
        if (is_on == is_after) kept.flags = (kept.flags & ~levels) | SER_RS485_RTS_ON_SEND;
        kept.delay_rts_before_send = asked->delay_rts_before_send < 100 ? asked->delay_rts_before_send : 100;
        kept.delay_rts_after_send = asked->delay_rts_after_send < 100 ? asked->delay_rts_after_send : 100;
    }
    *asked = port->rs485 = kept;
}

// Handles an `ioctl` on a serial port; settings and modem lines are the pty's.
int serial_control(int fd, unsigned long request, void *argument) {
    struct serial *serial = serial_of(fd);
    if (is_drained(request, argument)) {
        if (!serial_drain(serial)) return -1;
        // Another thread may have closed it meanwhile.
        if (serial_of(fd) != serial) return errno = EBADF, -1;
    }
    if (request == TCSETSF || request == SET_SETTINGS_FLUSHED) serial_forget_input(serial, TCIFLUSH);
    switch (request) {
    case TIOCOUTQ:
        if (!in_lockstep()) break;
        *(int *)argument = bytes_unsent(serial);
        return 0;
    case TIOCGRS485: *(struct serial_rs485 *)argument = ports[serial->number].rs485; return 0;
    case TIOCSRS485: set_rs485(&ports[serial->number], argument); return 0;
    case FIONBIO: serial->is_nonblocking = *(int *)argument; return 0;
    case FIONREAD: {
        is_ready(fd, POLLIN);
        int answer = REAL(ioctl)(fd, request, argument);
        if (answer == 0 && *(int *)argument == 0) question();
        return answer;
    }
    case TCFLSH: serial_forget_input(serial, (int)(intptr_t)argument); break;
    case FIOCLEX:
    case FIONCLEX: return REAL(ioctl)(fd, request, argument);
    default: break;
    }
    int answer = REAL(ioctl)(serial->tty, request, argument);
    int kept = errno;
    struct settings *settings = argument;
    if (answer == 0) switch (request) {
        case TCGETS:
        case GET_SETTINGS: settings->control = serial_control_bits(serial, settings->control); break;
        case TCSETS:
        case TCSETSW:
        case TCSETSF:
        case SET_SETTINGS:
        case SET_SETTINGS_DRAINED:
        case SET_SETTINGS_FLUSHED: serial_framed(serial, settings->control); break;
        default: break;
        }
    serial_settled(serial);
    errno = kept;
    return answer;
}
