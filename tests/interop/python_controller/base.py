"""The base's serial line: `:` writes and `;` reads, in hexadecimal, each sum of bytes zero modulo 256."""

import math
import struct
import time
from dataclasses import dataclass

COMPUTER = 0x01
SET_VELOCITY, WRITE_POSE, STOP, MOTION = 0x1F00, 0x1F10, 0x1F18, 0xE000
MOTION_STEP = math.radians(0.3)


def checksum(data):
    return -sum(data) % 256


@dataclass
class Motion:
    displacement: float
    heading: float
    moving: bool
    timed_out: bool
    pose_result: int
    pose_counter: int


class Base:
    def __init__(self, line):
        self.line = line

    def exchange(self, start, fields, count):
        """Sends a line and gives the answer of `count` bytes, or nothing where it does not come whole."""
        cks = checksum(fields)
        self.line.reset_input_buffer()
        self.line.write(start + bytes([*fields, cks]).hex().upper().encode() + b"\r")
        answer = self.line.read(count)
        if len(answer) < count:
            # A late answer must not be taken for that to the next question.
            time.sleep(0.01)
            return None
        return answer

    def write(self, register, data):
        fields = bytes([len(data)]) + register.to_bytes(2, "big") + bytes([COMPUTER]) + data
        for _ in range(3):
            if self.exchange(b":", fields, 1) == bytes([checksum(fields)]):
                return True
        return False

    def set_velocity(self, drive, steer):
        counts = round(drive * 1e4), round(math.degrees(steer) * 100.0)
        self.write(SET_VELOCITY, struct.pack("<hh", *counts))

    def stop(self):
        self.write(STOP, b"\0")

    def write_pose(self, x, y, heading, counter):
        turned = math.remainder(heading, math.tau)
        bits = round(x * 1e4) & 0x7FFFFF
        bits |= (round(y * 1e4) & 0x7FFFFF) << 23
        bits |= counter << 46
        bits |= (round(math.degrees(turned) * 100.0) & 0xFFFF) << 48
        self.write(WRITE_POSE, bits.to_bytes(8, "little"))

    def read_motion(self):
        fields = bytes([8]) + MOTION.to_bytes(2, "big") + bytes([COMPUTER])
        answer = self.exchange(b";", fields, 9)
        if answer is None or (sum(fields) + sum(answer)) % 256:
            return None
        displacement, heading, status, _ = struct.unpack("<ihBB", answer[:8])
        return Motion(
            displacement=displacement * 1e-4,
            heading=heading * MOTION_STEP,
            moving=bool(status & 1),
            timed_out=bool(status & 2),
            pose_result=status >> 4 & 3,
            pose_counter=status >> 6 & 3,
        )
