"""Asks a valve ten times a second where it stands. Where it does not answer in time, there is an alarm.

    python3 pump.py can0

The time-out is 10 ms too short for a bus that others use too: `docs/guides/a-thousand-times.md` has a campaign find it.
"""

import socket
import struct
import sys
import time

ASK, ANSWER, STATE = 0x98FF0600, 0x98FF0601, 0x98FF0602  # extended identifiers
PERIOD_S, TIME_OUT_S = 0.1, 0.030

bus = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
bus.bind((sys.argv[1],))


def send(identifier, value):
    bus.send(struct.pack("=IB3x8s", identifier, 1, bytes([value])))


def answered(until):
    while (left := until - time.monotonic()) > 0:
        bus.settimeout(left)
        try:
            if struct.unpack("=I", bus.recv(16)[:4])[0] == ANSWER:
                return True
        except TimeoutError:
            break
    return False


due, number = time.monotonic(), 0
while True:
    send(ASK, number % 256)
    send(STATE, 0 if answered(due + TIME_OUT_S) else 1)
    due, number = due + PERIOD_S, number + 1
    time.sleep(due - time.monotonic())
