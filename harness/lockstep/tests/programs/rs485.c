// Sets the RS-485 mode of a port, and says on another what the port has kept.
#include <fcntl.h>
#include <linux/serial.h>
#include <stdio.h>
#include <sys/ioctl.h>
#include <unistd.h>

static int say;

static void tell(const char *what, int result, const struct serial_rs485 *mode) {
    char text[100];
    int size = snprintf(text, sizeof text, "%s %d: %x %u %u\n", what, result, mode->flags,
                        mode->delay_rts_before_send, mode->delay_rts_after_send);
    write(say, text, (size_t)size);
}

int main(int count, char **words) {
    (void)count;
    int line = open(words[1], O_RDWR | O_NOCTTY);
    say = open(words[2], O_RDWR | O_NOCTTY);
    struct serial_rs485 mode = {0}, kept;
    tell("first", ioctl(line, TIOCGRS485, &mode), &mode);
    mode.flags = SER_RS485_ENABLED | SER_RS485_RTS_AFTER_SEND | SER_RS485_RX_DURING_TX;
    mode.delay_rts_before_send = 2, mode.delay_rts_after_send = 3;
    tell("set", ioctl(line, TIOCSRS485, &mode), &mode);
    tell("kept", ioctl(line, TIOCGRS485, &kept), &kept);
    close(line), line = open(words[1], O_RDWR | O_NOCTTY);
    tell("opened again", ioctl(line, TIOCGRS485, &kept), &kept);
    mode.flags = SER_RS485_ENABLED, mode.delay_rts_after_send = 1000;
    tell("put right", ioctl(line, TIOCSRS485, &mode), &mode);
    mode.flags = 0;
    ioctl(line, TIOCSRS485, &mode);
    tell("off", ioctl(line, TIOCGRS485, &kept), &kept);
    tell("of another", ioctl(say, TIOCGRS485, &kept), &kept);
}
