"""The master of a rotary table with a CiA 402 drive, by the package canopen: SDO in all directions and with its aborts, PDOs by
events and by SYNC, another mapping at run time, heartbeat, emergencies, NMT. Says by its target position that all was right.

usage: canopen_master.py CHANNEL EDS     (needs canopen and python-can)
"""

import struct
import sys
import time

import canopen

NODE = 5
SAID = 12_500  # thousandths of a degree

network = canopen.Network()
network.connect(interface="socketcan", channel=sys.argv[1])
node = network.add_node(canopen.RemoteNode(NODE, sys.argv[2]))
sdo = node.sdo


def aborted(code, action):
    try:
        action()
    except canopen.SdoAbortedError as error:
        assert error.code == code, f"{error.code:#010x}, expected {code:#010x}"
    else:
        raise AssertionError(f"no abort, expected {code:#010x}")


def write(index, sub, data):
    return lambda: sdo.download(index, sub, data)


def until(condition, limit_s=2.0):
    end = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < end, "it did not come in time"
        time.sleep(0.005)


def status():
    return node.tpdo[1]["Statusword"].raw


# Heartbeat and boot-up.
node.nmt.send_command(129)
node.nmt.wait_for_bootup(2)
assert node.nmt.wait_for_heartbeat(2) == "PRE-OPERATIONAL"

# SDO: every object that can be read is what the EDS says, expedited and in segments.
read = 0
for entry in node.object_dictionary.values():
    for variable in [entry] if isinstance(entry, canopen.objectdictionary.ODVariable) else entry.values():
        if variable.default is None or variable.index in (0x6041, 0x1001):
            continue
        if variable.index == 0x1003 and variable.subindex > 0:
            aborted(0x08000024, lambda: sdo.upload(variable.index, variable.subindex))
            continue
        value = variable.decode_raw(sdo.upload(variable.index, variable.subindex))
        assert value == variable.default, f"{variable.name}: {value}, expected {variable.default}"
        read += 1
assert read > 60, read
assert sdo["Manufacturer device name"].raw == "Rotary table"

# What CiA 301 says about mistakes.
aborted(0x06020000, lambda: sdo.upload(0x7000, 0))
aborted(0x06090011, lambda: sdo.upload(0x1018, 9))
aborted(0x06010002, write(0x1000, 0, bytes(4)))
aborted(0x06070012, write(0x6060, 0, bytes(2)))
aborted(0x06070013, write(0x607A, 0, bytes(2)))
aborted(0x06090031, write(0x6060, 0, b"\x04"))
aborted(0x06090032, write(0x6060, 0, b"\x00"))
aborted(0x06070012, write(0x607A, 0, bytes(20)))
aborted(0x06010000, write(0x1A00, 0, b"\x00"))
aborted(0x05040001, lambda: sdo.open(0x1008, 0, "rb", block_transfer=True))

# PDOs: read, another mapping written, events and SYNC.
node.tpdo.read()
node.rpdo.read()
assert [variable.index for variable in node.tpdo[1]] == [0x6041, 0x6061]
assert [variable.index for variable in node.tpdo[2]] == [0x6064, 0x606C]
pdo = node.tpdo[2]
pdo.clear()
pdo.add_variable(0x606C)
pdo.add_variable(0x6041)
pdo.add_variable(0x6061)
pdo.trans_type = 2
pdo.enabled = True
pdo.save()
assert sdo[0x1A01][0].raw == 3 and sdo[0x1A01][2].raw == 0x60410010
lengths = []
pdo.add_callback(lambda message: lengths.append(len(message.data)))
sdo["Producer heartbeat time"].raw = 50
node.emcy.reset()

node.nmt.state = "OPERATIONAL"
until(lambda: status() & 0x6F == 0x40)
for control, wanted in ((6, 0x21), (7, 0x23), (15, 0x27)):
    node.rpdo[1]["Controlword"].raw = control
    node.rpdo[1].transmit()
    until(lambda: status() & 0x6F == wanted)
sdo["Modes of operation"].raw = 3
node.rpdo[3]["Target velocity"].raw = 20_000
node.rpdo[3].transmit()
network.sync.start(0.01)
until(lambda: abs(pdo["Velocity actual value"].raw - 20_000) < 100)
network.sync.stop()
assert set(lengths) == {7}, lengths
count = len(lengths)
for _ in range(6):
    network.sync.transmit()
    time.sleep(0.01)
assert len(lengths) == count + 3, "every second SYNC"
assert pdo["Statusword"].raw & 0x6F == 0x27

# A heartbeat that fails to come: the device says so and leaves the operational state.
sdo[0x1016][1].raw = (1 << 16) + 100
network.send_message(0x701, b"\x05")
error = node.emcy.wait(0x8130, timeout=2)
assert error is not None and error.register == 0x11, error
until(lambda: node.nmt.state == "PRE-OPERATIONAL")
assert sdo[0x1003][0].raw == 1 and sdo[0x1003][1].raw == 0x8130
aborted(0x06090030, write(0x1003, 0, b"\x01"))
sdo[0x1003][0].raw = 0
assert sdo[0x1003][0].raw == 0
network.send_message(0x701, b"\x05")
until(lambda: any(error.code == 0 for error in node.emcy.log))
assert sdo[0x1001].raw == 0
sdo[0x1016][1].raw = 0

# Reset of the communication: the mapping is that of the EDS again, the application goes on.
node.nmt.send_command(130)
node.nmt.wait_for_bootup(2)
assert sdo[0x1A01][0].raw == 2
assert sdo["Modes of operation"].raw == 3

# Stopped: no SDO.
node.nmt.state = "STOPPED"
sdo.RESPONSE_TIMEOUT = 0.1
sdo.MAX_RETRIES = 1
try:
    sdo.upload(0x1000, 0)
except canopen.SdoCommunicationError:
    pass
else:
    raise AssertionError("a stopped device answers")

node.nmt.state = "OPERATIONAL"
while True:
    node.rpdo[2]["Target position"].raw = SAID
    node.rpdo[2].transmit()
    time.sleep(0.1)
