"""Your own program beside the emulated device, in real time. Here the program is a few lines of python-can."""

import time
from pathlib import Path

import can
import cantools
import pytest

MESSAGES = cantools.database.load_file(Path(__file__).parent / "plans/devices/oven.dbc")


@pytest.fixture
def bus(rig):
    rig("plans/rigs/oven.toml")
    with can.Bus(interface="hil", channel="can0") as bus:
        yield bus


def test_the_heater_follows_its_command(bus):
    command, status = (MESSAGES.get_message_by_name(name) for name in ("Command", "Status"))
    data = command.encode({"Setpoint": 60, "Enable": 1})
    order = can.Message(arbitration_id=command.frame_id, data=data, is_extended_id=False)
    bus.send_periodic(order, 0.1)
    deadline = time.monotonic() + 10
    while time.monotonic() < deadline:
        message = bus.recv(1)
        if message is not None and message.arbitration_id == status.frame_id:
            if status.decode(message.data)["HeaterOn"] == 1:
                return
    raise AssertionError("the heater stayed off for 10 s")
