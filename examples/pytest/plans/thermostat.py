"""The program under test: keeps the oven at a temperature. It knows its line by name, wherever that is."""

import time
from pathlib import Path

import can
import cantools

SETPOINT = 60  # degC
PERIOD_S = 0.1

MESSAGES = cantools.database.load_file(Path(__file__).parent / "devices/oven.dbc")
COMMAND = MESSAGES.get_message_by_name("Command")
STATUS = MESSAGES.get_message_by_name("Status")


def control(bus):
    heats = False
    due = time.monotonic()
    while True:
        message = bus.recv(max(0, due - time.monotonic()))
        if message is not None and message.arbitration_id == STATUS.frame_id:
            # Not before the oven has spoken.
            heats = STATUS.decode(message.data)["Temperature"] < 100
        if time.monotonic() >= due:
            due += PERIOD_S
            data = COMMAND.encode({"Setpoint": SETPOINT, "Enable": heats})
            bus.send(can.Message(arbitration_id=COMMAND.frame_id, data=data, is_extended_id=False))


if __name__ == "__main__":
    with can.Bus(interface="hil", channel="can0") as bus:
        control(bus)
