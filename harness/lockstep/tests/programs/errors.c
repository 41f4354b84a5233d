// Prints the error frames of a CAN interface to a serial line, and sends a frame every 10 ms.
#include <fcntl.h>
#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdio.h>
#include <sys/socket.h>
#include <unistd.h>

static int opened(can_err_mask_t mask) {
    int fd = socket(AF_CAN, SOCK_RAW, CAN_RAW);
    struct sockaddr_can to = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex("can0")};
    // Error frames have their own filter.
    setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, NULL, 0);
    setsockopt(fd, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &mask, sizeof mask);
    return bind(fd, (void *)&to, sizeof to) ? -1 : fd;
}

int main(void) {
    FILE *out = fopen("/dev/ttyHIL0", "w");
    int all = opened(CAN_ERR_MASK), off = opened(CAN_ERR_BUSOFF), none = opened(0);
    struct can_frame frame, sent = {.can_id = 0x123, .can_dlc = 1};
    setvbuf(out, NULL, _IONBF, 0);
    for (;; sent.data[0]++) {
        usleep(10000);
        const int sockets[] = {all, off, none};
        for (int i = 0; i < 3; i++)
            while (recv(sockets[i], &frame, sizeof frame, MSG_DONTWAIT) == sizeof frame)
                fprintf(out, "%c %x %x %d %d\n", "abn"[i], frame.can_id & ~CAN_ERR_FLAG, frame.data[1], frame.data[6],
                        frame.data[7]);
        if (write(all, &sent, sizeof sent) != sizeof sent) fprintf(out, "not written\n");
    }
}
