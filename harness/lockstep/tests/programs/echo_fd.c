// Answers each CAN FD frame with its bytes reversed, under the next identifier.
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

int main(void) {
    int fd = socket(AF_CAN, SOCK_RAW, CAN_RAW), on = 1;
    struct sockaddr_can to = {.can_family = AF_CAN, .can_ifindex = (int)if_nametoindex("can0")};
    struct ifreq asked = {.ifr_name = "can0"};
    if (setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FD_FRAMES, &on, sizeof on) || bind(fd, (void *)&to, sizeof to)) return 1;
    if (ioctl(fd, SIOCGIFMTU, &asked) || asked.ifr_mtu != CANFD_MTU) return 2;
    struct canfd_frame heard, answer = {0};
    for (ssize_t size; (size = read(fd, &heard, sizeof heard)) > 0;) {
        if (size != CANFD_MTU) continue;
        answer.can_id = heard.can_id + 1, answer.len = heard.len, answer.flags = heard.flags;
        for (int i = 0; i < heard.len; i++) answer.data[i] = heard.data[heard.len - 1 - i];
        if (write(fd, &answer, sizeof answer) != sizeof answer) return 3;
    }
    return 4;
}
