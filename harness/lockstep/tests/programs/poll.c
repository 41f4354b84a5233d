// A controller in C: a gyro on a serial line, and a base on another, which gets a message every 20 ms.
#include <fcntl.h>
#include <poll.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static int64_t now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static int port(const char *path) {
    int fd = open(path, O_RDWR | O_NOCTTY);
    struct termios settings;
    if (fd < 0 || tcgetattr(fd, &settings)) exit(3);
    cfmakeraw(&settings);
    cfsetspeed(&settings, B115200);
    tcsetattr(fd, TCSANOW, &settings);
    return fd;
}

int main(int count, char **words) {
    if (count < 3) return 2;
    int gyro = port(words[1]), base = port(words[2]);
    int64_t start = now(), due = start + 20000000;
    char line[256];
    size_t length = 0;
    double heading = 0;
    unsigned long samples = 0, told = 0;
    for (;;) {
        int64_t left = due - now();
        struct pollfd fds = {.fd = gyro, .events = POLLIN};
        int ready = poll(&fds, 1, left > 0 ? (int)((left + 999999) / 1000000) : 0);
        if (ready < 0) return 4;
        if (ready > 0) {
            ssize_t some = read(gyro, line + length, sizeof line - 1 - length);
            if (some <= 0) return 5;
            length += (size_t)some;
            line[length] = 0;
            for (char *end; (end = memchr(line, '\n', length));) {
                heading += atof(line) / 100;
                samples++;
                length -= (size_t)(end + 1 - line);
                memmove(line, end + 1, length + 1);
            }
        }
        if (now() >= due) {
            char text[64];
            int size = snprintf(text, sizeof text, "%lu %lu %.4f %lld\n", ++told, samples, heading,
                                (long long)(now() - start));
            if (write(base, text, (size_t)size) != size) return 6;
            due += 20000000;
        }
    }
}
