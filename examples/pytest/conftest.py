"""Fixtures: the program `hil`, runs of plans, and an emulated device that other programs talk to."""

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent


class Run:
    """A run of a plan: exit status, what was printed, and summary.json."""

    def __init__(self, hil, plan, out, arguments):
        command = [hil, "run", str(plan), "--out", str(out), "--quiet", *arguments]
        done = subprocess.run(command, capture_output=True, text=True, cwd=HERE)
        self.status = done.returncode
        self.printed = done.stdout + done.stderr
        summary = out / "summary.json"
        self.summary = json.loads(summary.read_text()) if summary.exists() else {}
        self.measurements = {one["name"]: one for one in self.summary.get("measurements", [])}


@pytest.fixture(scope="session")
def hil():
    """The path of hil: what the variable HIL says, or the one on PATH."""
    found = shutil.which(os.environ.get("HIL", "hil"))
    if found is None:
        pytest.fail("failed to find hil; put it on PATH, or set HIL=target/release/hil")
    return found


@pytest.fixture(scope="session")
def run(hil):
    """run(plan, *arguments): carries a plan out, once a session. Run folders go below HIL_RUNS, or runs."""
    runs = Path(os.environ.get("HIL_RUNS", "runs")).absolute()
    done = {}

    def run(plan, *arguments):
        key = (plan, *arguments)
        if key not in done:
            name = "-".join([plan.stem, *(word.strip("-") for word in arguments)])
            done[key] = Run(hil, plan, runs / name, arguments)
        return done[key]

    return run


@pytest.fixture
def oven(hil, tmp_path):
    """The oven, emulated behind a CAN adapter (slcan) on a pty, for the time of a test: the path of the pty."""
    pty = tmp_path / "can.pty"
    command = [hil, "emulate", "device", str(HERE / "plans/devices/oven.toml"), "--port", f"slcan-pty:{pty}"]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe, text=True) as emulated:
        ready = json.loads(emulated.stdout.readline())
        assert ready["ready"] == "device"
        yield pty
        emulated.terminate()
        ended = json.loads(emulated.stdout.readlines()[-1])
    assert emulated.returncode == 0, ended
