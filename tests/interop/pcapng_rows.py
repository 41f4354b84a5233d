"""Rows of a capture by python-pcapng: `read FILE` prints them, `write FILE` takes them from stdin.

A row is as in python_can_rows.py. Captures are written in the byte order of the big end, with times in
microseconds; the packets are those of LINKTYPE_CAN_SOCKETCAN (tcpdump.org/linktypes).
"""

import struct
import sys
from decimal import Decimal

import pcapng
from pcapng import blocks

CAN_SOCKETCAN = 227
EXTENDED, REMOTE, ERROR = 1 << 31, 1 << 30, 1 << 29
BUS_ERROR = 0x80
FDF = 4


def row(block):
    assert block.interface.link_type == CAN_SOCKETCAN, block.interface.link_type
    micros = round(Decimal(block.timestamp) * 1_000_000)
    raw, length, flags = struct.unpack(">IBB", block.packet_data[:6])
    data = block.packet_data[8:]
    if raw & ERROR:
        return f"{micros} - error - 0 0 - -"
    kind = "fd" if flags & FDF else "remote" if raw & REMOTE else "data"
    assert kind == "remote" or len(data) == length
    identifier = f"{raw & 0x1FFFFFFF:X}" + ("x" if raw & EXTENDED else "")
    direction = {"inbound": "Rx", "outbound": "Tx"}[block.options["epb_flags"].inout]
    channel = block.interface.options["if_name"]
    return f"{micros} {channel} {kind} {identifier} {flags & 3} {length} {data.hex() or '-'} {direction}"


def packet(row):
    _, _, kind, identifier, flags, dlc, data, _ = row.split()
    if kind == "error":
        return struct.pack(">IBBH", ERROR | BUS_ERROR, 8, 0, 0) + bytes(8)
    raw = int(identifier.rstrip("x"), 16) | (EXTENDED if identifier.endswith("x") else 0)
    raw |= REMOTE if kind == "remote" else 0
    flags = int(flags) | (FDF if kind == "fd" else 0)
    return struct.pack(">IBBH", raw, int(dlc), flags, 0) + bytes.fromhex(data.strip("-"))


def write(path):
    section = blocks.SectionHeader(endianness=">")
    interfaces = {}
    with open(path, "wb") as out:
        writer = pcapng.FileWriter(out, section)
        for line in sys.stdin:
            micros, channel, _, _, _, _, _, direction = line.split()
            if channel not in interfaces:
                interfaces[channel] = section.new_member(
                    blocks.InterfaceDescription, link_type=CAN_SOCKETCAN, options={"if_name": channel}
                )
                writer.write_block(interfaces[channel])
            micros = int(micros)
            data = packet(line)
            way = {"Rx": 1, "Tx": 2, "-": 0}[direction]
            block = section.new_member(
                blocks.EnhancedPacket,
                interface_id=interfaces[channel].interface_id,
                timestamp_high=micros >> 32,
                timestamp_low=micros & 0xFFFFFFFF,
                packet_len=len(data),
                packet_data=data,
                options={"epb_flags": way},
            )
            writer.write_block(block)


def read(path):
    with open(path, "rb") as file:
        for block in pcapng.FileScanner(file):
            if isinstance(block, blocks.EnhancedPacket):
                print(row(block))


if __name__ == "__main__":
    {"read": read, "write": write}[sys.argv[1]](sys.argv[2])
