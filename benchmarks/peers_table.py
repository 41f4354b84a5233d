#!/usr/bin/env python3
"""The figures of `benchmarks/peers` as a table in Markdown.

Usage: peers_table.py FIGURES

FIGURES has lines `hil|peer WHAT FIGURE [P90]`; of several of a kind the median is taken.
"""

import statistics
import sys
from collections import defaultdict

# What, how it is called, the peer, the unit, what of a figure makes one unit, the aim, and which way is better.
MORE, LESS = "times as many", "times as long"
ROWS = [
    ("memory-bus", "frames across the memory bus", "python-can `virtual`", "million/s", 1e6, 50, MORE),
    ("messages", "K2A messages decoded", "cantools", "million/s", 1e6, 20, MORE),
    ("any-dbc", "the same by their DBC", "cantools", "million/s", 1e6, 40, MORE),
    ("pty", "round trip, pty", "poll, read, write in C", "us", 1e3, 1.5, LESS),
    ("vcan", "round trip, vcan in the guest", "poll, read, write in C", "us", 1e3, 1.5, LESS),
]


def main():
    figures = defaultdict(list)
    with open(sys.argv[1]) as lines:
        for line in lines:
            who, what, figure, *_ = line.split()
            figures[who, what].append(float(figure))
    print("| what | ours | theirs | | ratio | aim | |")
    print("|---|---|---|---|---|---|---|")
    for what, title, peer, unit, scale, aim, better in ROWS:
        if not figures["hil", what] or not figures["peer", what]:
            continue
        ours, theirs = (statistics.median(figures[who, what]) for who in ("hil", "peer"))
        ratio = ours / theirs
        met = ratio >= aim if better == MORE else ratio <= aim
        bound = "at least" if better == MORE else "at most"
        print(
            f"| {title} | {ours / scale:.3g} {unit} | {theirs / scale:.3g} {unit} | {peer} "
            f"| {ratio:.3g} {better} | {bound} {aim} | {'met' if met else 'missed'} |"
        )


if __name__ == "__main__":
    main()
