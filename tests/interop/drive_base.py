#!/usr/bin/env python3
"""Drives a base through a square with python-can and cantools, by the DBC file alone.

    drive_base.py DBC INTERFACE CHANNEL SIDE_M

INTERFACE is one of python-can's, such as socketcan or slcan. Prints one JSON line with the last pose
that the base told.
"""

import json
import sys
import time

import can
import cantools

PERIOD_S = 0.027
SPEED = 0.4
RATE = 60.0
LIMIT_S = 60.0


class Base:
    def __init__(self, dbc, interface, channel):
        self.db = cantools.database.load_file(dbc)
        options = {"bitrate": 500_000} if interface == "slcan" else {}
        self.bus = can.Bus(interface=interface, channel=channel, **options)
        self.motion = None
        self.pose = None
        self.heading = 0.0
        self.motions = 0
        self.lost = 0

    def send(self, name, **signals):
        message = self.db.get_message_by_name(name)
        data = message.encode(signals)
        frame = can.Message(
            arbitration_id=message.frame_id, data=data, is_extended_id=message.is_extended_frame
        )
        self.bus.send(frame)

    def listen(self, until):
        while (rest := until - time.monotonic()) > 0:
            frame = self.bus.recv(rest)
            if frame is not None and not frame.is_error_frame:
                self.take(frame)

    def take(self, frame):
        message = self.db.get_message_by_frame_id(frame.arbitration_id)
        signals = message.decode(frame.data, decode_choices=False)
        if message.name == "POSE":
            self.pose = signals
        elif message.name == "MOTION":
            if self.motion is not None:
                self.lost += (signals["SEQUENCE"] - self.motion["SEQUENCE"] - 1) % 256
                turned = signals["HEADING"] - self.motion["HEADING"]
                self.heading += (turned + 180.0) % 360.0 - 180.0
            self.motion = signals
            self.motions += 1

    def velocity(self, drive, steer):
        self.send("SET_VELOCITY", DRIVE_SPEED=drive, STEER_RATE=steer)

    def go(self, measure, target, gain, fastest, command):
        """Goes until `measure` is at `target` and the base at rest, by a speed that falls with what is
        left."""
        deadline = time.monotonic() + LIMIT_S
        while time.monotonic() < deadline:
            left = target - measure()
            if abs(left) < gain[1] and not self.motion["MOVING"]:
                return
            command(max(-fastest, min(fastest, gain[0] * left)) if abs(left) >= gain[1] else 0.0)
            self.listen(time.monotonic() + PERIOD_S)
        raise SystemExit(f"did not arrive within {LIMIT_S} s: {target - measure()} is left")


def main():
    dbc, interface, channel, side = *sys.argv[1:4], float(sys.argv[4])
    base = Base(dbc, interface, channel)
    try:
        deadline = time.monotonic() + 20.0
        while base.motion is None or base.pose is None:
            if time.monotonic() > deadline:
                raise SystemExit("the base told nothing within 20 s")
            base.listen(time.monotonic() + 0.1)
        base.send("SET_ACCELERATION", DRIVE_ACCELERATION=0.5, STEER_ACCELERATION=120.0)
        start = base.motion["DISPLACEMENT"]
        for corner in range(1, 5):
            base.go(
                lambda: base.motion["DISPLACEMENT"] - start,
                corner * side,
                (1.2, 0.002),
                SPEED,
                lambda speed: base.velocity(speed, 0.0),
            )
            # One step of the odometer's heading is 0.3 deg.
            base.go(
                lambda: base.heading,
                corner * 90.0,
                (1.5, 0.4),
                RATE,
                lambda rate: base.velocity(0.0, rate),
            )
        base.send("STOP")
        # Two periods of the pose, so that one was told at rest.
        base.listen(time.monotonic() + 1.2)
    finally:
        base.bus.shutdown()
    print(
        json.dumps(
            {
                "x_m": base.pose["X"],
                "y_m": base.pose["Y"],
                "heading_deg": base.pose["HEADING"],
                "path_m": base.motion["DISPLACEMENT"] - start,
                "turned_deg": base.heading,
                "motions": base.motions,
                "lost": base.lost,
            }
        )
    )


if __name__ == "__main__":
    main()
