// Sockets that ask the kernel for its interfaces (netlink, as Go does): the first answer lists ours, and the kernel's own
// answers, of which the last one says that this was all, come after it.
#include "can.h"
#include <linux/if_link.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <net/if_arp.h>

struct route_socket {
    int users;
    // A list is asked for by a request of this number, and ours has not been read yet.
    bool is_asked;
    uint32_t number;
};

void route_open(int fd) {
    struct route_socket *made = calloc(1, sizeof *made);
    if (made) descriptor_set(fd, FD_ROUTE, made);
}

void route_retain(struct route_socket *route) { route->users++; }

void route_release(struct route_socket *route) {
    if (--route->users <= 0) free(route);
}

bool is_route(int family, int protocol) {
    return family == AF_NETLINK && protocol == NETLINK_ROUTE && can_interfaces() > 0;
}

// The program sends a request.
void route_asks(const struct descriptor *of, const void *data, size_t size) {
    struct route_socket *route = of->object;
    struct {
        struct nlmsghdr head;
        unsigned char family;
    } asked;
    if (size < offsetof(__typeof__(asked), family) + 1) return;
    memcpy(&asked, data, offsetof(__typeof__(asked), family) + 1);
    bool is_list = asked.head.nlmsg_type == RTM_GETLINK && (asked.head.nlmsg_flags & NLM_F_DUMP) == NLM_F_DUMP;
    if (!is_list || (asked.family != AF_UNSPEC && asked.family != AF_PACKET)) return;
    route->is_asked = true;
    route->number = asked.head.nlmsg_seq;
}

bool route_answers(const struct descriptor *of) {
    return of && of->kind == FD_ROUTE && ((const struct route_socket *)of->object)->is_asked;
}

static size_t attribute(char *to, unsigned short type, const void *value, size_t size) {
    struct rtattr head = {.rta_len = (unsigned short)RTA_LENGTH(size), .rta_type = type};
    memset(to, 0, RTA_SPACE(size));
    memcpy(to, &head, sizeof head);
    memcpy(to + RTA_LENGTH(0), value, size);
    return RTA_SPACE(size);
}

// Room for the name, MTU, length of the queue and state of an interface.
#define LINK_BYTES (NLMSG_SPACE(sizeof(struct ifinfomsg)) + RTA_SPACE(IF_NAMESIZE) + 3 * RTA_SPACE(4))

static size_t describe(char *to, int index, uint32_t number, uint32_t from) {
    const char *name = can_name(index);
    uint32_t mtu = can_takes_fd(index) ? CANFD_MTU : CAN_MTU, queue = 10;
    // IF_OPER_DOWN and IF_OPER_UP.
    uint8_t state = can_is_off(index) ? 2 : 6;
    struct ifinfomsg link = {
        .ifi_type = ARPHRD_CAN, .ifi_index = index, .ifi_flags = (unsigned)can_flags(index)};
    size_t size = NLMSG_SPACE(sizeof link);
    size += attribute(to + size, IFLA_IFNAME, name, strlen(name) + 1);
    size += attribute(to + size, IFLA_MTU, &mtu, sizeof mtu);
    size += attribute(to + size, IFLA_TXQLEN, &queue, sizeof queue);
    size += attribute(to + size, IFLA_OPERSTATE, &state, sizeof state);
    struct nlmsghdr head = {.nlmsg_len = (uint32_t)size, .nlmsg_type = RTM_NEWLINK, .nlmsg_flags = NLM_F_MULTI,
                            .nlmsg_seq = number, .nlmsg_pid = from};
    memcpy(to, &head, sizeof head);
    memcpy(to + NLMSG_HDRLEN, &link, sizeof link);
    return size;
}

// Gives the program the list of ours.
ssize_t route_receive(int fd, struct descriptor *of, struct msghdr *message, int flags) {
    struct route_socket *route = of->object;
    struct sockaddr_nl own = {0}, kernel = {.nl_family = AF_NETLINK};
    socklen_t own_size = sizeof own;
    REAL(getsockname)(fd, (struct sockaddr *)&own, &own_size);
    char *text = malloc((size_t)can_interfaces() * LINK_BYTES);
    if (!text) return errno = ENOBUFS, -1;
    size_t size = 0, done = 0;
    for (int index = can_first(); can_name(index); index++)
        size += describe(text + size, index, route->number, own.nl_pid);
    for (size_t i = 0; i < message->msg_iovlen && done < size; i++) {
        struct iovec *part = &message->msg_iov[i];
        size_t piece = size - done < part->iov_len ? size - done : part->iov_len;
        memcpy(part->iov_base, text + done, piece);
        done += piece;
    }
    free(text);
    if (message->msg_name) {
        memcpy(message->msg_name, &kernel, message->msg_namelen < sizeof kernel ? message->msg_namelen : sizeof kernel);
        message->msg_namelen = sizeof kernel;
    }
    message->msg_controllen = 0;
    message->msg_flags = done < size ? MSG_TRUNC : 0;
    if (!(flags & MSG_PEEK)) route->is_asked = false;
    progressed = true;
    return (ssize_t)(flags & MSG_TRUNC ? size : done);
}
