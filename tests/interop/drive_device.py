"""Commands the oven of `hil new` by python-can and cantools, and says what it heard as a line of JSON."""

import json
import sys
import time

import can
import cantools

interface, channel, dbc = sys.argv[1:4]
messages = cantools.database.load_file(dbc)
command = messages.get_message_by_name("Command")
status = messages.get_message_by_name("Status")
heard = []
with can.Bus(interface=interface, channel=channel, bitrate=500_000) as bus:
    for _ in range(20):
        data = command.encode({"Setpoint": 60, "Enable": 1})
        bus.send(can.Message(arbitration_id=command.frame_id, data=data, is_extended_id=False))
        end = time.monotonic() + 0.1
        while (left := end - time.monotonic()) > 0:
            message = bus.recv(left)
            if message is not None and message.arbitration_id == status.frame_id:
                heard.append(status.decode(message.data))
print(json.dumps({
    "heard": len(heard),
    "first": heard[0]["Temperature"],
    "last": heard[-1]["Temperature"],
    "on": int(heard[-1]["HeaterOn"]),
}))
