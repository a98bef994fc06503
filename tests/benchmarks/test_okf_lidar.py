"""The lidar benchmark, where its data are there; and its refusal where they are not."""

from pathlib import Path

import pytest

from benchmarks.okf_lidar import main, outcome, posed, targets

FILE = Path(__file__).resolve().parents[3] / "shared" / "data" / "tuning_benchmarks"
FILE = FILE / "okf_simple_lidar.npz"


def test_it_is_skipped_without_its_data(tmp_path, capsys):
    assert main([str(tmp_path / "none.npz")]) == 0
    assert capsys.readouterr().out.startswith("skipped: there is no ")


@pytest.mark.skipif(not FILE.exists(), reason=f"there is no {FILE}")
def test_the_true_noise_is_as_good_as_known():
    """Its mean square error is known from an independent loop; NIS and NEES are not 1 and 2."""
    tuned_on, judge = targets(FILE)
    problem = posed(tuned_on, full=False, truth=True)
    found = outcome(judge, problem, problem.parameters(problem.space.start()))
    assert found.mse == pytest.approx(898.958, abs=1e-3)
    assert found.nees == pytest.approx(2.81, abs=0.005)
