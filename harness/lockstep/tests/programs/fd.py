"""A controller with python-can on CAN FD: it answers each long frame with a shorter one, and sends one of its own in turn."""

import can

bus = can.Bus(interface="socketcan", channel="can0", fd=True)
bus.send_periodic(
    can.Message(arbitration_id=0x702, data=bytes(range(24)), is_fd=True, bitrate_switch=True, is_extended_id=False), 0.5
)
while True:
    message = bus.recv()
    if message.is_fd and message.arbitration_id == 0x181:
        data = bytes([message.dlc, message.bitrate_switch, message.data[-1]]) + bytes(9)
        bus.send(can.Message(arbitration_id=0x203, data=data, is_fd=True, is_extended_id=False))
