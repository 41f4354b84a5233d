#!/usr/bin/env python3
"""How late python-can's MessageSync hands the frames of a log to a bus.

Usage: python_can_replay.py LOG

The bus is python-can's `virtual` one. A frame is late from when it was due, as far after the first one as in
the log, to when it is handed to the bus; the first counts as punctual.
"""

import sys
import time

import can


def quantile(ordered, share):
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def main():
    late = []
    with can.Bus(interface="virtual", channel="replay") as bus, can.LogReader(sys.argv[1]) as reader:
        first = None
        for message in can.MessageSync(reader):
            now = time.perf_counter()
            if first is None:
                first = (now, message.timestamp)
            late.append(abs((now - first[0]) - (message.timestamp - first[1])) * 1e6)
            bus.send(message)
    late.sort()
    print(
        f"python-can {len(late):>6} frames  late p50 {quantile(late, 0.5):.0f} us, "
        f"p99 {quantile(late, 0.99):.0f} us, max {late[-1]:.0f} us"
    )


if __name__ == "__main__":
    print(f"python-can {can.__version__}, Python {sys.version.split()[0]}", file=sys.stderr)
    main()
