"""A plan from a test: other noise passes, too, and is no hotter."""

import pytest


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_other_noise_passes_too(run, seed):
    done = run("plans/settles.toml", seed=seed)
    assert done.passed, str(done)
    assert done.measurements["temperature_held"].value < 61
