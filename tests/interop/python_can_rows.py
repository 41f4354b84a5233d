"""Rows of a bus log by python-can: `read FILE` prints them, `write FILE` takes them from stdin.

A row is `micros channel kind identifier flags dlc data direction`; an error frame has its time alone.
"""

import sys
from pathlib import Path

from can import Message
from can.io import (
    ASCReader,
    ASCWriter,
    BLFReader,
    BLFWriter,
    CanutilsLogReader,
    CanutilsLogWriter,
    TRCReader,
    TRCWriter,
)

# With the date in the head of an ASC file; python-can takes it as local time.
READERS = {
    ".asc": lambda path: ASCReader(path, relative_timestamp=False),
    ".blf": BLFReader,
    ".log": CanutilsLogReader,
    ".trc": TRCReader,
}
WRITERS = {".asc": ASCWriter, ".blf": BLFWriter, ".log": CanutilsLogWriter, ".trc": TRCWriter}


def row(message, first):
    micros = round(message.timestamp * 1e6)
    if message.is_error_frame:
        return f"{micros} - error - 0 0 - -"
    channel = message.channel if isinstance(message.channel, str) else f"can{message.channel - first}"
    kind = "fd" if message.is_fd else "remote" if message.is_remote_frame else "data"
    identifier = f"{message.arbitration_id:X}" + ("x" if message.is_extended_id else "")
    flags = message.bitrate_switch | message.error_state_indicator << 1
    data = message.data.hex() or "-"
    direction = "Rx" if message.is_rx else "Tx"
    # Of a CAN FD frame in a TRC file python-can has the code there.
    dlc = len(message.data) if message.is_fd else message.dlc
    return f"{micros} {channel} {kind} {identifier} {flags:d} {dlc} {data} {direction}"


def message(row):
    micros, channel, kind, identifier, flags, dlc, data, direction = row.split()
    timestamp = int(micros) / 1e6
    if kind == "error":
        return Message(timestamp=timestamp, is_error_frame=True, channel="can0")
    return Message(
        timestamp=timestamp,
        channel=channel,
        arbitration_id=int(identifier.rstrip("x"), 16),
        is_extended_id=identifier.endswith("x"),
        is_fd=kind == "fd",
        is_remote_frame=kind == "remote",
        bitrate_switch=bool(int(flags) & 1),
        error_state_indicator=bool(int(flags) & 2),
        dlc=int(dlc),
        data=None if kind == "remote" else bytes.fromhex(data.strip("-")),
        is_rx=direction == "Rx",
        check=True,
    )


def main():
    what, path = sys.argv[1:]
    end = Path(path).suffix
    if what == "read":
        # Buses of a TRC file stay as they are there, from 1.
        first = 1 if end == ".trc" else 0
        for entry in READERS[end](path):
            print(row(entry, first))
    else:
        with WRITERS[end](path) as log:
            for line in sys.stdin:
                log.on_message_received(message(line))


if __name__ == "__main__":
    main()
