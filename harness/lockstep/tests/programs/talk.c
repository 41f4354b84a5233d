// Echoes every line that it reads, after the time in milliseconds.
#include <stdio.h>
#include <time.h>

int main(void) {
    char line[100];
    while (fgets(line, sizeof line, stdin)) {
        struct timespec now;
        clock_gettime(CLOCK_MONOTONIC, &now);
        printf("%ld %s", (now.tv_sec - 10000) * 1000 + now.tv_nsec / 1000000, line);
        fflush(stdout);
    }
    puts("end");
}
