"""The manager of a battery pack on SocketCAN, with nothing but Python's own library.

    python3 manager.py vcan0 [--mistake NAME]

It closes the contactor while it is asked to charge and the cells are well, and opens it for good on over-voltage,
over-temperature, or when the cells fall silent. `--mistake` plants one of the mistakes that the plan finds.
"""

import argparse
import socket
import struct
import time

CELLS, CHARGER, COMMAND, REQUEST = 0x100, 0x110, 0x200, 0x300
PERIOD_S = 0.05
VOLTAGE_MAX = 4.25  # V: where the cells' maker says stop
TEMPERATURE_MAX = 60  # degC
SILENCE_S = 0.5
CURRENT_LIMIT = 40.0  # A
MISTAKES = ["never-opens", "opens-late", "closes-again", "limit-too-high", "forgets-silence"]


class Manager:
    def __init__(self, mistake=None):
        self.mistake = mistake
        self.asked = False
        self.cells_at = None
        self.voltage = self.temperature = 0.0
        self.tripped_at = None

    def hear(self, now, identifier, data):
        if identifier == CELLS and len(data) >= 5:
            self.voltage = struct.unpack_from("<H", data)[0] * 0.001
            self.temperature = struct.unpack_from("b", data, 4)[0]
            self.cells_at = now
        elif identifier == REQUEST and data:
            self.asked = bool(data[0] & 1)

    def closed(self, now):
        silent = self.cells_at is None or now - self.cells_at > SILENCE_S
        if self.mistake == "forgets-silence":
            silent = self.cells_at is None
        bad = self.voltage > VOLTAGE_MAX or self.temperature > TEMPERATURE_MAX
        if self.cells_at is not None and (bad or silent) and self.tripped_at is None:
            self.tripped_at = now
        tripped = self.tripped_at is not None
        if self.mistake == "never-opens":
            tripped = False
        elif self.mistake == "opens-late" and tripped:
            tripped = now - self.tripped_at > 1.0
        elif self.mistake == "closes-again" and tripped:
            tripped = now - self.tripped_at < 0.5
        return self.asked and not silent and not tripped

    def command(self, now):
        closed = self.closed(now)
        limit = CURRENT_LIMIT * (2 if self.mistake == "limit-too-high" else 1)
        return struct.pack("<BHx", int(closed), round(limit / 0.01) if closed else 0)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("interface")
    parser.add_argument("--mistake", choices=MISTAKES)
    arguments = parser.parse_args()
    bus = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
    bus.bind((arguments.interface,))
    manager = Manager(arguments.mistake)
    due = time.monotonic()
    while True:
        now = time.monotonic()
        if now >= due:
            due += PERIOD_S
            data = manager.command(now)
            bus.send(struct.pack("=IB3x8s", COMMAND, len(data), data))
            continue
        bus.settimeout(due - now)
        try:
            identifier, length, data = struct.unpack("=IB3x8s", bus.recv(16))
        except (TimeoutError, BlockingIOError):
            continue
        manager.hear(time.monotonic(), identifier & socket.CAN_SFF_MASK, data[:length])


if __name__ == "__main__":
    main()
