"""Runs of plans, as objects."""

import json
import subprocess
from dataclasses import dataclass, fields
from pathlib import Path

from hil.programs import program, started

#: What `hil run` exits with where the bench and the plan were in order: passed, failed.
JUDGED = (0, 1)
#: And where a plan, a device file or an argument is wrong.
BAD_INPUT = 2


@dataclass(frozen=True)
class Measurement:
    """A measurement of a run. ``value``, ``lower``, ``upper`` and ``uncertainty`` are in ``unit``."""

    name: str
    #: ``None`` where nothing was measured.
    value: float | None
    unit: str
    lower: float | None
    upper: float | None
    #: ``pass``, ``marginal``, ``fail``, ``unset`` or ``not_judged``.
    verdict: str
    #: What the figure is: ``worst of 80``.
    statistic: str
    #: Standard uncertainty; zero where the value is exact.
    uncertainty: float
    observations: int

    @property
    def passed(self) -> bool:
        return self.verdict in ("pass", "marginal")

    def __bool__(self) -> bool:
        return self.passed

    @property
    def not_judged(self) -> str | None:
        """Why this bench cannot judge it; ``None`` where it can."""
        return self.statistic if self.verdict == "not_judged" else None

    @property
    def band(self) -> str:
        if self.lower is None and self.upper is None:
            return "any"
        lower, upper = (None if end is None else _figure(end, end) for end in (self.lower, self.upper))
        if lower is None:
            return f"at most {upper}{self._unit}"
        if upper is None:
            return f"at least {lower}{self._unit}"
        return f"{lower} to {upper}{self._unit}"

    @property
    def _unit(self) -> str:
        return "" if self.unit == "1" else f" {self.unit}"

    def __str__(self) -> str:
        value = "nothing"
        if self.value is not None:
            value = _figure(self.value, self.lower, self.upper) + self._unit
        return f"{self.name}: measured {value}, band {self.band}: {self.verdict}"


@dataclass(frozen=True)
class Property:
    """A property of a run. ``margin`` is the least distance to a violation as a share of its limit."""

    name: str
    always: bool
    held: bool | None = None
    #: Why it was not judged on this bench.
    not_judged: str | None = None
    margin: float | None = None
    #: For `a -> b` that held: the text of `a`, if `a` was true at no moment at which `b` was known.
    never_asked: str | None = None
    #: Bench time of the violation, s.
    broken_s: float | None = None
    #: What was seen then.
    what: str | None = None

    @property
    def passed(self) -> bool:
        """Not broken: it held or came about, or this bench cannot judge it."""
        return self.held is not False

    def __bool__(self) -> bool:
        return self.passed

    @property
    def untested(self) -> str | None:
        """A sentence where it held only because nothing was asked for."""
        if self.never_asked is None:
            return None
        return f"held, but was never put to the test: `{self.never_asked}` was true at no moment that could be judged"

    def __str__(self) -> str:
        if self.not_judged is not None:
            return f"{self.name}: not judged: {self.not_judged}"
        if self.untested is not None:
            return f"{self.name}: {self.untested}"
        if self.passed:
            return f"{self.name}: held" if self.always else f"{self.name}: came about: {self.held}"
        when = "" if self.broken_s is None else f"broken at {self.broken_s} s: "
        return f"{self.name}: {when}{self.what or 'broken'}"


class Run:
    """A run of a plan: what ``summary.json`` says, and what was printed."""

    def __init__(self, folder: Path, status: int, printed: str):
        self.folder = folder
        #: Exit status: 0 passed, 1 failed, 2 bad input, 3 the bench broke, 4 timeout, 5 aborted.
        self.status = status
        self.printed = printed
        summary = folder / "summary.json"
        #: The whole of it; empty where the run never began.
        self.summary = {}
        if status != BAD_INPUT and summary.is_file():
            self.summary = json.loads(summary.read_text(encoding="utf-8"))
        rows = self.summary.get
        self.measurements = {one["name"]: _of(Measurement, one) for one in rows("measurements", [])}
        self.properties = {one["name"]: _of(Property, one) for one in rows("properties", [])}

    @property
    def passed(self) -> bool:
        return self.status == 0

    def __bool__(self) -> bool:
        return self.passed

    @property
    def outcome(self) -> str:
        """``passed``, ``failed``, ``error``, ``timeout`` or ``aborted``; ``bad input`` where it never began."""
        return self.summary.get("outcome", "bad input" if self.status == BAD_INPUT else "error")

    @property
    def reason(self) -> str | None:
        return self.summary.get("reason")

    @property
    def report(self) -> Path:
        return self.folder / "report.html"

    def __str__(self) -> str:
        return self.printed.strip() or f"{self.outcome}, exit status {self.status}, in {self.folder}"

    def __repr__(self) -> str:
        """What `assert done.passed, done` shows, of which pytest cuts out the middle: outcome and reasons."""
        rows = [*self.measurements.values(), *self.properties.values()]
        broken = [str(row) for row in rows if not row.passed and row.not_judged is None]
        said = [self.reason] if self.reason else broken or [str(self)]
        return f"{self.outcome}: {'; '.join(said)}"


def run(plan, out, *, seed=None, clock=None, bench=None, arguments=()) -> Run:
    """Carries the plan out, and keeps the run in the folder ``out``. ``arguments`` are further ones of ``hil run``."""
    command = [program(), "run", str(plan), "--out", str(out)]
    for option, value in (("--seed", seed), ("--clock", clock), ("--bench", bench)):
        if value is not None:
            command += [option, str(value)]
    command += map(str, arguments)
    stdout, stderr = subprocess.PIPE, subprocess.STDOUT
    process = started(command, stdin=subprocess.DEVNULL, stdout=stdout, stderr=stderr, text=True)
    return Run(Path(out), *_ended(process))


def _ended(process: subprocess.Popen) -> tuple[int, str]:
    """Its status and what it printed. Ctrl-C makes it end in order, with its `finally`; again, at once."""
    interrupted = None
    while True:
        try:
            printed, _ = process.communicate()
        except KeyboardInterrupt as error:
            interrupted = error
            process.terminate()
            continue
        if interrupted is not None:
            raise interrupted
        return process.returncode, printed


def _figure(value: float, *limits: float | None) -> str:
    """With four digits and the decimals of the limits, or as many as it takes to be on the same side of them as the value."""

    def sides(number: float):
        return [(number > limit) - (number < limit) for limit in limits if limit is not None]

    for digits in range(4, 18):
        text = f"{value:.{digits}g}"
        if ("e+" not in text or digits == 17) and sides(float(text)) == sides(value):
            decimals = max((_decimals(repr(limit)) for limit in limits if limit is not None), default=0)
            fixed = f"{value:.{decimals}f}"
            has_fewer = "e" not in text and _decimals(text) < decimals
            return fixed if has_fewer and sides(float(fixed)) == sides(value) else text
    return repr(value)


def _decimals(figure: str) -> int:
    _, _, decimals = figure.partition(".")
    return 0 if "e" in figure or decimals == "0" else len(decimals)


def _of(kind, row: dict):
    """Of a row of the summary; keys of a later version are left out."""
    known = {field.name for field in fields(kind)}
    return kind(**{key: value for key, value in row.items() if key in known})
