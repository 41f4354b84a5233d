// The other ends of the two serial lines of harness/lockstep/tests/programs/poll.c, as the first process of a guest: a gyro that
// says a line every 10 ms, and a base that reads. Ends the guest after as many seconds of its clock as the kernel's
// command line says (`seconds=300`), and says at the start and at the end what its clock shows.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/reboot.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mount.h>
#include <sys/reboot.h>
#include <sys/stat.h>
#include <sys/timerfd.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int line(char *name, size_t size) {
    int fd = posix_openpt(O_RDWR | O_NOCTTY);
    struct termios settings;
    if (fd < 0 || grantpt(fd) || unlockpt(fd) || ptsname_r(fd, name, size) || tcgetattr(fd, &settings)) exit(3);
    cfmakeraw(&settings);
    tcsetattr(fd, TCSANOW, &settings);
    return fd;
}

int main(void) {
    mkdir("/dev", 0755);
    mkdir("/dev/pts", 0755);
    mkdir("/proc", 0755);
    if (mount("devtmpfs", "/dev", "devtmpfs", 0, NULL) && errno != EBUSY) return 1;
    mkdir("/dev/pts", 0755);
    if (mount("devpts", "/dev/pts", "devpts", 0, "ptmxmode=0666")) return 1;
    if (mount("proc", "/proc", "proc", 0, NULL)) return 1;
    int console = open("/dev/console", O_RDWR);
    dup2(console, 1);
    const char *given = getenv("seconds");
    double seconds = given ? atof(given) : 60;

    char gyro_name[64], base_name[64];
    int gyro = line(gyro_name, sizeof gyro_name), base = line(base_name, sizeof base_name);
    if (fork() == 0) {
        execl("/poll", "/poll", gyro_name, base_name, (char *)NULL);
        _exit(9);
    }
    int timer = timerfd_create(CLOCK_MONOTONIC, 0);
    struct itimerspec every = {{0, 10000000}, {0, 10000000}};
    timerfd_settime(timer, 0, &every, NULL);
    double begin = now();
    dprintf(1, "begin %.3f\n", begin);
    unsigned long said = 0, heard = 0;
    while (now() < begin + seconds) {
        struct pollfd fds[] = {{.fd = timer, .events = POLLIN}, {.fd = base, .events = POLLIN}};
        if (poll(fds, 2, -1) < 0) return 4;
        if (fds[0].revents & POLLIN) {
            unsigned long long ticks;
            if (read(timer, &ticks, sizeof ticks) < 0) return 5;
            for (; ticks > 0; ticks--) dprintf(gyro, "%.4f\n", (double)(++said * 7919 % 1000) / 1000);
        }
        if (fds[1].revents & POLLIN) {
            char text[256];
            ssize_t size = read(base, text, sizeof text);
            for (ssize_t at = 0; at < size; at++) heard += text[at] == '\n';
        }
    }
    dprintf(1, "end %.3f: %lu samples said, %lu commands heard\n", now(), said, heard);
    reboot(LINUX_REBOOT_CMD_RESTART);
    return 0;
}
