"""Plans as files of tests: one item for the run, one for each measurement and each property."""

import fcntl
import json
import os
import tomllib
import warnings
from pathlib import Path

import pytest

from hil.runs import JUDGED, Run, run

#: The item that stands for the run itself.
RUN = "run"

#: The plans of this session by the names of their files, without the folders.
PLANS = pytest.StashKey[dict[str, set[Path]]]()


class NeverTested(pytest.PytestWarning):
    """A property held, but what it is about did not happen in the run."""


class PlanFile(pytest.File):
    """A plan. It is carried out once, by the first of its items that asks."""

    _run: Run | None = None
    #: Of a run that is given no other.
    _seed: int | str = 1
    #: Why there are no verdicts stands once in the output.
    is_told = False

    def collect(self):
        try:
            plan = tomllib.loads(self.path.read_text(encoding="utf-8-sig"))
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            raise self.CollectError(f"{self.path}: {error}") from None
        self._seed = plan.get("seed", 1)
        self.config.stash.setdefault(PLANS, {}).setdefault(self.path.stem, set()).add(self.path)
        yield PlanItem.from_parent(self, name=RUN)
        measurements = _names(plan, "measurement")
        for name in measurements:
            yield PlanItem.from_parent(self, name=name, kind="measurement", verdict=name)
        for name in _names(plan, "property"):
            shown = f"{name} (property)" if name in measurements else name
            yield PlanItem.from_parent(self, name=shown, kind="property", verdict=name)

    def run(self) -> Run:
        """The run, made now or before."""
        if self._run is None:
            option = self.config.getoption
            seed = option("hil_seed")
            name = f"{self._name()}-seed{self._seed if seed is None else seed}"
            out = Path(option("hil_runs")).absolute() / name
            settings = {name: option(f"hil_{name}") for name in ("seed", "clock", "bench")}
            self._run = self._shared(out, lambda: run(self.path, out, **settings))
        return self._run

    def _name(self) -> str:
        """That of its run folder: with its own folders, where another plan has the same file name."""
        if len(self.config.stash[PLANS][self.path.stem]) == 1:
            return self.path.stem
        return "-".join(Path(os.path.relpath(self.path, self.config.rootpath)).with_suffix("").parts)

    def _shared(self, out: Path, make) -> Run:
        """One worker of pytest-xdist makes the run, the others wait for it and read it."""
        worker = getattr(self.config, "workerinput", None)
        if worker is None:
            return make()
        session = worker["testrunuid"]
        out.parent.mkdir(parents=True, exist_ok=True)
        with (out.parent / f".{out.name}.json").open("a+", encoding="utf-8") as kept:
            fcntl.flock(kept, fcntl.LOCK_EX)
            kept.seek(0)
            text = kept.read()
            done = json.loads(text) if text else {}
            # By its path: two plans of one name take turns in one folder.
            if (done.get("session"), done.get("plan")) == (session, str(self.path)):
                return Run(out, done["status"], done["printed"])
            made = make()
            kept.truncate(0)
            told = {"session": session, "plan": str(self.path), "status": made.status}
            kept.write(json.dumps({**told, "printed": made.printed}))
            return made


class PlanItem(pytest.Item):
    """A verdict of a plan: of the run itself, where it is of no kind."""

    def __init__(self, *, kind: str | None = None, verdict: str = RUN, **rest):
        super().__init__(**rest)
        self.kind = kind
        #: Its name in the summary.
        self.verdict = verdict

    def setup(self):
        try:
            made = self.parent.run()
        except FileNotFoundError as error:
            pytest.fail(str(error), pytrace=False)
        # Bad input, a bench that broke, a time-out, or it was broken off: what fails here is an error, and no verdict.
        if made.status not in JUDGED:
            why = str(made)
            if self.parent.is_told:
                why = made.reason or why.partition("\n")[0]
            self.parent.is_told = True
            pytest.fail(why, pytrace=False)

    def runtest(self):
        made = self.parent.run()
        # As build servers see it, which look from where pytest was started.
        report = os.path.relpath(made.report, self.config.invocation_params.dir)
        self.user_properties.append(("report", report))
        if self.kind is None:
            self._judge_run(made)
            return
        rows = made.measurements if self.kind == "measurement" else made.properties
        row = rows.get(self.verdict)
        if row is None:
            pytest.fail(f"{self.name}: the run has no such verdict\n{made}", pytrace=False)
        self.user_properties.append(("verdict", str(row)))
        if self.kind == "property" and row.untested is not None:
            told = NeverTested(f"{self.parent.path.name}: {row}")
            warnings.warn_explicit(told, category=None, filename=str(self.path), lineno=1)
        if row.not_judged is not None:
            pytest.skip(row.not_judged)
        if not row.passed:
            pytest.fail(f"{row}\n{report}", pytrace=False)

    def _judge_run(self, made: Run):
        """What failed by a verdict fails as that: what is left is a run that failed by itself."""
        rows = [*made.measurements.values(), *made.properties.values()]
        if made.passed or (made.reason is None and not all(row.passed or row.not_judged is not None for row in rows)):
            return
        pytest.fail(made.reason or str(made), pytrace=False)

    def reportinfo(self):
        return self.path, None, f"{self.path.name}: {self.name}"


def _names(plan: dict, kind: str) -> list[str]:
    """Of the measurements or properties of a plan; what is wrong with them says `hil`, which reads it."""
    found = plan.get(kind)
    if not isinstance(found, list):
        return []
    rows = [one for one in found if isinstance(one, dict)]
    # A property without a name is called by what it states; one of the robot by its key.
    names = [one.get("name") or one.get("always") or one.get("sometimes") for one in rows]
    names = [next(iter(name), None) if isinstance(name, dict) else name for name in names]
    return [name for name in names if isinstance(name, str)]
