"""A master on Modbus RTU, by the package pymodbus: sets the drive of docs/request-and-answer.md and prints what it reads."""

import json
import sys
import time

from pymodbus.client import ModbusSerialClient

# A pty has no parity. Debian's C library returns "Invalid argument" if a program asks for one and changes no other mode.
master = ModbusSerialClient(sys.argv[1], baudrate=19200, parity="N", timeout=2)
assert master.connect()


def read(register):
    answer = master.read_holding_registers(register, count=1, device_id=1)
    assert not answer.isError(), answer
    return answer.registers[0]


before = [read(100), read(101)]
assert not master.write_register(200, 100, device_id=1).isError()
time.sleep(4)
# Again and again, in both orders: the answers look the same.
after = [[read(100), read(101)] for _ in range(10)] + [[read(100), read(101), read(101)][::2] for _ in range(10)]
print(json.dumps({"before": before, "after": after}))
