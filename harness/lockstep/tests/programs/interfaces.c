// Says on a serial line which CAN interfaces the C library knows, and which the kernel lists by netlink.
#include <fcntl.h>
#include <ifaddrs.h>
#include <linux/if_link.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static int has_loopback;

static void one(const char *name, unsigned index, unsigned flags, int kind, unsigned mtu) {
    if (!strcmp(name, "lo")) has_loopback = 1;
    if (strncmp(name, "can", 3)) return;
    printf("%s %u %s%s%d %u\n", name, index, flags & IFF_UP ? "up " : "", flags & IFF_RUNNING ? "running " : "", kind,
           mtu);
}

static int ask(unsigned number, int family) {
    struct {
        struct nlmsghdr head;
        struct ifinfomsg link;
    } asked = {{sizeof asked, RTM_GETLINK, NLM_F_REQUEST | NLM_F_DUMP, number, 0}, {.ifi_family = (unsigned char)family}};
    int fd = socket(AF_NETLINK, SOCK_RAW | SOCK_CLOEXEC, NETLINK_ROUTE);
    struct iovec part = {&asked, sizeof asked};
    struct sockaddr_nl to = {.nl_family = AF_NETLINK};
    struct msghdr message = {.msg_name = &to, .msg_namelen = sizeof to, .msg_iov = &part, .msg_iovlen = 1};
    if (sendmsg(fd, &message, 0) != sizeof asked) printf("not sent\n");
    return fd;
}

static void list(int fd, unsigned number) {
    static char text[32768];
    struct sockaddr_nl own, from;
    socklen_t size = sizeof own;
    getsockname(fd, (struct sockaddr *)&own, &size);
    for (int more = 1; more;) {
        char first[16];
        long whole = recv(fd, first, sizeof first, MSG_PEEK | MSG_TRUNC);
        struct iovec part = {text, sizeof text};
        struct msghdr message = {.msg_name = &from, .msg_namelen = sizeof from, .msg_iov = &part, .msg_iovlen = 1};
        long count = recvmsg(fd, &message, 0);
        if (count <= 0 || count != whole || from.nl_family != AF_NETLINK || from.nl_pid) printf("%ld %ld\n", count, whole);
        if (count <= 0) return;
        for (struct nlmsghdr *head = (void *)text; NLMSG_OK(head, count); head = NLMSG_NEXT(head, count)) {
            if (head->nlmsg_seq != number || head->nlmsg_pid != own.nl_pid) printf("another's\n");
            if (head->nlmsg_type == NLMSG_DONE) more = 0;
            if (head->nlmsg_type != RTM_NEWLINK) continue;
            struct ifinfomsg *link = NLMSG_DATA(head);
            const char *name = "";
            unsigned mtu = 0;
            int rest = (int)IFLA_PAYLOAD(head);
            for (struct rtattr *at = IFLA_RTA(link); RTA_OK(at, rest); at = RTA_NEXT(at, rest)) {
                if (at->rta_type == IFLA_IFNAME) name = RTA_DATA(at);
                if (at->rta_type == IFLA_MTU) mtu = *(unsigned *)RTA_DATA(at);
            }
            one(name, (unsigned)link->ifi_index, link->ifi_flags, link->ifi_type, mtu);
        }
    }
    close(fd);
}

int main(int count, char **words) {
    (void)count;
    dup2(open(words[1], O_WRONLY | O_NOCTTY), 1);
    setvbuf(stdout, NULL, _IOLBF, 0);
    printf("index %u\n", if_nametoindex("can0"));
    struct if_nameindex *names = if_nameindex();
    for (struct if_nameindex *at = names; at && at->if_index; at++)
        if (!strncmp(at->if_name, "can", 3)) printf("%s %u\n", at->if_name, at->if_index);
    if_freenameindex(names);
    struct ifaddrs *all;
    for (int i = 0; i < 2 && !getifaddrs(&all); i++) {
        for (struct ifaddrs *at = all; at; at = at->ifa_next) {
            // An interface of CAN has no address.
            if (!at->ifa_addr) one(at->ifa_name, if_nametoindex(at->ifa_name), at->ifa_flags, 0, 0);
        }
        freeifaddrs(all);
    }
    list(ask(5, AF_UNSPEC), 5);
    list(ask(6, AF_PACKET), 6);
    // Lists of other things do not contain our interfaces.
    list(ask(7, AF_INET6), 7);
    printf("loopback %d\n", has_loopback);
}
