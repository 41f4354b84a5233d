// Every way to wait, one after the other, with its duration in nanoseconds by the program's own clock.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/select.h>
#include <sys/time.h>
#include <sys/timerfd.h>
#include <termios.h>
#include <threads.h>
#include <time.h>
#include <unistd.h>

static int port;
static int64_t start;
static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
static pthread_rwlock_t lock = PTHREAD_RWLOCK_INITIALIZER;
static pthread_barrier_t barrier;
static sem_t semaphore;
static volatile int alarms;

static int64_t now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static void took(const char *what, long result) {
    int64_t end = now();
    dprintf(port, "%s %ld %lld\n", what, result, (long long)(end - start));
    start = now();
}

static struct timespec in(clockid_t clock, long ns) {
    struct timespec t;
    clock_gettime(clock, &t);
    t.tv_nsec += ns;
    t.tv_sec += t.tv_nsec / 1000000000;
    t.tv_nsec %= 1000000000;
    return t;
}

static void *holder(void *unused) {
    pthread_mutex_lock(&mutex);
    pthread_rwlock_wrlock(&lock);
    pthread_barrier_wait(&barrier);
    usleep(7000);
    pthread_mutex_unlock(&mutex);
    usleep(5000);
    pthread_rwlock_unlock(&lock);
    usleep(3000);
    sem_post(&semaphore);
    usleep(1000);
    return unused;
}

static void on_alarm(int signal) {
    (void)signal;
    alarms++;
}

int main(void) {
    port = open("/dev/ttyHIL0", O_RDWR | O_NOCTTY);
    if (port < 0 || !isatty(port) || strcmp(ttyname(port), "/dev/ttyHIL0")) return 1;
    start = now();
    struct timespec t = {0, 1000001};
    took("nanosleep", nanosleep(&t, NULL));
    t = in(CLOCK_REALTIME, 2000002);
    took("clock_nanosleep", clock_nanosleep(CLOCK_REALTIME, TIMER_ABSTIME, &t, NULL));
    struct timeval tv = {0, 3000};
    took("select", select(0, NULL, NULL, NULL, &tv));
    t = (struct timespec){0, 4000004};
    took("pselect", pselect(0, NULL, NULL, NULL, &t, NULL));
    struct pollfd fds = {.fd = port, .events = POLLIN};
    t = (struct timespec){0, 5000005};
    sigset_t none;
    sigemptyset(&none);
    took("ppoll", ppoll(&fds, 1, &t, &none));
    thrd_sleep(&t, NULL);
    took("thrd_sleep", 0);

    sem_init(&semaphore, 0, 0);
    t = in(CLOCK_REALTIME, 6000006);
    took("sem_timedwait", sem_timedwait(&semaphore, &t));
    pthread_mutex_lock(&mutex);
    t = in(CLOCK_REALTIME, 7000007);
    took("cond_timedwait", pthread_cond_timedwait(&condition, &mutex, &t));
    t = in(CLOCK_MONOTONIC, 8000008);
    took("cond_clockwait", pthread_cond_clockwait(&condition, &mutex, CLOCK_MONOTONIC, &t));
    pthread_mutex_unlock(&mutex);

    pthread_t thread;
    pthread_barrier_init(&barrier, NULL, 2);
    pthread_create(&thread, NULL, holder, NULL);
    pthread_barrier_wait(&barrier);
    t = in(CLOCK_REALTIME, 2000002);
    took("mutex_timedlock", pthread_mutex_timedlock(&mutex, &t));
    took("mutex_lock", pthread_mutex_lock(&mutex));
    took("rwlock_rdlock", pthread_rwlock_rdlock(&lock));
    took("sem_wait", sem_wait(&semaphore));
    took("join", pthread_join(thread, NULL));

    int timer = timerfd_create(CLOCK_MONOTONIC, 0), ep = epoll_create1(0);
    struct itimerspec each = {{0, 9000009}, {0, 9000009}};
    timerfd_settime(timer, 0, &each, NULL);
    struct epoll_event event = {.events = EPOLLIN | EPOLLET};
    epoll_ctl(ep, EPOLL_CTL_ADD, timer, &event);
    took("epoll_wait", epoll_wait(ep, &event, 1, -1));
    uint64_t expired = 0;
    usleep(20000);
    start = now();
    if (read(timer, &expired, sizeof expired) != sizeof expired) return 2;
    took("timerfd", (long)expired);
    if (read(timer, &expired, sizeof expired) != sizeof expired) return 2;
    took("timerfd", (long)expired);
    close(timer);

    signal(SIGALRM, on_alarm);
    struct itimerval every = {{0, 4000}, {0, 4000}};
    setitimer(ITIMER_REAL, &every, NULL);
    long results = 0;
    for (int i = 0; i < 3; i++) results += poll(NULL, 0, 100);
    took("setitimer", results);
    setitimer(ITIMER_REAL, &(struct itimerval){0}, NULL);
    took("alarms", alarms);

    // The line: half a second of silence ends a read, then three bytes at once, and finally whole lines.
    struct termios raw;
    char text[64];
    tcgetattr(port, &raw);
    raw.c_cc[VMIN] = 0, raw.c_cc[VTIME] = 5;
    tcsetattr(port, TCSANOW, &raw);
    took("vtime", read(port, text, sizeof text));
    raw.c_cc[VMIN] = 3, raw.c_cc[VTIME] = 0;
    tcsetattr(port, TCSANOW, &raw);
    took("vmin", read(port, text, sizeof text));
    raw.c_lflag |= ICANON;
    raw.c_iflag |= ICRNL;
    tcsetattr(port, TCSADRAIN, &raw);
    ssize_t size = read(port, text, sizeof text);
    took("canonical", size == 6 && !memcmp(text, "line!\n", 6));
    tcflush(port, TCIFLUSH);
    FILE *file = fdopen(port, "r+");
    took("at the end", fgets(text, sizeof text, file) ? (long)strlen(text) : -1);
    return 0;
}
