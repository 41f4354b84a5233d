"""Emulated devices for the time of a ``with``: what ``hil emulate`` does."""

import json
import subprocess
import tempfile
import tomllib
from pathlib import Path

from hil import lines
from hil.programs import program, started


class RigError(RuntimeError):
    """The rig does not start, has ended, or refuses a request."""


class Rig:
    """The emulated devices of a rig file or of a device's own file, on ports, in real time.

    Each line is on a pty, a CAN line behind an adapter (SLCAN) on it; ``ports`` says otherwise for lines by name, as
    ``{"can0": "can:vcan0"}``. A device's own file has one line, ``device``.
    """

    def __init__(self, path, *, ports: dict[str, str] | None = None, seed: int = 1):
        self._asked = 0
        # What it warns of must not stop it where nobody reads.
        self._warnings = tempfile.TemporaryFile(mode="w+", encoding="utf-8")
        pipe = subprocess.PIPE
        words, count = _words(Path(path), ports or {})
        command = [program(), "emulate", *words, "--seed", str(seed)]
        streams = {"stdin": pipe, "stdout": pipe, "stderr": self._warnings}
        self._process = started(command, **streams, text=True, encoding="utf-8")
        #: By name.
        self.lines: dict[str, lines.Line] = {}
        try:
            for _ in range(count):
                self._line()
            self.lines = lines.running()[self._process.pid]
        except KeyError:
            self.stop()
            raise RigError(f"no file of {command[0]} in {lines.folder()}: cannot tell its lines") from None
        except RigError:
            self.stop()
            raise

    def ask(self, **request):
        """Makes a request, as ``docs/emulators.md`` lists them: ``rig.ask(set={"ambient": 30}, device="cells")``."""
        if self._warnings.closed:
            raise RigError("the rig has been stopped")
        self._asked += 1
        try:
            self._process.stdin.write(json.dumps({"id": self._asked, **request}) + "\n")
            self._process.stdin.flush()
        except OSError as error:
            raise RigError(f"the rig has ended: {self._said()}") from error
        answer = self._line()
        if "ok" not in answer:
            raise RigError(answer.get("error") or f"the rig has ended: {self._said()}")
        return answer["ok"]

    @property
    def pid(self) -> int:
        """The number of its process."""
        return self._process.pid

    def stop(self) -> None:
        """Ends it. Once is enough, and again does no harm."""
        if self._process.poll() is None:
            self._process.terminate()
            try:
                self._process.communicate(timeout=10)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.communicate()
        self._warnings.close()

    def __enter__(self) -> "Rig":
        return self

    def __exit__(self, *_) -> None:
        self.stop()

    def _line(self) -> dict:
        line = self._process.stdout.readline()
        if not line:
            self._process.wait()
            raise RigError(f"the rig has ended: {self._said()}")
        return json.loads(line)

    def _said(self) -> str:
        self._warnings.seek(0)
        return self._warnings.read().strip() or f"exit status {self._process.poll()}"


def _words(path: Path, ports: dict[str, str]) -> tuple[list[str], int]:
    """What follows ``hil emulate``, and how many ports there will be."""
    try:
        file = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except OSError as error:
        raise RigError(f"failed to read {path}: {error.strerror}") from None
    except ValueError as error:
        raise RigError(f"{path} is no TOML: {error}") from None
    declared = file.get("line")
    if not isinstance(declared, list):
        if len(ports) > 1 or not set(ports) <= {"device"}:
            raise RigError(f"{path} describes one device, whose line is `device`")
        port = ports.get("device")
        return ["device", str(path), *(["--port", port] if port else [])], 1
    words = ["rig", str(path)]
    names = [one["name"] for one in declared]
    unknown = set(ports) - set(names)
    if unknown:
        raise RigError(f"no line {', '.join(sorted(unknown))} in {path}; lines: {', '.join(names)}")
    for one in declared:
        usual = "slcan-pty" if "can" in one else "pty"
        words += ["--line", f"{one['name']}={ports.get(one['name'], usual)}"]
    return words, len(names)
