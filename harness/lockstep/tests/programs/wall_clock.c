// Tells its clocks every 0.1 s, and when three waits until times of the wall clock end.
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

static int port;
static struct timespec start;
static int64_t began;
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;

static int64_t ms(clockid_t clock) {
    struct timespec at;
    clock_gettime(clock, &at);
    return at.tv_sec * 1000LL + at.tv_nsec / 1000000;
}

static void tell(const char *what, int64_t since_ms) {
    char line[64];
    pthread_mutex_lock(&mutex);
    snprintf(line, sizeof line, "%s %lld %lld\n", what, (long long)(ms(CLOCK_MONOTONIC) - began),
             (long long)(ms(CLOCK_REALTIME) - since_ms));
    write(port, line, strlen(line));
    pthread_mutex_unlock(&mutex);
}

static struct timespec in(int seconds) {
    struct timespec at = start;
    at.tv_sec += seconds;
    return at;
}

static void *sleeps(void *wall) {
    struct timespec at = in(3);
    clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, &at, NULL);
    tell("sleep", *(int64_t *)wall);
    return NULL;
}

static void *semaphore(void *wall) {
    sem_t never;
    sem_init(&never, 0, 0);
    struct timespec at = in(4);
    sem_timedwait(&never, &at);
    tell("semaphore", *(int64_t *)wall);
    return NULL;
}

static void *timer(void *wall) {
    int fd = timerfd_create(CLOCK_REALTIME, 0);
    struct itimerspec to = {.it_value = in(5)};
    timerfd_settime(fd, TFD_TIMER_ABSTIME, &to, NULL);
    uint64_t count;
    read(fd, &count, sizeof count);
    tell("timer", *(int64_t *)wall);
    return NULL;
}

int main(int count, char **words) {
    (void)count;
    port = open(words[1], O_RDWR | O_NOCTTY);
    clock_gettime(CLOCK_REALTIME, &start);
    began = ms(CLOCK_MONOTONIC);
    int64_t wall = ms(CLOCK_REALTIME);
    void *(*each[])(void *) = {sleeps, semaphore, timer};
    pthread_t thread;
    for (int i = 0; i < 3; i++) pthread_create(&thread, NULL, each[i], &wall);
    for (;;) {
        usleep(100000);
        tell("tick", wall);
    }
}
