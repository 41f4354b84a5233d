"""The Navigator's stream: eight bytes, the top bit set on the first alone, seven bits each."""

import collections
import math
import threading
import time

COUNT = math.radians(100.0 / 32768)  # rad/s
PERIOD_S = 0.01
SILENT_S = 0.5


class Gyro:
    """Reads in a thread; rates wait in a queue."""

    def __init__(self, line):
        self.line = line
        self.waiting = collections.deque(maxlen=1000)
        self.temperature = None
        self.samples = self.lost = 0
        self.sequence = None
        self.heard_at = 0.0
        threading.Thread(target=self.read, daemon=True).start()

    def is_silent(self):
        return time.monotonic() - self.heard_at > SILENT_S

    def new(self):
        """Rates in rad/s and the time that each stands for, lost samples included."""
        while self.waiting:
            yield self.waiting.popleft()

    def read(self):
        frame = bytearray()
        while True:
            for value in self.line.read(self.line.in_waiting or 1):
                if value & 0x80:
                    frame = bytearray([value & 0x7F])
                elif frame:
                    frame.append(value)
                if len(frame) == 8:
                    self.take(frame)
                    frame = bytearray()

    def take(self, frame):
        bits = 0
        for seven in frame:
            bits = bits << 7 | seven
        data = bits.to_bytes(7, "big")
        if sum(data) % 256:
            return
        _, t_high, t_low, status, sequence, r_high, r_low = data
        lost = 0
        if self.sequence is not None:
            lost = (sequence - self.sequence - 1) % 256
        self.sequence = sequence
        self.lost += lost
        self.samples += 1
        self.temperature = int.from_bytes(bytes([t_high, t_low]), "big", signed=True) * 0.01
        rate = int.from_bytes(bytes([r_high, r_low]), "big", signed=True) * COUNT
        if not status & 1:
            self.heard_at = time.monotonic()
            self.waiting.append((rate, PERIOD_S * (1 + lost)))
