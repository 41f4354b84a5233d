"""A controller with python-can: a thread listens, the main thread tells, and the kernel sends a frame of its own."""

import struct
import threading
import time

import can

bus = can.Bus(interface="socketcan", channel="can0", can_filters=[{"can_id": 0x181, "can_mask": 0x7FF}])
lock = threading.Lock()
seen = {"count": 0, "last": 0.0}
arrived = threading.Event()


class Listener(can.Listener):
    def on_message_received(self, message):
        with lock:
            seen["count"] += 1
            seen["last"] = message.timestamp
        arrived.set()


notifier = can.Notifier(bus, [Listener()], timeout=0.5)
bus.send_periodic(can.Message(arbitration_id=0x701, data=b"\x05", is_extended_id=False), 1.0)
start = time.time()
while True:
    arrived.wait(0.25)
    arrived.clear()
    with lock:
        count, last = seen["count"], seen["last"]
    age_us = int((time.time() - last) * 1e6) if count else 0
    data = struct.pack(">II", count, age_us & 0xFFFFFFFF)
    bus.send(can.Message(arbitration_id=0x201, data=data, is_extended_id=False))
