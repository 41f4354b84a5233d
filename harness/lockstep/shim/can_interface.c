// Queries of programs about the CAN interfaces that the harness declared.
#include "can.h"
#include <linux/can/error.h>
#include <linux/sockios.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <stdio.h>
#include <sys/ioctl.h>

#define INTERFACES_MAX 32
// Far above the numbers of real interfaces.
#define INDEX_BASE 1000
static char names[INTERFACES_MAX][IF_NAMESIZE];
static bool takes_fd[INTERFACES_MAX], is_off[INTERFACES_MAX];
static int count;

void can_declare(const char *name, bool is_fd) {
    if (count >= INTERFACES_MAX || strlen(name) >= IF_NAMESIZE) return;
    takes_fd[count] = is_fd;
    strcpy(names[count++], name);
}

int can_interfaces(void) { return count; }
int can_first(void) { return INDEX_BASE; }

int can_index(const char *name) {
    for (int i = 0; i < count; i++)
        if (!strcmp(names[i], name)) return INDEX_BASE + i;
    return 0;
}

bool can_takes_fd(int index) { return can_name(index) && takes_fd[index - INDEX_BASE]; }

// Whether the controller of an interface is bus-off, as its error frames say.
bool can_is_off(int index) { return can_name(index) && is_off[index - INDEX_BASE]; }

int can_flags(int index) { return IFF_UP | IFF_NOARP | (can_is_off(index) ? 0 : IFF_RUNNING); }

void can_errs(int index, canid_t id) {
    if (!can_name(index)) return;
    if (id & CAN_ERR_BUSOFF) is_off[index - INDEX_BASE] = true;
    if (id & CAN_ERR_RESTARTED) is_off[index - INDEX_BASE] = false;
}

const char *can_name(int index) {
    int place = index - INDEX_BASE;
    return place >= 0 && place < count ? names[place] : NULL;
}

EXPORT unsigned if_nametoindex(const char *name) {
    int index = is_managed() ? can_index(name) : 0;
    return index ? (unsigned)index : REAL(if_nametoindex)(name);
}

EXPORT char *if_indextoname(unsigned index, char name[IF_NAMESIZE]) {
    const char *found = is_managed() ? can_name((int)index) : NULL;
    return found ? strcpy(name, found) : REAL(if_indextoname)(index, name);
}

// Lists real interfaces first, then ours; a zero index ends the list.
EXPORT struct if_nameindex *if_nameindex(void) {
    struct if_nameindex *real = REAL(if_nameindex)();
    if (!is_managed() || count == 0) return real;
    size_t others = 0;
    while (real && real[others].if_index) others++;
    // One block, so that `if_freenameindex` frees all of it.
    size_t size = (others + (size_t)count + 1) * sizeof *real;
    struct if_nameindex *all = calloc(1, size + (others + (size_t)count) * IF_NAMESIZE);
    if (!all) return real;
    char *text = (char *)all + size;
    for (size_t i = 0; i < others + (size_t)count; i++, text += IF_NAMESIZE) {
        bool is_real = i < others;
        all[i].if_index = is_real ? real[i].if_index : (unsigned)(INDEX_BASE + i - others);
        all[i].if_name = strncpy(text, is_real ? real[i].if_name : names[i - others], IF_NAMESIZE - 1);
    }
    if (real) REAL(if_freenameindex)(real);
    return all;
}

EXPORT void if_freenameindex(struct if_nameindex *list) {
    if (!is_managed() || count == 0) REAL(if_freenameindex)(list);
    else free(list);
}

#define FOLDER "/sys/class/net/"

// Our interface whose folder contains a path, and the rest of the path after its name.
static int index_of_file(const char *path, const char **rest) {
    char name[IF_NAMESIZE] = {0};
    if (!path || strncmp(path, FOLDER, sizeof FOLDER - 1)) return 0;
    path += sizeof FOLDER - 1;
    size_t length = strcspn(path, "/");
    if (length >= sizeof name) return 0;
    memcpy(name, path, length);
    *rest = path + length;
    return can_index(name);
}

// Contents of a file in /sys about one of our interfaces; false for any other file.
bool can_file_text(const char *path, char text[32]) {
    const char *rest;
    int index = index_of_file(path, &rest), number = -1;
    if (!index) return false;
    if (!strcmp(rest, "/type")) number = ARPHRD_CAN;
    if (!strcmp(rest, "/mtu")) number = can_takes_fd(index) ? CANFD_MTU : CAN_MTU;
    if (!strcmp(rest, "/ifindex")) number = index;
    if (!strcmp(rest, "/carrier")) number = !can_is_off(index);
    if (number >= 0) snprintf(text, 32, "%d\n", number);
    else if (!strcmp(rest, "/flags")) snprintf(text, 32, "0x%x\n", can_flags(index));
    else if (!strcmp(rest, "/operstate")) snprintf(text, 32, can_is_off(index) ? "down\n" : "up\n");
    else return false;
    return true;
}

// A real file to stand in for one of our interfaces: that of the loopback.
const char *can_file_like(const char *path) {
    static char like[PATH_MAX];
    const char *rest;
    if (!index_of_file(path, &rest)) return NULL;
    snprintf(like, sizeof like, FOLDER "lo%s", rest);
    return like;
}

// Answers an `ioctl` about one of our interfaces; false if it is about something else.
bool can_interface_ioctl(unsigned long request, void *argument, int *result) {
    struct ifreq *asked = argument;
    int index;
    if (request < SIOCGIFNAME || request > SIOCGIFINDEX || count == 0 || !asked) return false;
    if (request == SIOCGIFNAME) {
        const char *name = can_name(asked->ifr_ifindex);
        if (!name) return false;
        strcpy(asked->ifr_name, name);
        return *result = 0, true;
    }
    char name[IF_NAMESIZE + 1] = {0};
    memcpy(name, asked->ifr_name, IF_NAMESIZE);
    if (!(index = can_index(name))) return false;
    *result = 0;
    switch (request) {
    case SIOCGIFINDEX: asked->ifr_ifindex = index; break;
    case SIOCGIFFLAGS: asked->ifr_flags = (short)can_flags(index); break;
    case SIOCGIFMTU: asked->ifr_mtu = can_takes_fd(index) ? CANFD_MTU : CAN_MTU; break;
    case SIOCGIFHWADDR: asked->ifr_hwaddr.sa_family = ARPHRD_CAN; break;
    default: errno = EOPNOTSUPP, *result = -1;
    }
    return true;
}
