// The C library's list of interfaces and their addresses: ours come first, and have none, as CAN interfaces of the kernel.
#include "can.h"
#include <ifaddrs.h>
#include <net/if.h>

struct own {
    struct ifaddrs entry;
    char name[IF_NAMESIZE];
};

static bool has_own(void) { return is_managed() && can_interfaces() > 0; }

EXPORT int getifaddrs(struct ifaddrs **list) {
    struct ifaddrs *others;
    if (REAL(getifaddrs)(&others)) return -1;
    *list = others;
    if (!has_own()) return 0;
    size_t count = (size_t)can_interfaces();
    struct own *all = calloc(count, sizeof *all);
    if (!all) return REAL(freeifaddrs)(others), errno = ENOMEM, -1;
    for (size_t i = 0; i < count; i++) {
        int index = can_first() + (int)i;
        strcpy(all[i].name, can_name(index));
        all[i].entry = (struct ifaddrs){
            .ifa_next = i + 1 < count ? &all[i + 1].entry : others,
            .ifa_name = all[i].name,
            .ifa_flags = (unsigned)can_flags(index),
        };
    }
    *list = &all->entry;
    return 0;
}

EXPORT void freeifaddrs(struct ifaddrs *list) {
    if (!has_own() || !list) return REAL(freeifaddrs)(list);
    // The entry is the first part of ours, which are one block.
    struct own *all = (struct own *)list;
    REAL(freeifaddrs)(all[can_interfaces() - 1].entry.ifa_next);
    free(all);
}
