"""Plans as tests: one case for the run, and one for each of its measurements."""

import tomllib
from pathlib import Path

import pytest

PLAN = Path(__file__).parent / "plans/settles.toml"
MEASUREMENTS = [one["name"] for one in tomllib.loads(PLAN.read_text())["measurement"]]


def test_the_plan_passes(run):
    done = run(PLAN)
    assert done.status == 0, done.printed


@pytest.mark.parametrize("name", MEASUREMENTS)
def test_measurement(run, name):
    one = run(PLAN).measurements[name]
    assert one["verdict"] in ("pass", "marginal"), f"{one['value']} {one['unit']} of {one['lower']} to {one['upper']}"


@pytest.mark.parametrize("seed", ["2", "3", "4"])
def test_other_noise_passes_too(run, seed):
    done = run(PLAN, "--seed", seed)
    assert done.status == 0, done.printed
