"""Writes one data set as CSV and as MDF 4 files of asammdf: `write_measured.py FOLDER`.

Each folder below it is a data package. The numbers of `csv` are those that asammdf gives for the channels; `plain`,
`deflated` and `transposed` have them in channels of several sizes, byte orders and conversions, `columns` and
`columns-deflated` each channel by itself, and `unfinished` in a file that says that nobody finished it.
"""

import csv
import json
import sys
from pathlib import Path

# Apart from the other packages: python-can imports it where it finds it.
sys.path.append(sys.prefix + "/apart")

import numpy as np
from asammdf import MDF, Signal

ROWS = 400
CHANNELS = [
    ("t", "time", "s"),
    ("w", "gyro_rate", "deg/s"),
    ("ref", "reference_rate", "deg/s"),
    ("temp", "temperature", "Cel"),
    ("volts", "auxiliary", "V"),
    ("amps", "auxiliary", "A"),
    ("gain", "auxiliary", "1"),
    ("stage", "auxiliary", "1"),
    ("state", "auxiliary", "1"),
]

count = np.arange(ROWS)
times = count / 50.0
random = np.random.default_rng(1)
turn = np.where((count // 80) % 2 == 0, 20.0, -20.0)


def table(kind, pairs):
    """Value to value: `kind` is whether it interpolates."""
    values = {"interpolation": kind}
    for number, (raw, physical) in enumerate(pairs):
        values |= {f"raw_{number}": float(raw), f"phys_{number}": float(physical)}
    return values


rational = {"P1": 0.0, "P2": 2.0, "P3": 4.0, "P4": 0.0, "P5": 0.01, "P6": 1.0}
names = {"val_0": 0, "text_0": b"off", "val_1": 1, "text_1": b"on", "default_addr": b""}
signals = [
    ("w", (turn * 1.01 + random.normal(0, 0.05, ROWS)), None),
    ("ref", (turn * 100).astype("<i2"), {"a": 0.01, "b": 0.0}),
    ("temp", (200 + count // 4).astype(">u2"), {"a": 0.125, "b": -10.0}),
    ("volts", (12 + 0.5 * np.sin(times)).astype(">f4"), None),
    ("amps", (count % 50).astype("u1"), rational),
    ("gain", (count % 60 - 5).astype("<i4"), table(True, [(0, 1), (10, 2), (50, 3)])),
    ("stage", (count % 5).astype(">i8"), table(False, [(0, 10), (2, 30), (4, 50)])),
    ("state", (count // 100 % 2).astype("u1"), names),
]


def package(folder, path):
    fields = [
        {"name": name, "role": role, "unit": unit} | ({"type": "string"} if name == "state" else {})
        for name, role, unit in CHANNELS
    ]
    resource = {"name": "data", "path": path, "schema": {"fields": fields}}
    (folder / "datapackage.json").write_text(
        json.dumps({"name": "measured", "hil": {"kind": "series"}, "resources": [resource]})
    )


def filled(mdf):
    mdf.append(
        [
            Signal(samples=samples, timestamps=times, name=name, unit=unit, conversion=conversion)
            for (name, samples, conversion), (_, _, unit) in zip(signals, CHANNELS[1:], strict=True)
        ],
        acq_name="imu",
    )
    mdf.groups[0].channels[0].name = "t"
    # What else a logger has: other times, other channels.
    slow = np.arange(10) * 1.0
    mdf.append([Signal(samples=slow * 2, timestamps=slow, name="fuel", unit="l")], acq_name="engine")


def unfinished(path):
    """Marks a file as one whose writer did not come to its end."""
    content = bytearray(path.read_bytes())
    content[:8] = b"UnFinMF "
    content[60] = 1
    path.write_bytes(content)


top = Path(sys.argv[1])
for compression, name in enumerate(["plain", "deflated", "transposed"]):
    folder = top / name
    folder.mkdir()
    package(folder, "data.mf4")
    with MDF(version="4.10") as mdf:
        filled(mdf)
        mdf.save(folder / "data.mf4", overwrite=True, compression=compression)

# Column-oriented storage. asammdf 8.8 asks for these where no array is, and no signal has them.
Signal.axes = Signal.conversions = Signal.units = None
for compression, name in enumerate(["columns", "columns-deflated"]):
    folder = top / name
    folder.mkdir()
    package(folder, "data.mf4")
    with MDF(version="4.20") as mdf:
        mdf._mdf._column_storage = True
        filled(mdf)
        mdf.save(folder / "data.mf4", overwrite=True, compression=compression)
    assert b"##LD" in (folder / "data.mf4").read_bytes()

folder = top / "unfinished"
folder.mkdir()
package(folder, "data.mf4")
(folder / "data.mf4").write_bytes((top / "plain/data.mf4").read_bytes())
unfinished(folder / "data.mf4")

folder = top / "csv"
folder.mkdir()
package(folder, "data.csv")
with MDF(top / "plain/data.mf4") as mdf, (folder / "data.csv").open("w", newline="") as out:
    columns = [list(mdf.get_master(0))]
    for name, _, _ in CHANNELS[1:]:
        columns.append(list(mdf.get(name, group=0).samples))
    writer = csv.writer(out)
    writer.writerow([name for name, _, _ in CHANNELS])
    for row in zip(*columns, strict=True):
        writer.writerow([value.decode() if isinstance(value, bytes) else repr(float(value)) for value in row])
