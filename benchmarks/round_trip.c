/* Round trips across a pty or a CAN interface, and the barest echo that answers them.
 *
 *   round_trip echo pty             makes a pty, prints its far side, sends back what comes
 *   round_trip echo can INTERFACE   the same on a CAN interface
 *   round_trip time pty|can COUNT ECHO...
 *       starts ECHO, opens what its first line names, sends COUNT times eight bytes and waits for them;
 *       prints the median and the 90th percentile in nanoseconds, the reading of the clock taken off
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

enum { BYTES = 8, WARM_UP = 200, COUNT_MAX = 1000000, ANSWER_LIMIT_MS = 10000 };

static _Noreturn void fail(const char *what) {
  fprintf(stderr, "round_trip: failed to %s: %s\n", what, strerror(errno));
  exit(1);
}

static void make_raw(int fd) {
  struct termios settings;
  if (tcgetattr(fd, &settings)) fail("look at the tty");
  cfmakeraw(&settings);
  if (tcsetattr(fd, TCSANOW, &settings)) fail("set up the tty");
}

static int can_socket(const char *interface) {
  struct sockaddr_can address = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex(interface)};
  int fd = socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK, CAN_RAW);
  if (fd < 0 || !address.can_ifindex || bind(fd, (struct sockaddr *)&address, sizeof address))
    fail("open the CAN interface");
  return fd;
}

static int tty(const char *path) {
  int fd = open(path, O_RDWR | O_NOCTTY | O_NONBLOCK);
  if (fd < 0) fail("open the pty");
  make_raw(fd);
  return fd;
}

/* Waits for something to read, and reads it. */
static size_t heard(int fd, void *buffer, size_t room, int limit_ms) {
  struct pollfd ready = {.fd = fd, .events = POLLIN};
  int count = poll(&ready, 1, limit_ms);
  if (count == 0) errno = ETIMEDOUT;
  if (count != 1) fail("hear an answer");
  ssize_t length = read(fd, buffer, room);
  if (length < 0) fail("read");
  return (size_t)length;
}

static void say(int fd, const void *bytes, size_t length) {
  if (write(fd, bytes, length) != (ssize_t)length) fail("write");
}

static _Noreturn void echo(int fd) {
  char buffer[256];
  for (;;) say(fd, buffer, heard(fd, buffer, sizeof buffer, -1));
}

static _Noreturn void echo_pty(void) {
  int fd = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
  if (fd < 0 || grantpt(fd) || unlockpt(fd)) fail("make a pty");
  tty(ptsname(fd)); /* held open: the far side stays raw, and its closing is no error */
  puts(ptsname(fd));
  fflush(stdout);
  echo(fd);
}

static _Noreturn void echo_can(const char *interface) {
  int fd = can_socket(interface);
  puts(interface);
  fflush(stdout);
  echo(fd);
}

static int64_t now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * INT64_C(1000000000) + now.tv_nsec;
}

static void one_trip(int fd, int is_can, uint64_t number) {
  struct can_frame frame = {.can_id = 0x123, .len = BYTES};
  memcpy(frame.data, &number, BYTES);
  uint64_t answer = 0;
  if (is_can) {
    say(fd, &frame, sizeof frame);
    if (heard(fd, &frame, sizeof frame, ANSWER_LIMIT_MS) != sizeof frame) fail("hear a whole frame");
    memcpy(&answer, frame.data, BYTES);
  } else {
    say(fd, &number, BYTES);
    for (size_t length = 0; length < BYTES;)
      length += heard(fd, (char *)&answer + length, BYTES - length, ANSWER_LIMIT_MS);
  }
  if (answer != number) {
    errno = EBADMSG;
    fail("hear what was said");
  }
}

static int by_length(const void *left, const void *right) {
  int64_t a = *(const int64_t *)left, b = *(const int64_t *)right;
  return (a > b) - (a < b);
}

static int time_trips(int is_can, size_t count, char **command) {
  int line[2];
  if (pipe(line)) fail("make a pipe");
  pid_t child = fork();
  if (child < 0) fail("fork");
  if (child == 0) {
    dup2(line[1], STDOUT_FILENO);
    close(line[0]);
    close(line[1]);
    execv(command[0], command);
    fail("start the echo");
  }
  close(line[1]);
  char name[256];
  if (!fgets(name, sizeof name, fdopen(line[0], "r"))) fail("learn what the echo has opened");
  name[strcspn(name, "\n")] = 0;
  int fd = is_can ? can_socket(name) : tty(name);

  int64_t *trips = calloc(count, sizeof *trips), *clocks = calloc(count, sizeof *clocks);
  if (!trips || !clocks) fail("find memory");
  for (uint64_t number = 1; number <= WARM_UP; number++) one_trip(fd, is_can, number);
  for (size_t index = 0; index < count; index++) {
    int64_t before = now_ns(), began = now_ns();
    one_trip(fd, is_can, index);
    trips[index] = now_ns() - began;
    clocks[index] = began - before;
  }
  kill(child, SIGTERM);
  waitpid(child, NULL, 0);
  qsort(trips, count, sizeof *trips, by_length);
  qsort(clocks, count, sizeof *clocks, by_length);
  int64_t clock_ns = clocks[count / 2];
  printf("%lld %lld\n", (long long)(trips[count / 2] - clock_ns), (long long)(trips[count * 9 / 10] - clock_ns));
  return 0;
}

int main(int argc, char **argv) {
  if (argc == 3 && !strcmp(argv[1], "echo") && !strcmp(argv[2], "pty")) echo_pty();
  if (argc == 4 && !strcmp(argv[1], "echo") && !strcmp(argv[2], "can")) echo_can(argv[3]);
  if (argc > 4 && !strcmp(argv[1], "time")) {
    int is_can = !strcmp(argv[2], "can");
    size_t count = strtoul(argv[3], NULL, 10);
    if (count > 0 && count <= COUNT_MAX) return time_trips(is_can, count, argv + 4);
  }
  fputs("usage: round_trip echo pty | echo can INTERFACE | time pty|can COUNT ECHO...\n", stderr);
  return 64;
}
