"""Rows of a bus log by python-can: `read FILE` prints them, `write FILE` takes them from stdin.

A row is `micros channel kind identifier flags dlc data direction`; an error frame has its time alone.
"""

import sys

from can import Message
from can.io import ASCReader, ASCWriter, CanutilsLogReader, CanutilsLogWriter


def row(message):
    micros = round(message.timestamp * 1e6)
    if message.is_error_frame:
        return f"{micros} - error - 0 0 - -"
    channel = message.channel if isinstance(message.channel, str) else f"can{message.channel}"
    kind = "fd" if message.is_fd else "remote" if message.is_remote_frame else "data"
    identifier = f"{message.arbitration_id:X}" + ("x" if message.is_extended_id else "")
    flags = message.bitrate_switch | message.error_state_indicator << 1
    data = message.data.hex() or "-"
    direction = "Rx" if message.is_rx else "Tx"
    return f"{micros} {channel} {kind} {identifier} {flags:d} {message.dlc} {data} {direction}"


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
    is_asc = path.endswith(".asc")
    if what == "read":
        # With the date in the head; python-can takes it as local time.
        log = ASCReader(path, relative_timestamp=False) if is_asc else CanutilsLogReader(path)
        for entry in log:
            print(row(entry))
    else:
        with (ASCWriter if is_asc else CanutilsLogWriter)(path) as log:
            for line in sys.stdin:
                log.on_message_received(message(line))


if __name__ == "__main__":
    main()
