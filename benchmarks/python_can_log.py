#!/usr/bin/env python3
"""Rows of a bus log that python-can reads and writes in a second of processor time.

Usage: python_can_log.py FOLDER

FOLDER holds rows.log, rows.asc, rows.blf and rows.trc of `cargo bench -p bus-log --bench bus_log -- FOLDER`. The same files
are read, and what was read is written again; into a TRC file
python-can writes neither remote requests nor CAN FD frames, and none is measured. Each figure is the median of RUNS runs.
"""

import statistics
import sys
import time
from pathlib import Path

import can
from can.io import (
    ASCReader,
    ASCWriter,
    BLFReader,
    BLFWriter,
    CanutilsLogReader,
    CanutilsLogWriter,
    TRCReader,
)

RUNS = 3
FORMATS = [
    ("candump", "log", CanutilsLogReader, CanutilsLogWriter),
    ("asc", "asc", ASCReader, ASCWriter),
    ("blf", "blf", BLFReader, BLFWriter),
    ("trc", "trc", TRCReader, None),
]


def rows_per_s(run):
    figures = []
    for _ in range(RUNS):
        began = time.process_time()
        rows = run()
        figures.append(rows / (time.process_time() - began))
    return statistics.median(figures)


def read(reader, path):
    return sum(1 for _ in reader(path))


def write(writer, path, messages):
    with writer(path) as log:
        for message in messages:
            log.on_message_received(message)
    return len(messages)


def main():
    folder = Path(sys.argv[1])
    for name, end, reader, writer in FORMATS:
        path = folder / f"rows.{end}"
        runs = [("read", lambda: read(reader, path))]
        if writer:
            messages = list(reader(path))
            runs.insert(0, ("write", lambda: write(writer, folder / f"python.{end}", messages)))
        for what, run in runs:
            who = "python-can"
            print(f"{who:<12} {name:<8} {what:<6} {rows_per_s(run):>12.0f} rows/s of processor time", flush=True)


if __name__ == "__main__":
    print(f"python-can {can.__version__}, Python {sys.version.split()[0]}", file=sys.stderr)
    main()
