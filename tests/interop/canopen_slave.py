"""A drive that is under test: a CANopen slave by the package canopen, with the EDS of examples/rotary-table.

usage: canopen_slave.py CHANNEL EDS      (needs canopen and python-can)
"""

import sys
import time

import canopen

network = canopen.Network()
network.connect(interface="socketcan", channel=sys.argv[1])
node = canopen.LocalNode(5, sys.argv[2])
network.add_node(node)
node.nmt.state = "INITIALISING"
node.nmt.state = "PRE-OPERATIONAL"  # sends the boot-up message
node.nmt.start_heartbeat(100)


def moved(index, subindex, od, data):
    """The drive is where it was sent, at once."""
    if index == 0x607A:
        node.sdo[0x6064].raw = int.from_bytes(data, "little", signed=True)


node.add_write_callback(moved)
while True:
    time.sleep(1)
