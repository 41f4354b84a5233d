"""Where the lines of running rigs are.

A program under test reads them from the variable ``HIL_LINES`` of its environment. Any other program finds them in the files that
running commands keep on this machine, one for each rig, locked for as long as it runs.
"""

import fcntl
import json
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path

VARIABLE = "HIL_LINES"


class NoLine(LookupError):
    """No line of that name, or several."""


@dataclass(frozen=True)
class Line:
    """A line of a rig. Rates are in bit/s, and ``None`` where they are not known."""

    name: str
    #: What a program opens: ``can:can0``, ``slcan:/dev/pts/4``, ``serial:/dev/pts/4``.
    port: str
    bit_rate: int | None = None
    data_bit_rate: int | None = None
    baud: int | None = None

    @property
    def kind(self) -> str:
        """``can``, ``slcan`` or ``serial``."""
        return self.port.partition(":")[0]

    @property
    def path(self) -> str:
        """The interface, or the path of the port."""
        return self.port.partition(":")[2]


def line(name: str, pid: int | None = None) -> Line:
    """The line of that name: of the rig that this program is part of, else of the one that runs on this machine.

    ``pid`` says of which process, where several have such a line.
    """
    told = os.environ.get(VARIABLE)
    if told is not None and pid is None:
        lines = read(told)
        if name not in lines:
            raise NoLine(f"no line {name!r} in this rig; lines: {', '.join(lines) or 'none'}")
        return lines[name]
    runs = running()
    found = {at: lines[name] for at, lines in runs.items() if name in lines and pid in (None, at)}
    if len(found) == 1:
        return next(iter(found.values()))
    if found:
        raise NoLine(f"several rigs have a line {name!r}: give pid, one of {', '.join(map(str, found))}")
    if pid is not None and pid not in runs:
        raise NoLine(f"process {pid} runs no rig on this machine")
    there = sorted({other for at, lines in runs.items() for other in lines if pid in (None, at)})
    known = f"lines that are there: {', '.join(there)}" if there else "no rig runs on this machine"
    raise NoLine(f"no line {name!r} is to be found; {known}")


def running() -> dict[int, dict[str, Line]]:
    """The lines of all rigs of this user that run on this machine, by the number of the process."""
    found = {}
    for path in folder().glob("*.json"):
        try:
            with path.open(encoding="utf-8") as file:
                if not _is_kept(file):
                    continue
                pid = int(path.stem.partition("-")[0])
                found.setdefault(pid, {}).update(read(file.read()))
        except (OSError, ValueError):
            # It has ended, or just begins.
            continue
    return found


def folder() -> Path:
    """Where running commands keep their files."""
    runtime = os.environ.get("XDG_RUNTIME_DIR")
    return Path(runtime, "hil") if runtime else Path(tempfile.gettempdir(), f"hil-{os.getuid()}")


def read(document: str) -> dict[str, Line]:
    """The lines of such a document."""
    known = Line.__dataclass_fields__
    entries = json.loads(document).items()
    return {
        name: Line(name=name, **{key: value for key, value in entry.items() if key in known})
        for name, entry in entries
    }


def written(lines: dict[str, Line]) -> str:
    """The document of these lines."""
    keys = ("port", "bit_rate", "data_bit_rate", "baud")
    fields = {name: {key: getattr(one, key) for key in keys} for name, one in lines.items()}
    return json.dumps(fields)


def _is_kept(file) -> bool:
    """Whoever keeps it has it locked."""
    try:
        fcntl.flock(file, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    return False
