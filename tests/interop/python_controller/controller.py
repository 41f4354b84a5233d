#!/usr/bin/env python3
"""A small controller of its own: Navigator gyro, K2A-style base on a serial line, missions by JSON lines.

    controller.py --gyro PORT --base PORT [--slip clockwise-positive] [--listen unix:PATH|tcp:HOST:PORT]

It shares no code with the controller of this repository and is written from the published formats: the
gyro's frame, the base's ASCII-hex exchange, and the mission protocol (controller/src/mission.rs). With
`--slip` it takes clockwise for positive, everywhere and without a contradiction that it could notice. With
`--listen` it takes its missions from the first client of a socket, and ends when that leaves.
"""

import argparse
import json
import math
import queue
import socket
import sys
import threading
import time

import serial

from base import Base
from gyro import Gyro

PERIOD_S = 0.027
STEERING_GAIN = 1.2  # 1/s, from heading error to steering rate
APPROACH = 1.0  # 1/s, from what is left to the speed near the end: a late command overshoots little
BRAKING = 0.18  # m/s^2, less than the 0.25 that the base ramps by
TURN_BRAKING = math.radians(14.0)  # rad/s^2, less than its 21 deg/s^2
ARRIVED_M = 0.001
ARRIVED_RAD = math.radians(0.05)
CREEP = 0.01  # m/s
CREEP_TURN = math.radians(0.6)  # rad/s
LIMIT_S = 60.0
STATE_PERIOD_S = {True: 0.1, False: 1.0}


class Aborted(Exception):
    """A mission that is broken off, and why in the protocol's words."""


class Controller:
    def __init__(self, gyro, base, sign):
        self.gyro, self.base, self.sign = gyro, base, sign
        self.began = time.monotonic_ns()
        self.missions = queue.Queue()
        self.bias = 0.0
        self.integrating = False
        self.heading = 0.0
        self.x = self.y = 0.0
        self.odometry = 0.0
        self.motion = None
        self.command = (0.0, 0.0)
        self.running = None
        self.activity = "idle"
        self.state_at = 0.0
        self.raw = (0.0, 0)
        self.level = None
        self.pose_counter = 0

    # What it tells.

    def tell(self, report):
        line = {"at_ns": time.monotonic_ns() - self.began, "report": report}
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()

    def pose(self):
        return {"x_m": self.x, "y_m": self.y, "heading_rad": self.heading}

    def health(self):
        silent = {"gyro_silent": self.gyro.is_silent(), "base_silent": self.motion is None}
        level = "fault" if any(silent.values()) else "ok"
        return {"level": level, "causes": {name: True for name, set_ in silent.items() if set_}}

    def tell_state(self):
        total, count = self.raw
        self.raw = (0.0, 0)
        self.tell(
            {
                "state": {
                    "activity": self.activity,
                    "pose": self.pose(),
                    "gyro_heading_rad": self.heading,
                    "odometry_heading_rad": self.odometry,
                    "displacement_m": self.motion.displacement if self.motion else 0.0,
                    "raw_rate_rad_per_s": total / count if count else 0.0,
                    "bias_rad_per_s": self.bias,
                    "temperature_celsius": self.gyro.temperature,
                    "moving": self.motion.moving if self.motion else True,
                    "samples": self.gyro.samples,
                    "samples_lost": self.gyro.lost,
                    "health": self.health(),
                }
            }
        )

    # What it does in each period.

    def sense(self):
        for rate, seconds in self.gyro.new():
            rate *= self.sign
            self.raw = (self.raw[0] + rate, self.raw[1] + 1)
            if self.integrating:
                self.heading += (rate - self.bias) * seconds
            if self.running and self.activity == "bias_test":
                self.readings.append(rate)
        before, self.motion = self.motion, self.base.read_motion() or self.motion
        if before and self.motion:
            path = self.motion.displacement - before.displacement
            self.x += path * math.cos(self.heading)
            self.y += path * math.sin(self.heading)
            turned = math.remainder(self.motion.heading - before.heading, math.tau)
            self.odometry += self.sign * turned

    def period(self):
        self.sense()
        if self.command != (0.0, 0.0):
            drive, steer = self.command
            self.base.set_velocity(drive, self.sign * steer)
        health = self.health()
        if health["level"] != self.level:
            self.level = health["level"]
            self.tell({"health": health})
        now = time.monotonic()
        if now >= self.state_at:
            self.state_at = now + STATE_PERIOD_S[self.running is not None]
            self.tell_state()

    # Missions: each is a generator that goes on once a period.

    def bias_test(self, duration_s=20.0):
        self.activity, self.readings = "bias_test", []
        until = time.monotonic() + duration_s
        while time.monotonic() < until:
            yield
        count = len(self.readings)
        if count < 2:
            raise Aborted("gyro_silent")
        mean = sum(self.readings) / count
        spread = math.sqrt(sum((rate - mean) ** 2 for rate in self.readings) / (count - 1))
        self.bias = mean
        return {
            "bias_test": {
                "mean_rad_per_s": mean,
                "spread_rad_per_s": spread,
                "samples": count,
                "temperature_celsius": self.gyro.temperature,
            }
        }

    def settle(self):
        self.activity, self.command = "settling", (0.0, 0.0)
        self.base.stop()
        yield
        yield
        while self.motion.moving:
            yield
        # The gyro's last samples are still on their line.
        for _ in range(4):
            yield

    def straight(self, distance_m, speed_m_per_s):
        self.integrating = True
        start, reference = self.motion.displacement, self.heading
        began, worst = time.monotonic_ns(), 0.0
        while abs(left := distance_m - (self.motion.displacement - start)) > ARRIVED_M:
            self.activity = "straight_prescribed"
            braking = min(APPROACH * abs(left), math.sqrt(2.0 * BRAKING * abs(left)))
            speed = min(speed_m_per_s, max(CREEP, braking))
            error = reference - self.heading
            worst = max(worst, abs(error))
            self.command = (math.copysign(speed, left), STEERING_GAIN * error)
            self.guard(began)
            yield
        yield from self.settle()
        self.integrating = False
        writes = yield from self.download()
        return {
            "straight": {
                "stop_error_m": self.motion.displacement - start - distance_m,
                "heading_error_max_rad": worst,
                "heading_error_rad": self.heading - reference,
                "duration_ns": time.monotonic_ns() - began,
                "pose_writes": writes,
                "pose": self.pose(),
            }
        }

    def turn(self, angle_rad, rate_rad_per_s):
        self.integrating = True
        start, odometry, began = self.heading, self.odometry, time.monotonic_ns()
        while abs(left := angle_rad - (self.heading - start)) > ARRIVED_RAD:
            self.activity = "turn_prescribed"
            braking = min(APPROACH * abs(left), math.sqrt(2.0 * TURN_BRAKING * abs(left)))
            rate = min(rate_rad_per_s, max(CREEP_TURN, braking))
            self.command = (0.0, math.copysign(rate, left))
            self.guard(began)
            yield
        yield from self.settle()
        self.integrating = False
        turned = self.heading - start
        return {
            "turn": {
                "stop_error_rad": turned - angle_rad,
                "gyro_angle_rad": turned,
                "odometry_angle_rad": self.odometry - odometry,
                "duration_ns": time.monotonic_ns() - began,
            }
        }

    def set_pose(self, x_m, y_m, heading_rad):
        self.x, self.y, self.heading = x_m, y_m, heading_rad
        yield from self.download()
        return "applied"

    def download(self):
        """Writes the pose to the base until it says that it has it."""
        self.activity = "pose_download"
        for attempt in range(1, 6):
            self.pose_counter = (self.pose_counter + 1) % 4
            heading = self.sign * self.heading
            self.base.write_pose(self.x, self.sign * self.y, heading, self.pose_counter)
            for _ in range(3):
                yield
                accepted = self.motion.pose_result == 1
                if accepted and self.motion.pose_counter == self.pose_counter:
                    return attempt
        raise Aborted("pose_write_refused")

    def guard(self, began_ns):
        if self.gyro.is_silent():
            raise Aborted("gyro_silent")
        if self.motion.timed_out:
            raise Aborted("base_command_timeout")
        if time.monotonic_ns() - began_ns > LIMIT_S * 1e9:
            raise Aborted("timed_out")

    # Who is told what.

    def begin(self, mission):
        number, command = mission["id"], mission["command"]
        if command == "stop":
            self.base.stop()
            self.command = (0.0, 0.0)
            if self.running:
                self.finish("aborted", {"id": self.running[0], "reason": "stopped"})
            self.tell({"done": {"id": number, "result": "applied"}})
        elif command == "request_state":
            self.tell_state()
            self.tell({"done": {"id": number, "result": "applied"}})
        elif self.running:
            self.tell({"refused": {"id": number, "reason": "busy"}})
        elif self.motion is None or self.gyro.is_silent():
            reason = "no_base" if self.motion is None else "no_gyro"
            self.tell({"refused": {"id": number, "reason": reason}})
        else:
            ((name, arguments),) = command.items()
            missions = {
                "bias_test": self.bias_test,
                "straight": self.straight,
                "turn": self.turn,
                "set_pose": self.set_pose,
            }
            if name in missions:
                self.running = (number, missions[name](**arguments))
            else:
                self.tell({"refused": {"id": number, "reason": "out_of_range"}})

    def go_on(self):
        number, steps = self.running
        try:
            next(steps)
        except StopIteration as end:
            self.finish("done", {"id": number, "result": end.value})
        except Aborted as why:
            self.base.stop()
            self.finish("aborted", {"id": number, "reason": str(why)})

    def finish(self, how, what):
        self.running, self.activity = None, "idle"
        self.command, self.integrating = (0.0, 0.0), False
        self.tell_state()
        self.tell({how: what})

    def run(self):
        threading.Thread(target=self.read_missions, daemon=True).start()
        # Both devices are heard before the first mission is taken.
        deadline = time.monotonic() + 8.0
        while (self.motion is None or self.gyro.is_silent()) and time.monotonic() < deadline:
            self.period()
        while True:
            due = time.monotonic() + PERIOD_S
            self.period()
            try:
                while True:
                    mission = self.missions.get_nowait()
                    if mission is None:
                        self.base.stop()
                        return
                    self.begin(mission)
            except queue.Empty:
                pass
            if self.running:
                self.go_on()
            time.sleep(max(0.0, due - time.monotonic()))

    def read_missions(self):
        for line in sys.stdin:
            self.missions.put(json.loads(line))
        self.missions.put(None)


def accept(place):
    """Waits for a client, who takes the place of stdin and stdout."""
    kind, address = place.split(":", 1)
    if kind == "unix":
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(address)
    else:
        host, port = address.rsplit(":", 1)
        listener = socket.create_server((host, int(port)))
    listener.listen()
    client, _ = listener.accept()
    sys.stdin, sys.stdout = client.makefile("r"), client.makefile("w")


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("--gyro", required=True)
    arguments.add_argument("--base", required=True)
    arguments.add_argument("--slip", choices=["clockwise-positive"])
    arguments.add_argument("--listen")
    told = arguments.parse_args()
    gyro = Gyro(serial.Serial(told.gyro, 9600, timeout=0.2))
    base = Base(serial.Serial(told.base, 19200, timeout=0.15))
    if told.listen:
        accept(told.listen)
    Controller(gyro, base, -1.0 if told.slip else 1.0).run()


if __name__ == "__main__":
    main()
