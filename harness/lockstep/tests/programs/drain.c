// Writes to a line, and says on another what `TIOCOUTQ`, `tcdrain` and `tcsetattr` make of it.
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/time.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

static int line, say;

static long now(void) {
    struct timespec at;
    clock_gettime(CLOCK_MONOTONIC, &at);
    return (at.tv_sec - 10000) * 1000000000L + at.tv_nsec;
}

static void tell(const char *what, int result) {
    char text[100];
    int unsent = -1;
    ioctl(line, TIOCOUTQ, &unsent);
    int size = snprintf(text, sizeof text, "%s %d at %ld, unsent %d\n", what, result, now(), unsent);
    write(say, text, (size_t)size);
}

static void caught(int signal) { (void)signal; }

static void alarm_after_ms(int ms, int flags) {
    struct sigaction action = {.sa_handler = caught, .sa_flags = flags};
    sigaction(SIGALRM, &action, NULL);
    setitimer(ITIMER_REAL, &(struct itimerval){.it_value = {0, ms * 1000}}, NULL);
}

int main(int count, char **words) {
    line = open(words[1], O_RDWR | O_NOCTTY), say = open(words[2], O_RDWR | O_NOCTTY);
    struct termios settings;
    tcgetattr(line, &settings);
    cfmakeraw(&settings);
    // With lines the bytes go through the pty.
    if (count > 3 && !strcmp(words[3], "cooked")) settings.c_oflag |= OPOST | ONLCR;
    tcsetattr(line, TCSANOW, &settings);
    tell("nothing", tcdrain(line));
    write(line, "12345678", 8);
    tell("written", 0);
    tell("drained", tcdrain(line));
    write(line, "12345678", 8);
    usleep(4500);
    tell("later", 0);
    tell("set", tcsetattr(line, TCSADRAIN, &settings));
    write(line, "1234", 4);
    tell("set at once", tcsetattr(line, TCSANOW, &settings));
    tell("flushed", tcsetattr(line, TCSAFLUSH, &settings));
    write(line, "1234", 4), write(line, "5678", 4);
    tell("request", ioctl(line, TCSBRK, 1));
    write(line, "12345678", 8);
    alarm_after_ms(2, 0);
    int result = tcdrain(line);
    tell(errno == EINTR ? "interrupted" : "whole", result);
    alarm_after_ms(2, SA_RESTART);
    tell("restarted", tcdrain(line));
    if (fork() == 0) {
        // What another process wrote counts.
        write(line, "12345678", 8);
        pause();
    }
    usleep(1000);
    tell("of another", tcdrain(line));
    kill(0, SIGTERM);
}
