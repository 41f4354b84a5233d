// Echoes a serial line.
#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

int main(int count, char **words) {
    if (count < 2) return 2;
    int port = open(words[1], O_RDWR | O_NOCTTY);
    struct termios settings;
    if (port < 0 || tcgetattr(port, &settings)) return 3;
    cfmakeraw(&settings);
    tcsetattr(port, TCSANOW, &settings);
    char bytes[64];
    for (ssize_t size; (size = read(port, bytes, sizeof bytes)) > 0;)
        if (write(port, bytes, (size_t)size) != size) return 4;
    return 5;
}
