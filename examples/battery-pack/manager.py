"""The manager of a battery pack on SocketCAN, with nothing but Python's own library.

    python3 manager.py vcan0 [--mistake NAME]

It closes the contactor, behind a precharge, while it is asked to charge and the cells are well. It opens it for good on
over-voltage, over-temperature, or when the cells fall silent: a message whose checksum or counter is wrong is not heard.
`--mistake` plants a mistake. The plans find six of them, and a campaign the seventh.
"""

import argparse
import socket
import struct
import time

CELLS, CHARGER, COMMAND, TRIP_REPORT, REQUEST = 0x100, 0x110, 0x200, 0x210, 0x300
PERIOD_S = 0.05
VOLTAGE_MAX = 4.25  # V: where the cells' maker says stop
TEMPERATURE_MAX = 60  # degC
WARM = 45  # degC: from there on half the current
SILENCE_S = 0.5
PRECHARGE_S = 0.1
CURRENT_LIMIT = 40.0  # A
STANDBY, PRECHARGE, CHARGING, TRIPPED = range(4)
OVER_VOLTAGE, OVER_TEMPERATURE, SILENCE = 1, 2, 3
MISTAKES = [
    "no-derating",
    "opens-late",
    "long-time-out",
    "stuck-counter",
    "skips-precharge",
    "trusts-after-error",
    "gives-up",
]


def crc8_sae_j1850(data):
    crc = 0xFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1) ^ 0x1D if crc & 0x80 else crc << 1
            crc &= 0xFF
    return crc ^ 0xFF


class Manager:
    def __init__(self, mistake=None):
        self.mistake = mistake
        self.asked = False
        self.cells_at = self.cells_count = None
        self.trusting = False
        self.voltage = self.temperature = 0.0
        self.state, self.since = STANDBY, 0.0
        self.count = 0
        self.reason, self.reported = 0, None

    def hear(self, now, identifier, data):
        if identifier == CELLS and len(data) == 8:
            if crc8_sae_j1850(data[:7]) != data[7]:
                self.trusting = self.mistake == "trusts-after-error"
                return
            count = data[5] & 0xF
            if count == self.cells_count and not self.trusting:
                return
            self.cells_count = count
            self.voltage = struct.unpack_from("<H", data)[0] * 0.001
            self.temperature = struct.unpack_from("b", data, 4)[0]
            self.cells_at = now
        elif identifier == REQUEST and data:
            self.asked = bool(data[0] & 1)

    def wrong(self, now):
        """Why the contactor must not be closed; 0: it may be."""
        if self.cells_at is None:
            return 0
        if self.voltage > VOLTAGE_MAX:
            return OVER_VOLTAGE
        if self.temperature > TEMPERATURE_MAX:
            return OVER_TEMPERATURE
        time_out = 3 * SILENCE_S if self.mistake == "long-time-out" else SILENCE_S
        return SILENCE if now - self.cells_at > time_out else 0

    def step(self, now):
        """The messages that are due: identifier and data of each."""
        wrong, before = self.wrong(now), self.state
        if self.state != TRIPPED and wrong:
            self.state = TRIPPED
        elif self.state == STANDBY and self.asked and self.cells_at is not None:
            self.state = PRECHARGE
        elif self.state in (PRECHARGE, CHARGING) and not self.asked:
            self.state = STANDBY
        elif self.state == PRECHARGE:
            # A tick of the clock is no reason to wait for the next period.
            enough = 0.0 if self.mistake == "skips-precharge" else PRECHARGE_S - 1e-3
            if now - self.since >= enough:
                self.state = CHARGING
        if self.state != before:
            self.since = now
        gives_up = self.mistake == "gives-up" and now - self.since > 0.5
        closed = self.state == CHARGING and not gives_up
        if self.mistake == "opens-late" and self.state == TRIPPED:
            closed = now - self.since < 1.0
        messages = [(COMMAND, self.command(closed))]
        if self.state == TRIPPED and before != TRIPPED:
            self.reason = wrong
        if self.reported != self.reason:
            self.reported = self.reason
            messages.append((TRIP_REPORT, bytes([self.reason])))
        return messages

    def command(self, closed):
        warm = self.temperature > WARM and self.mistake != "no-derating"
        limit = CURRENT_LIMIT / 2 if warm else CURRENT_LIMIT
        raw = round(limit / 0.01) if closed else 0
        data = struct.pack("<BHB", closed | self.state << 1, raw, self.count)
        if self.mistake != "stuck-counter":
            self.count = (self.count + 1) % 16
        return data + bytes([crc8_sae_j1850(data)])


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
            for identifier, data in manager.step(now):
                bus.send(struct.pack("=IB3x8s", identifier, len(data), data))
            continue
        bus.settimeout(due - now)
        try:
            identifier, length, data = struct.unpack("=IB3x8s", bus.recv(16))
        except (TimeoutError, BlockingIOError):
            continue
        manager.hear(time.monotonic(), identifier & socket.CAN_SFF_MASK, data[:length])


if __name__ == "__main__":
    main()
