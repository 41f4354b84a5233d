"""The interface ``hil`` of python-can: a line of a rig by its name, wherever that is.

    can.Bus(interface="hil", channel="can0")

The same call works in a program under test in virtual time, in one on a bench, and beside a rig that runs on this machine.
What it gives is python-can's own bus of whatever carries the line: SocketCAN, or an adapter that speaks SLCAN.
"""

import os

import can
from can.interfaces.slcan import slcanBus

from hil import lines


class HilBus:
    """Opens the line ``channel``. ``pid`` says of which process, where several rigs run; all else goes to the bus."""

    def __new__(cls, channel: str, pid: int | None = None, **options) -> can.BusABC:
        try:
            line = lines.line(str(channel), pid)
        except lines.NoLine as error:
            raise can.CanInitializationError(str(error)) from None
        if line.kind == "can":
            if line.data_bit_rate is not None:
                options.setdefault("fd", True)
            return can.Bus(interface="socketcan", channel=line.path, ignore_config=True, **options)
        if line.kind == "slcan":
            # SLCAN has no command for other rates; the line keeps its own rate, whatever the client sets.
            if line.bit_rate in slcanBus._BITRATES:
                options.setdefault("bitrate", line.bit_rate)
            # A pty has no bootloader that it could wait for.
            if os.path.realpath(line.path).startswith("/dev/pts/"):
                options.setdefault("sleep_after_open", 0)
            return can.Bus(interface="slcan", channel=line.path, ignore_config=True, **options)
        raise can.CanInitializationError(f"{line.name} is a serial line, at {line.path}")

    @staticmethod
    def _detect_available_configs() -> list[dict]:
        runs = lines.running().items()
        return [
            {"interface": "hil", "channel": name, "pid": pid}
            for pid, found in runs
            for name, line in found.items()
            if line.kind != "serial"
        ]
