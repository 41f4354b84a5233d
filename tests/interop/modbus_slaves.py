"""A master on Modbus RTU, by the package pymodbus: sets two drives on one line, and prints their speeds."""

import json
import sys
import time

from pymodbus.client import ModbusSerialClient

master = ModbusSerialClient(sys.argv[1], baudrate=19200, parity="N", timeout=2)
assert master.connect()
for slave, speed in ((1, 100), (2, 40)):
    assert not master.write_register(200, speed, device_id=slave).isError()
time.sleep(4)
print(json.dumps([master.read_holding_registers(100, count=1, device_id=slave).registers[0] for slave in (1, 2, 1, 2)]))
