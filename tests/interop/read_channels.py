"""Reads the measured channels of a run with asammdf, and holds them against the run's tables: `read_channels.py FILE.mf4 CSV_DIR`.

Prints one line of JSON: records a group, channels that differ from the tables, units, and the file's comment.
"""

import json
import math
import sys
import warnings
from pathlib import Path

# Apart from the other packages: python-can imports it where it finds it.
sys.path.append(sys.prefix + "/apart")

import pandas as pd
from asammdf import MDF

# pandas 4 will read numbers exactly without being told.
warnings.filterwarnings("ignore", message=".*float_precision.*")

path, tables = sys.argv[1], Path(sys.argv[2])


def table(name):
    file = tables / f"{name}.csv"
    return pd.read_csv(file, keep_default_na=False, na_values=[""], float_precision="round_trip")


def plain(value):
    return value.decode() if isinstance(value, bytes) else value.item() if hasattr(value, "item") else value


def values(mdf, group, name):
    """Values, with None where one is missing."""
    # Without this asammdf leaves out what is missing.
    signal = mdf.get(name, group=group, raw=name in named.get(group, ()), ignore_invalidation_bits=True)
    invalid = signal.invalidation_bits
    missing = [False] * len(signal) if invalid is None else [bool(bit) for bit in invalid]
    return [None if gone else plain(value) for gone, value in zip(missing, signal.samples, strict=True)]


def same(found, column):
    gone = [isinstance(value, float) and math.isnan(value) for value in column]
    # pandas takes a column of texts like `1` for numbers.
    as_found = str if any(isinstance(value, str) for value in found) else plain
    return found == [None if missing else as_found(value) for missing, value in zip(gone, column, strict=True)]


rows, differ, units, names, named = {}, [], {}, {}, {}


def compare(mdf, group, title, frame, columns):
    rows[title] = mdf.groups[group].channel_group.cycles_nr
    times = list(mdf.get_master(group))
    if times != frame["time_s"].tolist():
        differ.append(f"{title}: times")
    for channel, column in columns.items():
        if not same(values(mdf, group, channel), column):
            differ.append(f"{title}: {channel}")


with MDF(path) as mdf:
    for group, one in enumerate(mdf.groups):
        title = one.channel_group.acq_name
        channels = [channel.name for channel in one.channels[1:]]
        units[title] = {channel.name: channel.unit for channel in one.channels}
        # A signal's names of values are checked apart: tables have its numbers.
        if title.startswith("messages/"):
            named[group] = {channel.name for channel in one.channels if channel.conversion}
            for name in named[group]:
                names[f"{title}.{name}"] = sorted({plain(value) for value in mdf.get(name, group=group).samples}, key=str)
        if title.startswith("observations/"):
            quantity = title.removeprefix("observations/")
            frame = table("observations")
            frame = frame[frame["quantity"] == quantity]
            compare(mdf, group, title, frame, {name: frame[name] for name in channels})
        elif title.startswith("messages/"):
            sender, _, message = title.removeprefix("messages/").rpartition(".")
            signals = table("signals")
            signals = signals[(signals["device"] == sender) & (signals["message"] == message)]
            for name in channels:
                signal = signals[signals["signal"] == name]
                # A message that does not carry a signal has no row of it.
                there = [value for value in values(mdf, group, name) if value is not None]
                if there != signal["value"].tolist():
                    differ.append(f"{title}: {name}")
            rows[title] = one.channel_group.cycles_nr
        else:
            frame = table(title)
            compare(mdf, group, title, frame, {name: frame[name] for name in channels})
    comment = mdf.header.comment
    facts = {key: str(value) for key, value in mdf.header._common_properties.items()}

print(json.dumps({"rows": rows, "differ": differ, "units": units, "names": names, "comment": comment, "facts": facts}))
