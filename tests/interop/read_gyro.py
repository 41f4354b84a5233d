#!/usr/bin/env python3
"""Reads a gyro's stream with pyserial and decodes it by its makers' words.

    read_gyro.py PORT navigator|ecore2000|dsp3000-ascii|dsp3000-binary FRAMES

Prints one JSON line: good frames, bad ones among them, mean rate in deg/s, last temperature, time.
"""

import json
import sys
import time

import serial

BAUD = {"navigator": 9600, "ecore2000": 9600, "dsp3000-ascii": 38400, "dsp3000-binary": 115200}
# deg/s of one count: full range over 2^15 (Navigator: 100 deg/s; E-Core 2000: 60 deg/s unit).
COUNT = {"navigator": 100.0 / 32768, "ecore2000": 60.0 / 32768}


def kvh_frames(byte):
    """Eight bytes, the top bit set on the first alone; seven bits each make seven bytes, which sum to
    zero modulo 256. Yields six payload bytes, or None for a frame that is not right."""
    frame = []
    while True:
        value = byte()
        if value & 0x80:
            if frame:
                yield None
            frame = [value & 0x7F]
        elif frame:
            frame.append(value)
        if len(frame) == 8:
            bits = "".join(f"{seven:07b}" for seven in frame)
            data = [int(bits[at : at + 8], 2) for at in range(0, 56, 8)]
            yield data[1:] if sum(data) % 256 == 0 else None
            frame = []


def signed(high, low):
    return int.from_bytes(bytes([high, low]), "big", signed=True)


def kvh(byte, stream):
    for data in kvh_frames(byte):
        if data is None:
            yield None
            continue
        rate = signed(data[4], data[5]) * COUNT[stream]
        temperature = signed(data[0], data[1]) * 0.01 if stream == "navigator" else None
        yield rate, temperature


def dsp3000_ascii(byte):
    """`(-)xxx.xxxxxx y` CR LF; y is 1 for valid data."""
    line = bytearray()
    begun = False
    while True:
        value = byte()
        if value != 0x0A:
            line.append(value)
            continue
        # The first line may have begun before anybody listened.
        if begun:
            words = line.decode("ascii", "replace").split()
            good = len(words) == 2 and words[1] == "1" and line.endswith(b"\r")
            yield (float(words[0]), None) if good else None
        begun, line = True, bytearray()


def dsp3000_binary(byte):
    """Words of 32 bits, most significant byte first: valid, counter (2), type (2), odd parity, and 26 of
    two's complement in 60 micro-deg/s. Ten good words in a row make lock."""

    def fields(word):
        good = word.bit_count() % 2 == 1 and word >> 31 == 1 and (word >> 27) & 3 == 0
        content = word & 0x3FFFFFF
        content -= (content & 0x2000000) << 1
        return good, (word >> 29) & 3, content * 60e-6

    window, locked = bytearray(), False
    while True:
        window.append(byte())
        if not locked:
            if len(window) < 40:
                continue
            words = [int.from_bytes(window[at : at + 4], "big") for at in range(0, 40, 4)]
            seen = [fields(word) for word in words]
            counters = [counter for _, counter, _ in seen]
            follow = all((b - a) % 4 == 1 for a, b in zip(counters, counters[1:]))
            if follow and all(good for good, _, _ in seen):
                locked, expected = True, (counters[-1] + 1) % 4
                window.clear()
                for _, _, rate in seen:
                    yield rate, None
            else:
                del window[0]
        elif len(window) == 4:
            good, counter, rate = fields(int.from_bytes(window, "big"))
            good = good and counter == expected
            expected = (counter + 1) % 4
            window.clear()
            yield (rate, None) if good else None


def main():
    port, stream, wanted = sys.argv[1], sys.argv[2], int(sys.argv[3])
    with serial.Serial(port, BAUD[stream], timeout=10) as line:

        def byte():
            got = line.read(1)
            if not got:
                raise SystemExit("nothing came for 10 s")
            return got[0]

        line.reset_input_buffer()
        decoders = {"dsp3000-ascii": dsp3000_ascii, "dsp3000-binary": dsp3000_binary}
        decode = decoders[stream](byte) if stream in decoders else kvh(byte, stream)
        began = time.monotonic()
        good, bad, temperature = [], 0, None
        # What was cut when the buffer was emptied is no fault of the stream.
        next(decode)
        while len(good) < wanted:
            frame = next(decode)
            if frame is None:
                bad += 1
            else:
                good.append(frame[0])
                temperature = frame[1]
        took = time.monotonic() - began
    print(
        json.dumps(
            {
                "good": len(good),
                "bad": bad,
                "rate_deg_per_s": sum(good) / len(good),
                "temperature_celsius": temperature,
                "took_s": took,
            }
        )
    )


if __name__ == "__main__":
    main()
