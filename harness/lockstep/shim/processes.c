// Processes that the program starts: each joins the lockstep with its own link, and waits for its turn. A program that
// replaces itself keeps the shim in its environment.
#include "shim.h"
#include <spawn.h>
#include <stdarg.h>
#include <stdio.h>
#include <sys/wait.h>

extern char **environ;

EXPORT pid_t fork(void) {
    if (!in_lockstep()) return REAL(fork)();
    if (!link_request(REQUEST_FORK, 0)) return errno = EAGAIN, -1;
    progressed = has_children = true;
    pid_t made = REAL(fork)();
    if (made == 0) {
        schedule_after_fork();
        timers_after_fork();
        link_after_fork();
        return 0;
    }
    int kept = errno;
    link_request(REQUEST_FORKED, made);
    errno = kept;
    return made;
}

// The child of a vfork may only replace itself or end, which also works with its own memory.
EXPORT pid_t vfork(void) { return fork(); }
EXPORT pid_t _Fork(void) { return fork(); }

EXPORT int daemon(int keep_folder, int keep_files) {
    pid_t made = fork();
    if (made < 0) return -1;
    if (made > 0) _exit(0);
    if (setsid() < 0) return -1;
    if (!keep_folder && chdir("/")) return -1;
    int null = keep_files ? -1 : open("/dev/null", O_RDWR);
    if (null < 0) return keep_files ? 0 : -1;
    for (int fd = 0; fd < 3; fd++) dup2(null, fd);
    if (null > 2) close(null);
    return 0;
}

// The environment with the shim, or without it for the tracer, in one block that the caller frees; the environment
// itself if nothing changes.
static char **with_shim(char *const *environment, bool is_traced, char **made) {
    *made = NULL;
    const char *preload = getenv("LD_PRELOAD");
    size_t count = 0;
    bool has_preload = false, has_link = false;
    for (; environment && environment[count]; count++) {
        has_preload |= !strncmp(environment[count], "LD_PRELOAD=", 11);
        has_link |= !strncmp(environment[count], "HIL_LOCKSTEP=", 13);
    }
    if ((has_preload != is_traced && has_link) || !preload) return (char **)environment;
    size_t texts = strlen(preload) + strlen(link_path()) + 32;
    char **copy = malloc((count + 3) * sizeof *copy + texts);
    if (!copy) return (char **)environment;
    *made = (char *)copy;
    char *text = (char *)(copy + count + 3);
    size_t kept = 0;
    for (size_t i = 0; i < count; i++)
        if (strncmp(environment[i], "LD_PRELOAD=", 11) && strncmp(environment[i], "HIL_LOCKSTEP=", 13))
            copy[kept++] = environment[i];
    if (!is_traced) copy[kept++] = text;
    if (!is_traced) text += sprintf(text, "LD_PRELOAD=%s", preload) + 1;
    copy[kept++] = text;
    sprintf(text, "HIL_LOCKSTEP=%s", link_path());
    copy[kept] = NULL;
    return copy;
}

#define REPLACE(path, call)                                                                        \
    ({                                                                                             \
        char *made_, **traced_ = as_traced(&path, arguments);                                      \
        char **words = traced_ ? traced_ : (char **)arguments;                                     \
        char **shimmed = with_shim(environment, traced_, &made_);                                  \
        link_request(REQUEST_EXEC, 0);                                                             \
        int result_ = (call), kept_ = errno;                                                       \
        link_request(REQUEST_EXEC_FAILED, 0);                                                      \
        free(made_), free(traced_);                                                                               \
        errno = kept_;                                                                             \
        result_;                                                                                   \
    })

EXPORT int execve(const char *path, char *const arguments[], char *const environment[]) {
    if (!in_lockstep()) return REAL(execve)(path, arguments, environment);
    return REPLACE(path, REAL(execve)(path, words, shimmed));
}
EXPORT int execvpe(const char *file, char *const arguments[], char *const environment[]) {
    if (!in_lockstep()) return REAL(execvpe)(file, arguments, environment);
    return REPLACE(file, REAL(execvpe)(file, words, shimmed));
}
EXPORT int fexecve(int fd, char *const arguments[], char *const environment[]) {
    if (!in_lockstep()) return REAL(fexecve)(fd, arguments, environment);
    // A program given only by a descriptor is not checked for what it loads.
    const char *nobody = NULL;
    return REPLACE(nobody, REAL(fexecve)(fd, words, shimmed));
}
EXPORT int execv(const char *path, char *const arguments[]) { return execve(path, arguments, environ); }
EXPORT int execvp(const char *file, char *const arguments[]) { return execvpe(file, arguments, environ); }

// Collects the arguments of `execl` and its variants in an array on the stack.
#define COLLECT(last, first)                                                                       \
    va_list rest, again;                                                                           \
    va_start(rest, last);                                                                          \
    va_copy(again, rest);                                                                          \
    size_t count = 1;                                                                              \
    while (va_arg(again, char *)) count++;                                                         \
    va_end(again);                                                                                 \
    char *arguments[count + 1];                                                                    \
    arguments[0] = (char *)(first);                                                                \
    for (size_t i = 1; i <= count; i++) arguments[i] = va_arg(rest, char *);

EXPORT int execl(const char *path, const char *argument, ...) {
    COLLECT(argument, argument)
    va_end(rest);
    return execve(path, arguments, environ);
}
EXPORT int execlp(const char *file, const char *argument, ...) {
    COLLECT(argument, argument)
    va_end(rest);
    return execvpe(file, arguments, environ);
}
EXPORT int execle(const char *path, const char *argument, ...) {
    COLLECT(argument, argument)
    char *const *environment = va_arg(rest, char *const *);
    va_end(rest);
    return execve(path, arguments, environment);
}

typedef int spawner(pid_t *, const char *, const posix_spawn_file_actions_t *, const posix_spawnattr_t *,
                    char *const[], char *const[]);

static int spawn(spawner *how, pid_t *pid, const char *path, const posix_spawn_file_actions_t *actions,
                 const posix_spawnattr_t *attributes, char *const arguments[], char *const environment[]) {
    if (!in_lockstep()) return how(pid, path, actions, attributes, arguments, environment);
    if (!link_request(REQUEST_FORK, 0)) return EAGAIN;
    progressed = has_children = true;
    char *made, **traced = as_traced(&path, arguments);
    char **shimmed = with_shim(environment ? environment : environ, traced, &made);
    pid_t child = -1;
    int result = how(&child, path, actions, attributes, traced ? traced : (char **)arguments, shimmed);
    free(made), free(traced);
    link_request(REQUEST_FORKED, result ? -1 : child);
    if (pid && !result) *pid = child;
    return result;
}

EXPORT int posix_spawn(pid_t *restrict pid, const char *restrict path, const posix_spawn_file_actions_t *actions,
                       const posix_spawnattr_t *restrict attributes, char *const arguments[restrict],
                       char *const environment[restrict]) {
    return spawn(REAL(posix_spawn), pid, path, actions, attributes, arguments, environment);
}
EXPORT int posix_spawnp(pid_t *restrict pid, const char *restrict file, const posix_spawn_file_actions_t *actions,
                        const posix_spawnattr_t *restrict attributes, char *const arguments[restrict],
                        char *const environment[restrict]) {
    return spawn(REAL(posix_spawnp), pid, file, actions, attributes, arguments, environment);
}

EXPORT int system(const char *command) {
    if (!in_lockstep() || !command) return REAL(system)(command);
    char *arguments[] = {"sh", "-c", (char *)command, NULL};
    pid_t made;
    int status;
    if (posix_spawn(&made, "/bin/sh", NULL, NULL, arguments, environ)) return -1;
    while (waitpid(made, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return status;
}

EXPORT pid_t wait4(pid_t which, int *status, int options, struct rusage *usage) {
    if (!in_lockstep()) return REAL(wait4)(which, status, options, usage);
    for (;;) {
        pid_t result = REAL(wait4)(which, status, options | WNOHANG, usage);
        if (result != 0 || (options & WNOHANG)) {
            if (result) progressed = true;
            else question();
            return result;
        }
        enum woken woken = block(&(struct wait){.kind = WAIT_RUN, .giver = CHILD, .deadline = NEVER});
        if (woken == INTERRUPTED) return errno = EINTR, -1;
    }
}
EXPORT pid_t wait3(int *status, int options, struct rusage *usage) { return wait4(-1, status, options, usage); }
EXPORT pid_t waitpid(pid_t which, int *status, int options) { return wait4(which, status, options, NULL); }
EXPORT pid_t wait(int *status) { return wait4(-1, status, 0, NULL); }

EXPORT int waitid(idtype_t type, id_t id, siginfo_t *info, int options) {
    if (!in_lockstep()) return REAL(waitid)(type, id, info, options);
    for (;;) {
        siginfo_t found = {0};
        int result = REAL(waitid)(type, id, &found, options | WNOHANG);
        if (result || found.si_pid || (options & WNOHANG)) {
            if (info) *info = found;
            if (found.si_pid) progressed = true;
            else question();
            return result;
        }
        enum woken woken = block(&(struct wait){.kind = WAIT_RUN, .giver = CHILD, .deadline = NEVER});
        if (woken == INTERRUPTED) return errno = EINTR, -1;
    }
}
