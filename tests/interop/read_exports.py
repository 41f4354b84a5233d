"""Reads an export of a run with the packages that other people use: pandas, pyarrow, and the official reader of MCAP.

    read_exports.py PARQUET_DIR CSV_DIR FILE.mcap

Prints one line of JSON: rows a table, tables that differ between Parquet and CSV, messages a topic, and whether the times
of the messages ascend.
"""

import json
import sys
import warnings
from collections import Counter
from pathlib import Path

import pandas as pd
import pyarrow.parquet as pq
from mcap.reader import make_reader

# pandas 4 will read numbers exactly without being told.
warnings.filterwarnings("ignore", message=".*float_precision.*")

parquet, csv, mcap = map(Path, sys.argv[1:])


def same(a: pd.DataFrame, b: pd.DataFrame) -> bool:
    if list(a.columns) != list(b.columns) or len(a) != len(b):
        return False
    there = {name: a[name].notna() for name in a.columns}
    return all(
        there[name].equals(b[name].notna())
        and a[name][there[name]].tolist() == b[name][there[name]].tolist()
        for name in a.columns
    )


rows, differ, units = {}, [], {}
for file in sorted(parquet.glob("*.parquet")):
    one = pd.read_parquet(file)
    # The slower of the two readers of floating-point numbers is exact.
    other = pd.read_csv(
        csv / f"{file.stem}.csv", keep_default_na=False, na_values=[""], float_precision="round_trip"
    )
    rows[file.stem] = len(one)
    if not same(one, other):
        differ.append(file.stem)
    columns = json.loads(pq.read_schema(file).metadata[b"hil.columns"])
    units[file.stem] = {name: column["unit"] for name, column in columns.items()}

topics, last, ascending = Counter(), 0, True
with mcap.open("rb") as stream:
    reader = make_reader(stream, validate_crcs=True)
    # As they stand in the file: an order that the reader makes would prove nothing.
    for _schema, channel, message in reader.iter_messages(log_time_order=False):
        json.loads(message.data)
        topics[channel.topic] += 1
        ascending = ascending and message.log_time >= last
        last = message.log_time
    attached = {one.name: len(one.data) for one in reader.iter_attachments()}
    facts = {one.name: one.metadata for one in reader.iter_metadata()}

print(
    json.dumps(
        {
            "rows": rows,
            "differ": differ,
            "units": units,
            "topics": topics,
            "ascending": ascending,
            "attached": attached,
            "facts": facts,
        }
    )
)
