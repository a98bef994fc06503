"""The front of two objectives against all of its points, one by one."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import tuner
from filters import LocalLevel
from objectives import InnovationLikelihood
from objectives.rmse import InnovationRmse
from tests.tuner import fit_cases as cases
from tests.tuner.helpers import Solved
from tuner.certificate.solution import Status
from tuner.run.fit import Fitting, _share, pose_on
from tuner.run.front import Against
from tuner.run.result import read_result
from tuner.run.search_space import Wishes
from tuner.run.sharing import OneForAll
from tuner.solvers.gradient import Gradient
from tuner.solvers.ipopt import Ipopt
from tuner.solvers.pareto import pareto

SOLVER = Gradient("l-bfgs-b", seed=0, starts=3)


def coloured(samples=300):
    """A random walk whose measurement noise is coloured: to predict it is to follow it."""
    draw = np.random.default_rng(3)
    walk, noise = np.cumsum(0.2 * draw.standard_normal(samples)), np.zeros(samples)
    for k in range(1, samples):
        noise[k] = 0.8 * noise[k - 1] + 0.6 * draw.standard_normal()
    return walk + noise, walk


Z, LEVEL = coloured()


def posed(unit=1.0):
    record = tuner.Record.of({"z": unit * Z}, rate_hz=1.0, truth={"level": unit * LEVEL})
    return pose_on("local-level", LocalLevel, (record,), Wishes(fix={"R": unit**2})).problem


def both(q):
    """Of a density q: the error of the level, and of what is predicted, by a textbook loop."""
    y, _ = cases.level_loop(Z, q, 1.0, 1.0)
    x, p, levels = Z[0], 1.0, [Z[0]]
    for z in Z[1:]:
        p = p + q
        x, p = x + p / (p + 1) * (z - x), p / (p + 1)
        levels.append(x)
    return np.sqrt(np.mean((np.array(levels) - LEVEL) ** 2)), np.sqrt(np.mean(y**2))


def test_a_front_and_its_knee_are_those_of_all_points():
    front = pareto(posed(), InnovationRmse(), np.zeros((len(Z), 1)), solver=SOLVER, points=6)
    for point in front.points:
        # Where the front bends inwards both neighbours lead to ends of their own.
        assert point.solution.status in (Status.CONVERGED, Status.STARTS_DIFFER)
        known = both(float(point.solution.parameters["q"].value))
        assert (point.first, point.second) == pytest.approx(known, rel=1e-9)
    grid = np.array([both(q) for q in np.geomspace(1e-3, 1e3, 1500)])
    assert front.points[0].first == pytest.approx(grid[:, 0].min(), rel=1e-4)
    assert front.points[-1].second == pytest.approx(grid[:, 1].min(), rel=1e-4)
    ends = np.log([grid[grid[:, 0].argmin()], grid[grid[:, 1].argmin()]])
    low, high = ends.min(axis=0), ends.max(axis=0)
    depth = (1 - ((np.log(grid) - low) / (high - low)).sum(axis=1)).max()
    assert front.points[front.knee].logs == pytest.approx(np.log(both_at(front)), rel=1e-9)
    # The ends weigh the other objective by a thousandth, which moves them along the front a bit.
    assert front.depth == pytest.approx(depth, abs=5e-3)
    firsts, seconds = zip(*((p.first, p.second) for p in front.points), strict=True)
    assert list(firsts) == sorted(firsts)
    assert list(seconds) == sorted(seconds, reverse=True)


def both_at(front):
    knee = front.points[front.knee]
    return both(float(knee.solution.parameters["q"].value))


def test_objectives_that_agree_have_one_point():
    problem = posed()
    front = pareto(problem, problem.objective, solver=SOLVER)
    assert (len(front.points), front.knee, front.depth) == (1, None, 0.0)


def test_what_cannot_be_weighed_is_refused():
    with pytest.raises(ValueError, match="a front needs three points at least, got 2"):
        pareto(posed(), InnovationRmse(), solver=SOLVER, points=2)
    with pytest.raises(ValueError, match="function cannot be weighed against another objective"):
        pareto(posed(), lambda outputs, truth: outputs.level.sum(), solver=SOLVER)


def test_a_likelihood_counts_by_its_nats():
    """It may be negative, and a unit of a millionth moves nothing along the front."""
    found = {}
    for unit in (1.0, 1e-6):
        likelihood = InnovationLikelihood()
        front = pareto(posed(unit), likelihood, np.zeros((len(Z), 1)), solver=SOLVER, points=4)
        found[unit] = [
            (p.first / unit, float(likelihood.deviation(p.second)) / unit) for p in front.points
        ]
    assert all(p.second < 0 for p in front.points)
    assert np.array(found[1e-6]) == pytest.approx(np.array(found[1.0]), rel=1e-4)


def test_a_fit_has_a_front(cli, here):
    cases.write(here / "z.csv", {"t": np.arange(len(Z)), "z": Z, "level": LEVEL})
    words = ("fit", "z.csv", "--filter", "local-level", "--map", "z=z", "--truth", "level=level")
    more = ("--fix", "R=1", "--starts", 1, "--no-hold-out")
    code, _, err = cli(
        *words, *more, "--objective", "prediction", "--objective", "rmse", "--out", "out"
    )
    assert code == 0, err
    fit = read_result(here / "out").fit
    assert (fit.objective, fit.trade.objective) == ("rmse", "prediction")
    assert [point.knee for point in fit.trade.points].count(True) == 1
    assert "at the knee q = " in fit.lines[1]
    rows = (here / "out" / "figures" / "local_level_front.csv").read_text().splitlines()
    assert len([row for row in rows if row.startswith("front,")]) == len(fit.trade.points)
    assert (here / "out" / "figures" / "local_level_front.png").stat().st_size > 1000


def test_a_plan_that_is_shared_shares_its_front():
    first, wishes = posed(), Wishes(fix={"R": 1.0}, objective="prediction")
    record = tuner.Record.of({"z": Z}, rate_hz=1.0)
    other = pose_on("local-level", LocalLevel, (record,), wishes)
    case = Fitting(other, None, Against.by(other, Ipopt(seed=0), first))
    solver = _share(case, "sqlite:///t.db").against.solver
    assert isinstance(solver, OneForAll)
    assert (solver.name, solver.solver.starts) == ("ipopt", 3)
    assert solver.solver.shared.url == "sqlite:///t.db"


def test_processes_that_share_a_front_find_the_same_one(tmp_path):
    """Every point is concluded once, and is what a search by itself finds."""
    concluded, url = [], f"sqlite:///{tmp_path / 't.db'}"

    def solve(problem):
        concluded.append(problem.name)
        return SOLVER(problem)

    def searched(solver):
        return pareto(posed(), InnovationRmse(), np.zeros((len(Z), 1)), solver=solver, points=4)

    solver = Solved("l-bfgs-b", solve)
    alone, asked = searched(solver), len(concluded)
    with ThreadPoolExecutor(2) as pool:
        fronts = list(pool.map(searched, 2 * [OneForAll(solver, url)]))
    assert len(concluded) == 2 * asked
    for front in fronts:
        assert front.knee == alone.knee
        for ours, theirs in zip(front.points, alone.points, strict=True):
            assert (ours.weight, ours.logs) == (theirs.weight, theirs.logs)
            assert ours.solution.z.tobytes() == theirs.solution.z.tobytes()


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (("--objective", "rmse", "--set", "against=rmse"), "and both are rmse"),
        (("--set", "against=rmse"), "and both are rmse"),
        (("--objective", "rmse", "--objective", "prediction", "--objective", "heading"), "at most"),
        (("--set", "against=likelyhood"), "likelihood"),
    ],
)
def test_a_front_of_other_than_two_is_refused(cli, here, options, says):
    cases.write(here / "z.csv", {"t": np.arange(len(Z)), "z": Z, "level": LEVEL})
    code, _, err = cli(
        *("fit", "z.csv", "--filter", "local-level", "--map", "z=z", "--truth", "level=level"),
        *options,
    )
    assert code == 2
    assert says in err.splitlines()[-1]
