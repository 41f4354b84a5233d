// Does nothing for a long time.
#include <unistd.h>

int main(void) {
    sleep(1000);
}
