"""A filter that another package brings, and the page that tells how."""

import os
import re
import subprocess
import sys
import tomllib
from importlib.metadata import entry_points
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from filters import assembled, channel_facts, parameter_facts, run
from tests.example_package.installed import SOURCE, install

PAGE = Path(__file__).parents[2] / "docs" / "adding_a_filter.md"


@pytest.fixture
def brought(tmp_path, monkeypatch):
    """The filter's class, as it is found by its entry point."""
    monkeypatch.syspath_prepend(install(tmp_path))
    (entry,) = entry_points(group="tuner.filters", name="gauss-markov")
    yield entry.load()
    sys.modules.pop("gauss_markov")


def test_it_is_found_by_its_entry_point_and_says_what_it_is(brought):
    assert list(parameter_facts(brought)) == ["tau", "sigma", "R"]
    assert list(channel_facts(brought, "inputs")) == ["z"]
    assert channel_facts(brought, "outputs")["level"].unit == "unit"


def test_another_process_finds_it_by_its_path(tmp_path):
    code = (
        "from importlib.metadata import entry_points as e;"
        "print(*(p.value for p in e(group='tuner.filters', name='gauss-markov')))"
    )
    env = {**os.environ, "PYTHONPATH": str(install(tmp_path))}
    told = subprocess.run(
        [sys.executable, "-c", code],
        env=env,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    )
    assert told.stdout.strip() == "gauss_markov:GaussMarkov"


def test_it_is_the_mean_given_all_measurements(brought):
    """By their joint distribution: the process's covariance is sigma^2 exp(-abs(t - s) / tau)."""
    tau, sigma, R, dt = 0.7, 1.3, 0.4, 0.1
    z = np.random.default_rng(4).normal(size=20)
    z[[3, 4, 11]] = np.nan
    params = assembled(brought, {"tau": tau, "sigma": sigma, "R": R})
    out = jax.jit(run, static_argnums=0)(brought(dt), params, jnp.asarray(z))[1]
    t = dt * np.arange(20)
    covariance = sigma**2 * np.exp(-np.abs(t[:, None] - t) / tau)
    for k in range(20):
        seen = np.flatnonzero(~np.isnan(z[: k + 1]))
        joint = covariance[np.ix_(seen, seen)] + R * np.eye(len(seen))
        expected = covariance[k, seen] @ np.linalg.solve(joint, z[seen])
        assert float(out.level[k]) == pytest.approx(expected, rel=1e-10, abs=1e-12)


def test_the_page_shows_the_package_as_it_is():
    text = PAGE.read_text(encoding="utf-8")
    (shown,) = re.findall(r"```python\n# gauss_markov.py\n(.*?)```", text, re.DOTALL)
    assert shown == (SOURCE / "gauss_markov.py").read_text(encoding="utf-8")
    (project,) = re.findall(r"```toml\n(.*?)```", text, re.DOTALL)
    whole = tomllib.loads((SOURCE / "pyproject.toml").read_text(encoding="utf-8"))
    assert tomllib.loads(project)["project"] == whole["project"]
