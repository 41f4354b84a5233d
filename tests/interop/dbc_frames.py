#!/usr/bin/env python3
"""What cantools makes of the DBC files of a folder: frames with random numbers in every signal, and what they mean.

usage: dbc_frames.py FOLDER     (needs cantools)

A line of JSON a file: `{"file", "messages": [{"name", "id", "extended", "fd", "frames": [[hex, {signal: value}], ...]}, ...]}`,
with `null` for the frames of a message that cantools reads and cannot encode; or `{"file", "refused"}` for a file that it does
not read, strict or not.
"""

import json
import pathlib
import random
import struct
import sys

import cantools

FRAMES_A_SIGNAL = 3
# More is a message of J1939 that goes in parts.
BYTES_MAX = 8


def read(path):
    try:
        return cantools.database.load_file(path)
    except Exception:  # noqa: BLE001: whatever it is, it may do without
        return cantools.database.load_file(path, strict=False)


def number(signal):
    """A number on the wire, of as many bits as a double has: more would be rounded on the way."""
    if signal.is_float:
        value = random.randint(-1000, 1000) / 8
        return value if signal.length >= 32 else struct.unpack("<e", struct.pack("<e", value))[0]
    few = max(signal.length - 52, 0)
    count = random.choice([0, (1 << signal.length) - 1, random.getrandbits(signal.length)]) >> few << few
    is_negative = signal.is_signed and count >> (signal.length - 1)
    return count - (1 << signal.length) if is_negative else count


def pages(message):
    """Of each multiplexer the numbers that select signals."""
    found = {}
    for signal in message.signals:
        if signal.multiplexer_ids and signal.multiplexer_signal:
            found.setdefault(signal.multiplexer_signal, set()).update(signal.multiplexer_ids)
    return {name: sorted(numbers) for name, numbers in found.items()}


def frame(message, wanted, by_name, numbers):
    """The bytes of a frame that carries the wanted signal."""
    values = {signal.name: number(signal) for signal in message.signals}
    values.update({name: random.choice(of) for name, of in numbers.items()})
    signal = wanted
    while signal is not None and signal.multiplexer_signal and signal.multiplexer_ids:
        values[signal.multiplexer_signal] = random.choice(signal.multiplexer_ids)
        signal = by_name.get(signal.multiplexer_signal)
    return message.encode(values, scaling=False, strict=False)


def messages(database):
    for message in database.messages:
        if message.length > BYTES_MAX and not message.is_fd or not message.signals:
            continue
        by_name = {signal.name: signal for signal in message.signals}
        numbers = pages(message)
        try:
            frames = []
            for signal in message.signals:
                for _ in range(FRAMES_A_SIGNAL):
                    data = frame(message, signal, by_name, numbers)
                    frames.append([data.hex(), message.decode(data, decode_choices=False)])
        except Exception:  # noqa: BLE001: a message that it reads and cannot encode
            frames = None
        yield {
            "name": message.name,
            "id": message.frame_id,
            "extended": message.is_extended_frame,
            "fd": message.is_fd,
            "frames": frames,
        }


def main():
    random.seed(13)
    for path in sorted(pathlib.Path(sys.argv[1]).rglob("*.dbc")):
        try:
            database = read(path)
        except Exception as error:  # noqa: BLE001: whatever it is, cantools does not read the file
            print(json.dumps({"file": str(path), "refused": str(error)}))
            continue
        print(json.dumps({"file": str(path), "messages": list(messages(database))}))


if __name__ == "__main__":
    main()
