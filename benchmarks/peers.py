#!/usr/bin/env python3
"""Frames across python-can's virtual bus and messages decoded by cantools, in a second of processor time.

Usage: peers.py FOLDER DBC

FOLDER holds messages.log of `peers figures FOLDER` (harness/hil/benches/peers.rs): the same messages are decoded.
Each figure is the median of RUNS runs.
"""

import statistics
import sys
import time
from pathlib import Path

import can
import cantools
from can.io import CanutilsLogReader

RUNS = 5
BUS_FRAMES = 100_000
PASSES = 50


def per_s(run):
    figures = []
    for _ in range(RUNS):
        began = time.process_time()
        count = run()
        figures.append(count / (time.process_time() - began))
    return statistics.median(figures)


def memory_bus():
    """Two nodes in turn; each frame has arrived before the next is sent."""
    nodes = [can.Bus(interface="virtual", channel="peers") for _ in range(2)]
    frames = [
        can.Message(arbitration_id=identifier, data=[0x55] * 8, is_extended_id=False)
        for identifier in (0x101, 0x181)
    ]

    def run():
        for number in range(BUS_FRAMES):
            node = number % 2
            nodes[node].send(frames[node])
            frame = nodes[1 - node].recv(1.0)
            assert frame.arbitration_id == frames[node].arbitration_id
        return BUS_FRAMES

    try:
        return per_s(run)
    finally:
        for node in nodes:
            node.shutdown()


def messages(folder, dbc):
    """Physical values without the names of choices, which is the faster of cantools' two ways."""
    database = cantools.database.load_file(dbc)
    frames = [(frame.arbitration_id, bytes(frame.data)) for frame in CanutilsLogReader(folder / "messages.log")]

    def run():
        for _ in range(PASSES):
            for identifier, data in frames:
                database.decode_message(identifier, data, decode_choices=False)
        return PASSES * len(frames)

    return per_s(run)


def main():
    folder, dbc = Path(sys.argv[1]), sys.argv[2]
    print(f"peer memory-bus {memory_bus():.0f}", flush=True)
    decoded = messages(folder, dbc)
    print(f"peer messages {decoded:.0f}", flush=True)
    print(f"peer any-dbc {decoded:.0f}", flush=True)


if __name__ == "__main__":
    print(f"python-can {can.__version__}, cantools {cantools.__version__}, Python {sys.version.split()[0]}", file=sys.stderr)
    main()
