// Exercises CAN sockets, and reports on a serial line.
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/bcm.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

static FILE *out;

static int bound(int type, int protocol, const char *name) {
    int fd = socket(AF_CAN, type, protocol);
    struct sockaddr_can to = {.can_family = AF_CAN, .can_ifindex = name ? (int)if_nametoindex(name) : 0};
    if (protocol == CAN_BCM ? connect(fd, (void *)&to, sizeof to) : bind(fd, (void *)&to, sizeof to)) return -1;
    return fd;
}

// Everything in a socket: identifiers, and flags of local and own frames.
static void heard(const char *who, int fd) {
    fprintf(out, "%s:", who);
    struct can_frame frame;
    struct iovec part = {&frame, sizeof frame};
    char control[64];
    struct msghdr message;
    for (;;) {
        message = (struct msghdr){
            .msg_iov = &part, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
        if (recvmsg(fd, &message, MSG_DONTWAIT) != sizeof frame) break;
        bool own = message.msg_flags & MSG_CONFIRM, local = message.msg_flags & MSG_DONTROUTE;
        fprintf(out, " %x%s", frame.can_id, own ? "o" : local ? "l" : "");
        struct cmsghdr *stamp = CMSG_FIRSTHDR(&message);
        if (stamp && stamp->cmsg_type == SO_TIMESTAMP) {
            struct timeval *at = (void *)CMSG_DATA(stamp);
            fprintf(out, "@%ld.%06ld", (long)at->tv_sec - 1700000000, (long)at->tv_usec);
        }
    }
    fprintf(out, "\n");
}

static struct {
    struct bcm_msg_head head;
    struct can_frame frame;
} asked;

static int ask(int fd, unsigned opcode, unsigned flags, unsigned id, unsigned count, long first_us, long then_us) {
    memset(&asked, 0, sizeof asked);
    asked.head.opcode = opcode, asked.head.flags = flags, asked.head.can_id = id, asked.head.count = count;
    asked.head.ival1.tv_usec = first_us, asked.head.ival2.tv_usec = then_us;
    bool has_frame = opcode == TX_SETUP;
    // As python-can does, which announces a frame that does not follow.
    asked.head.nframes = has_frame || opcode == TX_DELETE;
    asked.frame.can_id = id, asked.frame.can_dlc = 1, asked.frame.data[0] = 7;
    size_t size = sizeof asked.head + (has_frame ? sizeof asked.frame : 0);
    return write(fd, &asked, size) == (ssize_t)size ? 0 : errno;
}

static int send_many(int fd, struct mmsghdr *messages, unsigned count) {
    int done = sendmmsg(fd, messages, count, 0);
    if (done >= 0 || errno != ENOSYS) return done;
    for (done = 0; done < (int)count && sendmsg(fd, &messages[done].msg_hdr, 0) > 0;) done++;
    return done;
}

static int receive_many(int fd, struct mmsghdr *messages, unsigned count, int flags) {
    int done = recvmmsg(fd, messages, count, flags, NULL);
    if (done >= 0 || errno != ENOSYS) return done;
    // A static program falls back, as it would on a kernel without the call.
    for (done = 0; done < (int)count; done++) {
        ssize_t size = recvmsg(fd, &messages[done].msg_hdr, done ? MSG_DONTWAIT : 0);
        if (size < 0) break;
        messages[done].msg_len = (unsigned)size;
    }
    return done;
}

int main(void) {
    out = fopen("/dev/ttyHIL0", "r+");
    if (!out) return 1;
    char name[IF_NAMESIZE];
    fprintf(out, "names: %d %s\n", if_nametoindex("can7"), if_indextoname(if_nametoindex("can1"), name));
    int all = bound(SOCK_RAW, CAN_RAW, NULL), one = bound(SOCK_RAW, CAN_RAW, "can0"), other = bound(SOCK_RAW, CAN_RAW, "can1");
    struct can_filter but = {.can_id = 0x100 | CAN_INV_FILTER, .can_mask = CAN_SFF_MASK};
    int but_100 = bound(SOCK_RAW, CAN_RAW, "can0"), on = 1, off = 0;
    setsockopt(but_100, SOL_CAN_RAW, CAN_RAW_FILTER, &but, sizeof but);
    int nothing = bound(SOCK_RAW, CAN_RAW, "can0");
    setsockopt(nothing, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0);
    setsockopt(one, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, &on, sizeof on);
    setsockopt(all, SOL_SOCKET, SO_TIMESTAMP, &on, sizeof on);

    struct can_frame frame = {.can_id = 0x100, .can_dlc = 2, .data = {1, 2}};
    usleep(1500);
    fprintf(out, "write: %zd\n", write(one, &frame, sizeof frame));
    frame.can_id = 0x101;
    struct sockaddr_can to = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex("can1")};
    fprintf(out, "sendto: %zd\n", sendto(all, &frame, sizeof frame, 0, (void *)&to, sizeof to));
    setsockopt(other, SOL_CAN_RAW, CAN_RAW_LOOPBACK, &off, sizeof off);
    frame.can_id = 0x12345 | CAN_EFF_FLAG;
    fprintf(out, "write: %zd\n", write(other, &frame, sizeof frame));
    ssize_t count = write(all, &frame, sizeof frame);
    fprintf(out, "nowhere: %zd %d\n", count, errno == ENXIO);
    struct canfd_frame fd_frame = {.can_id = 1, .len = 12};
    setsockopt(one, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on);
    count = write(one, &fd_frame, sizeof fd_frame);
    fprintf(out, "fd: %zd %d\n", count, errno == EINVAL);
    heard("all", all), heard("one", one), heard("other", other), heard("but 100", but_100), heard("nothing", nothing);

    // Three frames 10 ms apart, then one every 25 ms.
    int manager = bound(SOCK_DGRAM, CAN_BCM, "can0");
    fprintf(out, "bcm: %d", ask(manager, TX_SETUP, SETTIMER | STARTTIMER, 0x200, 3, 10000, 25000));
    fprintf(out, " %d", ask(manager, TX_READ, 0, 0x201, 0, 0, 0) == EINVAL);
    usleep(100000);
    fprintf(out, " %d\n", ask(manager, TX_DELETE, 0, 0x200, 0, 0, 0));
    heard("cyclic", all);
    // Notices of changes, and of 50 ms without a frame.
    ask(manager, RX_SETUP, SETTIMER | STARTTIMER, 0x300, 0, 50000, 0);
    fprintf(out, "rx:");
    for (int i = 0; i < 3; i++) {
        if (read(manager, &asked, sizeof asked) < 0) return 2;
        fprintf(out, " %u:%d", asked.head.opcode, asked.head.nframes ? asked.frame.data[0] : -1);
    }
    fprintf(out, "\n");
    heard("rest", all);

    struct can_frame sent[2] = {{.can_id = 0x400}, {.can_id = 0x401}}, got[3];
    struct mmsghdr messages[3];
    memset(messages, 0, sizeof messages);
    struct iovec parts[3];
    for (int i = 0; i < 3; i++) {
        parts[i] = i < 2 ? (struct iovec){&sent[i], sizeof sent[i]} : (struct iovec){&got[i], sizeof got[i]};
        messages[i].msg_hdr = (struct msghdr){.msg_iov = &parts[i], .msg_iovlen = 1};
    }
    fprintf(out, "many: %d", send_many(one, messages, 2));
    for (int i = 0; i < 3; i++) parts[i] = (struct iovec){&got[i], sizeof got[i]};
    // Two wait; a third is not waited for.
    fprintf(out, " %d", receive_many(all, messages, 3, MSG_WAITFORONE));
    fprintf(out, " %x:%u %x:%u\n", got[0].can_id, messages[0].msg_len, got[1].can_id, messages[1].msg_len);
    return 0;
}
