"""A server of diagnostic requests, by the package can-isotp: an identifier in several frames, a security level, and a routine that
takes its time."""

import sys
import time

import can
import isotp

VIN = b"WPYTHON0000000042"
SEED = bytes([1, 2, 3, 4])

bus = can.Bus(interface="socketcan", channel=sys.argv[1])
address = isotp.Address(isotp.AddressingMode.Normal_11bits, txid=0x7E8, rxid=0x7E0)
stack = isotp.CanStack(bus=bus, address=address, params={"blocksize": 3, "stmin": 2})
stack.start()
while True:
    request = stack.recv(block=True, timeout=1)
    if request is None:
        continue
    match bytes(request):
        case b"\x22\xf1\x90":
            stack.send(b"\x62\xf1\x90" + VIN)
        case b"\x27\x01":
            stack.send(b"\x67\x01" + SEED)
        case b"\x27\x02\xf1\xf2\xf3\xf4":
            stack.send(b"\x67\x02")
        case b"\x31\x01\x02\x03":
            stack.send(b"\x7f\x31\x78")
            time.sleep(2)
            stack.send(b"\x71\x01\x02\x03\x01\x2c")
        case long if long[0] == 0x2E:
            # The length of what came, in several frames.
            stack.send(b"\x6e" + long[1:3] + len(long).to_bytes(2, "big"))
        case other:
            stack.send(bytes([0x7F, other[0], 0x11]))
