"""Rows of an MDF4 file by asammdf: `read FILE` prints them, `write FILE` takes them from stdin.

A row is as in python_can_rows.py. `write` compresses by deflate, `write-transposed` after it turned rows into columns, and
`write-plain` not.
"""

import datetime
import sys

# Apart from the other packages: python-can imports it where it finds it.
sys.path.append(sys.prefix + "/apart")

import numpy as np
from asammdf import MDF, Signal
from asammdf.blocks.source_utils import Source
from asammdf.blocks import v4_constants as v4c

CODES = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64]
COMPRESSION = {"write-plain": 0, "write": 1, "write-transposed": 2}
SOURCE = Source("CAN", "CAN", "", v4c.SOURCE_BUS, v4c.BUS_TYPE_CAN)
FIELDS = [
    ("BusChannel", "<u1"),
    ("ID", "<u4"),
    ("IDE", "<u1"),
    ("DLC", "<u1"),
    ("DataLength", "<u1"),
    ("Dir", "<u1"),
    ("EDL", "<u1"),
    ("BRS", "<u1"),
    ("ESI", "<u1"),
    ("DataBytes", "(64,)u1"),
]
KINDS = {"CAN_DataFrame": 10, "CAN_RemoteFrame": 6, "CAN_ErrorFrame": 1}


def rows(mdf, group):
    names = [channel.name for channel in group.channels]
    kind = next(kind for kind in KINDS if kind in names)
    index = mdf.groups.index(group)
    began = round(mdf.header.start_time.timestamp() * 1e6)
    times = [began + round(time * 1e6) for time in mdf.get(kind, group=index, raw=True).timestamps]
    values = {name.split(".")[-1]: mdf.get(name, group=index, raw=True).samples for name in names if "." in name}
    for at, time in enumerate(times):
        value = {name: samples[at] for name, samples in values.items()}
        if kind == "CAN_ErrorFrame":
            yield time, f"{time} - error - 0 0 - -"
            continue
        identifier = f"{value['ID']:X}" + ("x" if value["IDE"] else "")
        direction = "Tx" if value["Dir"] else "Rx"
        channel = f"can{value['BusChannel'] - 1}"
        if kind == "CAN_RemoteFrame":
            yield time, f"{time} {channel} remote {identifier} 0 {value['DLC']} - {direction}"
            continue
        data = bytes(value["DataBytes"][: value["DataLength"]])
        flags = int(value["BRS"]) | int(value["ESI"]) << 1
        kind_of = "fd" if value["EDL"] else "data"
        assert CODES[value["DLC"]] == len(data)
        yield time, f"{time} {channel} {kind_of} {identifier} {flags} {len(data)} {data.hex() or '-'} {direction}"


def read(path):
    with MDF(path) as mdf:
        every = [row for group in mdf.groups if group.channel_group.cycles_nr for row in rows(mdf, group)]
        # What asammdf itself takes for frames of a bus.
        logged = {(f"can{bus - 1}", number) for bus, ids in mdf.bus_logging_map["CAN"].items() for number in ids}
        words = [row.split() for _, row in every]
        framed = {(word[1], int(word[3].rstrip("x"), 16)) for word in words if word[2] in ("data", "fd")}
        assert logged == framed, (logged, framed)
        for _, row in sorted(every, key=lambda row: row[0]):
            print(row)


def write(path, compression):
    taken = {kind: ([], []) for kind in KINDS}
    began = None
    for row in sys.stdin:
        time, channel, kind, identifier, flags, dlc, data, direction = row.split()
        began = began or int(time)
        name = {"error": "CAN_ErrorFrame", "remote": "CAN_RemoteFrame"}.get(kind, "CAN_DataFrame")
        data = bytes.fromhex(data.strip("-"))
        bus = int(channel.removeprefix("can")) + 1 if kind != "error" else 1
        number = 0 if kind == "error" else int(identifier.rstrip("x"), 16)
        record = (
            bus,
            number,
            int(identifier.endswith("x")),
            CODES.index(int(dlc)),
            len(data),
            int(direction == "Tx"),
            int(kind == "fd"),
            int(flags) & 1,
            int(flags) >> 1,
            list(data.ljust(64, b"\0")),
        )
        times, records = taken[name]
        times.append((int(time) - began) / 1e6)
        records.append(record)
    with MDF(version="4.10") as mdf:
        mdf.header.start_time = datetime.datetime.fromtimestamp(began / 1e6, datetime.timezone.utc)
        for kind, (times, records) in taken.items():
            fields = [(f"{kind}.{name}", kind_of) for name, kind_of in FIELDS[: KINDS[kind]]]
            samples = np.array([record[: len(fields)] for record in records], dtype=fields)
            mdf.append(Signal(samples=samples, timestamps=np.array(times), name=kind, source=SOURCE))
        mdf.save(path, overwrite=True, compression=compression)


if __name__ == "__main__":
    what, path = sys.argv[1:]
    if what == "read":
        read(path)
    else:
        write(path, COMPRESSION[what])
