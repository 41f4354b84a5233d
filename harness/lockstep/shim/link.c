// The link to the harness: a stream socket. The program reports when it waits and until when; the harness sends the
// time. The only other traffic is CAN frames and permission to start processes.
#include "shim.h"
#include <stdio.h>
#include <sys/prctl.h>
#include <sys/un.h>

enum message { MESSAGE_HELLO = 1, MESSAGE_IDLE = 2, MESSAGE_FRAME = 7, MESSAGE_UNSENT = 12 };
enum answer { ANSWER_RUN = 1, ANSWER_YES = 2, ANSWER_NO = 3 };

struct to_harness {
    uint32_t kind, flag;
    int64_t argument;
    struct sent_frame frame;
};
struct from_harness {
    uint32_t kind, frames, signal, bytes_came;
    // `realtime_ahead`: how far the wall clock has been set since the start.
    int64_t now, realtime_ahead;
};

int64_t now_ns, realtime_base_ns;
static int64_t realtime_declared_ns;
unsigned spin_questions = 10000;
int64_t spin_step_ns = 10000;
bool link_is_busy;
static int link_fd = -1;
static char socket_path[108];
static bool has_begun, is_first;

void *find_next(const char *name) {
    void *found = dlsym(RTLD_NEXT, name);
    if (!found) {
        dprintf(2, "lockstep: the C library has no %s\n", name);
        abort();
    }
    return found;
}

bool is_managed(void) {
    if (!has_begun) begin();
    return link_fd >= 0;
}

const char *link_path(void) { return socket_path; }

// The harness is gone: there is no source of time any more.
static void lost(const char *what) {
    if (is_first) dprintf(2, "lockstep: the harness is gone (%s)\n", what);
    REAL(_exit)(121);
    __builtin_unreachable();
}

static void send_all(const void *data, size_t size) {
    const char *rest = data;
    while (size > 0) {
        ssize_t count = REAL(send)(link_fd, rest, size, MSG_NOSIGNAL);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) lost("send");
        rest += count, size -= (size_t)count;
    }
}

static void receive_all(void *data, size_t size) {
    char *rest = data;
    while (size > 0) {
        ssize_t count = REAL(recv)(link_fd, rest, size, 0);
        if (count < 0 && errno == EINTR) continue;
        if (count <= 0) lost("receive");
        rest += count, size -= (size_t)count;
    }
}

// One line of the harness's configuration: a word and its value.
static void configure(char *line) {
    char *value = strchr(line, ' ');
    if (!value) return;
    *value++ = 0;
    if (!strcmp(line, "tracer")) tracer_declare(value);
    char *second = strchr(value, ' ');
    if (second) *second++ = 0;
    if (!strcmp(line, "can")) can_declare(value, second && !strcmp(second, "fd"));
    if (!strcmp(line, "serial") && second) serial_declare(value, second);
    if (!strcmp(line, "realtime")) realtime_base_ns = realtime_declared_ns = atoll(value);
    if (!strcmp(line, "spin") && second) spin_questions = (unsigned)atol(value), spin_step_ns = atoll(second);
    if (!strcmp(line, "now")) now_ns = atoll(value);
    if (!strcmp(line, "first")) is_first = true;
    if (!strcmp(line, "talks") && is_first) stdio_talks();
}

static bool connect_to(const char *path) {
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path) return false;
    strcpy(address.sun_path, path);
    int fd = REAL(socket)(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (fd < 0) return false;
    if (REAL(connect)(fd, (struct sockaddr *)&address, sizeof address) < 0) {
        REAL(close)(fd);
        return false;
    }
    link_fd = guard(fd);
    return true;
}

static void greet(void) {
    struct to_harness hello = {.kind = MESSAGE_HELLO, .argument = getpid()};
    send_all(&hello, sizeof hello);
    uint32_t size;
    receive_all(&size, sizeof size);
    char *text = malloc(size + 1), *rest = NULL;
    if (!text) lost("memory");
    receive_all(text, size);
    text[size] = 0;
    for (char *line = strtok_r(text, "\n", &rest); line; line = strtok_r(NULL, "\n", &rest)) configure(line);
    free(text);
}

// Takes an answer of the harness; true if it was the time.
static enum answer take_answer(void) {
    struct from_harness answer;
    receive_all(&answer, sizeof answer);
    if (answer.kind != ANSWER_RUN) return answer.kind;
    now_ns = answer.now;
    realtime_base_ns = realtime_declared_ns + answer.realtime_ahead;
    if (answer.bytes_came) serial_flush();
    for (uint32_t i = 0; i < answer.frames; i++) {
        struct sent_frame sent;
        receive_all(&sent, sizeof sent);
        can_deliver(&sent, NULL);
    }
    timers_run();
    if (answer.signal) schedule_signal((int)answer.signal);
    return ANSWER_RUN;
}

void link_run(int64_t deadline, bool is_stuck, unsigned threads) {
    int64_t next = timers_next();
    struct to_harness idle = {
        .kind = MESSAGE_IDLE,
        .flag = (uint32_t)progressed | (uint32_t)is_stuck << 1 | threads << 2,
        .argument = deadline < next ? deadline : next,
    };
    progressed = false;
    link_is_busy = true;
    send_all(&idle, offsetof(struct to_harness, frame));
    take_answer();
    link_is_busy = false;
}

bool link_request(enum request what, int64_t argument) {
    struct to_harness request = {.kind = what, .argument = argument};
    link_is_busy = true;
    send_all(&request, offsetof(struct to_harness, frame));
    enum answer answer = take_answer();
    link_is_busy = false;
    return answer == ANSWER_YES;
}

unsigned link_unsent(uint32_t port, int64_t *until) {
    struct to_harness question = {.kind = MESSAGE_UNSENT, .flag = port};
    struct from_harness answer;
    link_is_busy = true;
    send_all(&question, offsetof(struct to_harness, frame));
    receive_all(&answer, sizeof answer);
    link_is_busy = false;
    *until = answer.now;
    return answer.bytes_came;
}

// Sends a notice that the harness does not answer.
void link_tell(enum tell what, uint32_t port, int64_t argument) {
    struct to_harness message = {.kind = what, .flag = port, .argument = argument};
    send_all(&message, offsetof(struct to_harness, frame));
}

void link_send_frame(const struct sent_frame *frame) {
    struct to_harness message = {.kind = MESSAGE_FRAME, .frame = *frame};
    send_all(&message, sizeof message);
}

// A forked child opens its own link and waits for its turn.
void link_after_fork(void) {
    unguard(link_fd);
    link_fd = -1;
    if (!connect_to(socket_path)) REAL(_exit)(122);
    is_first = false;
    greet();
    can_after_fork();
    take_answer();
}

// Keeps the link's descriptor away from the numbers that a program uses.
int link_guard(int fd) {
    if (fd == link_fd) link_fd = guard(link_fd);
    return link_fd;
}

__attribute__((constructor)) void begin(void) {
    if (has_begun) return;
    has_begun = true;
    const char *path = getenv("HIL_LOCKSTEP");
    if (!path || strlen(path) >= sizeof socket_path) return;
    strcpy(socket_path, path);
    schedule_begin();
    if (!connect_to(path)) REAL(_exit)(122);
    greet();
    // The harness's own child ends with the harness, whatever it is doing. Its children depend on their links.
    if (is_first) prctl(PR_SET_PDEATHSIG, SIGKILL);
    take_answer();
}
