"""The plugin of pytest: plans are test files, their verdicts are tests; fixtures `rig` and `run`."""

import tomllib
from pathlib import Path

import pytest

from hil import lines
from hil.plans import PlanFile
from hil.programs import program
from hil.rig import Rig
from hil.runs import BAD_INPUT
from hil.runs import run as run_plan


def pytest_addoption(parser):
    group = parser.getgroup("hil", "plans of hil")
    group.addoption("--hil-seed", type=int, metavar="N", help="seed of all random numbers of plans (that of the plan, or 1)")
    group.addoption("--hil-clock", choices=["virtual", "real"], help="what makes time pass (virtual)")
    group.addoption("--hil-bench", metavar="FILE", help="bench file: which port plays which role")
    group.addoption("--hil-runs", metavar="DIR", default="runs", help="folder for run folders (runs)")
    parser.addini("hil_plans", "names of files that may be plans", type="args", default=["*.toml"])


def pytest_report_header(config):
    said = {name: config.getoption(f"hil_{name}") for name in ("seed", "clock", "bench")}
    told = [f"{name} {value}" for name, value in said.items() if value is not None]
    try:
        return ", ".join([f"hil: {program()}", *told])
    except FileNotFoundError as error:
        return f"hil: {error}"


def pytest_ignore_collect(collection_path, config):
    """A run folder is no place for plans, nor is that of a campaign."""
    runs = Path(config.getoption("hil_runs")).absolute()
    return True if collection_path == runs or (collection_path / "campaign.json").is_file() else None


def pytest_collect_file(file_path, parent):
    patterns = parent.config.getini("hil_plans")
    if any(file_path.match(pattern) for pattern in patterns) and is_plan(file_path):
        return PlanFile.from_parent(parent, path=file_path)
    return None


def is_plan(path: Path) -> bool:
    """Has it steps? As `hil` tells plans from what lies beside them: a plan with a mistake is a plan."""
    try:
        text = path.read_bytes().decode("utf-8", "replace")
    except OSError:
        return False
    try:
        return "steps" in tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return any(line.lstrip("[ \t").startswith("steps") for line in text.splitlines())


@pytest.fixture
def run(request, tmp_path_factory):
    """``run(plan, seed=..., clock=..., bench=..., arguments=[...])``: carries a plan out and gives a :class:`hil.Run`.

    The path of the plan is relative to the file of the test, and so is that of the bench file. What is not said is as the options of pytest have it. Run folders are
    in pytest's temporary folder. Bad input, such as a plan that does not exist, fails the test.
    """
    option = request.config.getoption

    def carry_out(plan, *, seed=None, clock=None, bench=None, arguments=()):
        plan = request.path.parent / plan
        # One that ships is called by its name.
        if bench is not None and (str(bench).endswith(".toml") or "/" in str(bench)):
            bench = request.path.parent / bench
        out = tmp_path_factory.mktemp(plan.stem) / "run"
        made = run_plan(
            plan,
            out,
            seed=option("hil_seed") if seed is None else seed,
            clock=clock or option("hil_clock"),
            bench=bench or option("hil_bench"),
            arguments=arguments,
        )
        if made.status == BAD_INPUT:
            pytest.fail(str(made), pytrace=False)
        return made

    return carry_out


@pytest.fixture
def rig(request, monkeypatch):
    """``rig(file, ports=..., seed=...)``: emulates the devices of a rig or of a device's own file until the test ends.

    The file is relative to that of the test. Gives a :class:`hil.Rig`. Its lines are found by name, by this process and those
    that it starts, as ``can.Bus(interface="hil", channel="can0")``.
    """
    started, found = [], {}

    def start(file, *, ports=None, seed=None):
        seed = request.config.getoption("hil_seed") if seed is None else seed
        one = Rig(request.path.parent / file, ports=ports, seed=1 if seed is None else seed)
        started.append(one)
        found.update(one.lines)
        monkeypatch.setenv(lines.VARIABLE, lines.written(found))
        return one

    yield start
    for one in reversed(started):
        one.stop()
