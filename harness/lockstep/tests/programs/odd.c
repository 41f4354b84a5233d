// Bad behaviour of programs; the first argument selects it.
#define _GNU_SOURCE
#ifndef IS_STATIC
#include <dlfcn.h>
#endif
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static int port;

static int64_t now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

static void tell(const char *what) {
    if (write(port, what, strlen(what)) < 0) exit(9);
}

static void on_signal(int signal) {
    (void)signal;
    tell("signal\n");
}

static void ends(int signal) {
    (void)signal;
    tell("bye\n");
    _exit(0);
}

// Outlives the first thread, and becomes another program.
static void *alone(void *name) {
    sleep(1);
    tell("alone\n");
    execl(name, name, "stdin", NULL);
    return NULL;
}

static pthread_mutex_t one = PTHREAD_MUTEX_INITIALIZER, two = PTHREAD_MUTEX_INITIALIZER;
static sem_t given;

static void *takes_two_first(void *nothing) {
    pthread_mutex_lock(&two);
    usleep(1000);
    pthread_mutex_lock(&one);
    return nothing;
}

static void gives(int signal) {
    (void)signal;
    sem_post(&given);
}

// Ways to wait for something that only the program itself can give.
static void stick(const char *how) {
    pthread_t thread;
    if (!strcmp(how, "stuck on a mutex")) {
        pthread_mutex_lock(&one);
        pthread_mutex_lock(&one);
    }
    if (!strcmp(how, "stuck on two")) {
        pthread_create(&thread, NULL, takes_two_first, NULL);
        pthread_mutex_lock(&one);
        usleep(1000);
        pthread_mutex_lock(&two);
    }
    if (!strcmp(how, "stuck on what has ended")) {
        pthread_create(&thread, NULL, takes_two_first, NULL);
        pthread_detach(thread);
        usleep(1);
        pthread_mutex_lock(&two);
    }
    if (!strcmp(how, "stuck in a child")) {
        if (fork() == 0) stick("stuck on two");
        wait(NULL);
    }
    if (!strcmp(how, "stuck but for SIGTERM")) signal(SIGTERM, gives);
    if (!strcmp(how, "stuck until a timer")) signal(SIGALRM, gives), alarm(2);
    if (!strcmp(how, "stuck beside a pipe") && fork() == 0) pause();
    if (strstr(how, "stuck ")) {
        sem_wait(&given);
        tell("given\n");
    }
}

int main(int count, char **words) {
    const char *how = count > 1 ? words[1] : "";
    if (!strcmp(how, "close")) {
        // As old daemons did, and as new ones do.
        for (int fd = 3; fd < 65536; fd++) close(fd);
        closefrom(3);
        close_range(3, ~0U, 0);
    }
    port = open("/dev/ttyHIL0", O_RDWR | O_NOCTTY);
    if (port < 0) return 8;
    int64_t start = now();
    if (!strcmp(how, "compute"))
        for (volatile unsigned long n = 0;; n++) {}
    if (!strcmp(how, "clock")) {
        while (now() - start < 5000000) {}
        tell("5 ms\n");
    }
    if (!strcmp(how, "look")) {
        char byte;
        fcntl(port, F_SETFL, O_NONBLOCK);
        while (read(port, &byte, 1) < 0 && errno == EAGAIN) {}
        tell("byte\n");
    }
#ifndef IS_STATIC
    if (!strcmp(how, "cut") || !strcmp(how, "cut off")) {
        // Bypasses the shim.
        int (*really_close)(int) = (int (*)(int))dlsym(dlopen("libc.so.6", RTLD_LAZY), "close");
        for (int fd = 3; fd < 65536; fd++) really_close(fd);
        if (!strcmp(how, "cut off"))
            for (volatile unsigned long n = 0;; n++) {}
        sleep(1);
    }
#endif
    if (!strcmp(how, "circle")) {
        int there[2], back[2];
        char byte = 0;
        if (pipe(there) || pipe(back)) return 5;
        bool is_child = fork() == 0;
        int from = is_child ? there[0] : back[0], to = is_child ? back[1] : there[1];
        if (!is_child && write(to, &byte, 1) != 1) return 5;
        while (read(from, &byte, 1) == 1 && write(to, &byte, 1) == 1) {}
    }
    if (!strcmp(how, "daemon")) {
        if (daemon(0, 0)) return 7;
        for (;;) {
            sleep(1);
            tell("daemon\n");
        }
    }
    if (!strcmp(how, "fork"))
        for (;;) fork();
    if (!strcmp(how, "family")) {
        // A child in its own session, and a grandchild that outlives it.
        if (fork() == 0) {
            setsid();
            if (fork() == 0) sleep(1000);
            sleep(500);
            _exit(3);
        }
        int status;
        wait(&status);
        tell(WIFEXITED(status) && WEXITSTATUS(status) == 3 && now() - start == 500000000000 ? "waited\n" : "wrong\n");
        sleep(1000);
    }
    if (!strcmp(how, "child")) {
        signal(SIGCHLD, on_signal);
        if (fork() == 0) {
            usleep(250000);
            _exit(0);
        }
        pause();
        tell(now() - start == 250000000 ? "paused\n" : "wrong\n");
    }
    if (!strcmp(how, "popen")) {
        char text[64] = "";
        FILE *from = popen("echo $((6 * 7))", "r");
        if (!fgets(text, sizeof text, from)) return 6;
        pclose(from);
        if (system("exit 5") != 5 << 8) return 6;
        tell(text);
    }
    if (!strcmp(how, "signal")) {
        signal(SIGALRM, on_signal);
        alarm(2);
        int64_t before = now();
        pause();
        tell(now() - before == 2000000000 ? "paused\n" : "wrong\n");
    }
    // Kills the tracer, which is its parent.
    if (!strcmp(how, "parent")) kill(getppid(), SIGKILL);
    // Lets a debugger that did not start it attach.
    if (!strcmp(how, "debug")) prctl(PR_SET_PTRACER, PR_SET_PTRACER_ANY);
    if (!strcmp(how, "trace")) {
        pid_t child = fork();
        if (child == 0) {
            ptrace(PTRACE_TRACEME, 0, NULL, NULL);
            raise(SIGSTOP);
            _exit(0);
        }
        waitpid(child, NULL, 0);
        sleep(1000);
    }
    if (!strcmp(how, "start") && fork() == 0) {
        execl(words[2], words[2], NULL);
        _exit(9);
    }
    if (!strcmp(how, "alone")) {
        pthread_t thread;
        pthread_create(&thread, NULL, alone, words[0]);
        pthread_exit(NULL);
    }
    if (!strcmp(how, "term")) signal(SIGTERM, ends);
    if (!strcmp(how, "deaf")) signal(SIGTERM, SIG_IGN);
    if (!strcmp(how, "crash")) abort();
    if (!strcmp(how, "stdin")) {
        char text[64];
        while (fgets(text, sizeof text, stdin)) tell(text);
        return 0;
    }
    sleep(1);
    if (!strncmp(how, "stuck ", 6)) stick(how);
    tell("a second\n");
    pause();
}
