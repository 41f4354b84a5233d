// A controller in C++: one thread reads, one works with what was read, the main thread tells.
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <mutex>
#include <queue>
#include <string>
#include <thread>
#include <unistd.h>

using namespace std::chrono;

static std::mutex mutex;
static std::condition_variable arrived, worked;
static std::queue<double> samples;
static unsigned long count;
static double heading;

int main(int argc, char **argv) {
    if (argc < 3) return 2;
    int gyro = open(argv[1], O_RDWR), base = open(argv[2], O_RDWR);
    std::thread reader([&] {
        std::string line;
        char byte;
        // One byte at a time, blocking.
        while (read(gyro, &byte, 1) == 1) {
            if (byte != '\n') {
                line += byte;
                continue;
            }
            std::lock_guard lock(mutex);
            samples.push(std::atof(line.c_str()));
            line.clear();
            arrived.notify_one();
        }
    });
    std::thread worker([&] {
        std::unique_lock lock(mutex);
        for (;;) {
            arrived.wait(lock, [] { return !samples.empty(); });
            heading += samples.front() / 100;
            samples.pop();
            if (++count % 10 == 0) worked.notify_all();
        }
    });
    auto start = steady_clock::now();
    for (unsigned long told = 0;; told++) {
        std::unique_lock lock(mutex);
        auto result = worked.wait_for(lock, milliseconds(35));
        auto at = duration_cast<nanoseconds>(steady_clock::now() - start).count();
        dprintf(base, "%lu %s %lu %.4f %lld\n", told, result == std::cv_status::timeout ? "late" : "told", count, heading,
                (long long)at);
        lock.unlock();
        std::this_thread::sleep_for(microseconds(1500));
    }
}
