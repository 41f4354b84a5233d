"""A controller with python-can and asyncio."""

import asyncio
import struct

import can


async def main():
    bus = can.Bus(interface="socketcan", channel="can0")
    reader = can.AsyncBufferedReader()
    loop = asyncio.get_running_loop()
    notifier = can.Notifier(bus, [reader], loop=loop)
    count = 0
    while True:
        try:
            message = await asyncio.wait_for(reader.get_message(), 0.015)
            count += 1
            data = struct.pack(">IH", count, message.arbitration_id)
        except asyncio.TimeoutError:
            data = struct.pack(">Q", int(loop.time() * 1e9))
        bus.send(can.Message(arbitration_id=0x202, data=data, is_extended_id=False))
        await asyncio.sleep(0.001)


asyncio.run(main())
