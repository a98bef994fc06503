"""Ha, Kim and Choi 1981: the command's result, and its parts against independent textbook loops."""

import json

import jax.numpy as jnp
import numpy as np
import pytest

from studies.ha1981 import conventional, paper, scheme
from studies.ha1981.channel import (
    FORMS,
    Channel,
    kalman_history,
    loop_history,
    riccati_history,
    times,
)
from studies.ha1981.claims import CLAIMS
from studies.ha1981.settings import Settings
from tests import oracles_ha1981 as oracle
from tests.published import as_printed
from tuner.certificate.solution import Status
from tuner.cli import invoke
from tuner.solvers import Gradient, Ipopt

CHANNEL = Channel.of(Settings())
VERDICTS = {
    "conventional.K1_over_eta": "match",
    "conventional.K2_over_eta2": "match",
    "conventional.K3_over_eta3": "match",
    "conventional.sigma2_given_4.0": "inconsistent in the paper",
    "ise.better_than_paper_claim": "claim holds",
    "settling.triple_pole_fastest": "claim fails",
    "kalman.K2_inf_5s": "match",
    "kalman.K3_inf_5s": "match",
    "kalman.p11_floor": "claim fails",
    "kalman.insensitive_q_b": "claim holds",
    "kalman.insensitive_sigma_ab": "claim holds",
    "kalman.insensitive_ts": "claim holds",
    "kalman.insensitive_q_a": "claim fails",
    "kalman.printed_Q_psd": "inconsistent in the paper",
    "kalman.better_than_conventional": "claim holds",
    "conventional.time_varying_gains_better": "claim holds",
    "kalman.stored_gains_sluggish": "claim holds",
}


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """The command's own run: its folder and result.json."""
    folder = tmp_path_factory.mktemp("ha1981") / "run"
    assert invoke(["run", "ha1981", "--out", str(folder)]) == 0
    return folder, json.loads((folder / "result.json").read_bytes())


@pytest.fixture(scope="module")
def rows(ran):
    return {row["quantity"]: row for row in ran[1]["comparisons"]}


def test_all_rows_and_verdicts(rows):
    assert {name: row["verdict"] for name, row in rows.items()} == VERDICTS


def test_every_row_is_a_claim_that_can_be_asked_for(rows, tmp_path, capsys):
    assert [claim.name for claim in CLAIMS] == list(rows)
    name = "kalman.stored_gains_sluggish"
    command = ["run", "ha1981", "--claim", name, "--out", str(tmp_path / "run"), "--json"]
    assert invoke(command) == 0
    alone = json.loads(capsys.readouterr().out)
    assert alone["comparisons"] == [rows[name]]
    assert [s["problem"] for s in alone["solutions"]] == ["kalman_stored"]


def test_numbers_of_the_rows(rows):
    ours = {name: row["ours"] for name, row in rows.items()}
    assert ours["conventional.K1_over_eta"] == pytest.approx(16, rel=1e-6)
    assert ours["conventional.K2_over_eta2"] == pytest.approx(256 / 3, rel=1e-6)
    assert ours["conventional.K3_over_eta3"] == pytest.approx(4096 / 27, rel=1e-6)
    assert rows["kalman.K2_inf_5s"]["paper"] == as_printed(oracle.STEADY[5.0][2])
    assert rows["kalman.K3_inf_5s"]["paper"] == as_printed(oracle.STEADY[5.0][3])
    assert ours["kalman.p11_floor"] == as_printed(oracle.FLOOR)
    q_a, q_b, sigma = oracle.SENSITIVITY[105]
    assert ours["kalman.insensitive_q_a"] == as_printed(q_a)
    assert ours["kalman.insensitive_q_b"] == as_printed(q_b)
    assert ours["kalman.insensitive_sigma_ab"] == as_printed(sigma)
    assert "meets the bound after 105 s" in rows["kalman.better_than_conventional"]["note"]
    assert "P11 by 205 sample by sample" in rows["kalman.insensitive_ts"]["note"]
    printed = oracle.DESIGNS["Bessel"].settling_2, oracle.DESIGNS["triple pole"].settling_2
    assert all(text in rows["settling.triple_pole_fastest"]["note"] for text in printed)


def test_statuses_say_what_exists(ran):
    found = {(s["problem"], s["solver"]): s for s in ran[1]["solutions"]}
    statuses = {key: s["status"] for key, s in found.items()}
    assert statuses.pop(("ise", "ipopt")) == "unattained"
    assert statuses.pop(("conventional_lmi", "sdp")) == "unattained"
    assert set(statuses.values()) == {"converged"}
    assert "towards 25;" in found["ise", "ipopt"]["message"]  # 1 / (4 eta)
    # One Lyapunov matrix proves 2 eta at the most, 3/8 of what the loop reaches.
    assert found["conventional_lmi", "sdp"]["certificate"]["lower_bound"] == pytest.approx(
        50.0, rel=1e-6
    )
    assert found["conventional", "ipopt"]["certificate"]["starts"]["agreeing"] == 20


def test_exports_hold_gains_and_poles(ran):
    tuned = {one["name"]: one for one in ran[1]["tuned"]}
    loop = {q["name"]: q["value"] for q in tuned["conventional"]["quantities"]}
    K1, K2, K3 = oracle.triple_pole_gains(0.01)
    assert loop["K1"] == pytest.approx(K1, rel=1e-6)
    assert loop["K2"] == pytest.approx(K2 + oracle.K_GH, rel=1e-6)
    assert loop["K3"] == pytest.approx(K3, rel=1e-6)
    # Three poles that meet are known to the cube root of the rounding in the gains.
    np.testing.assert_allclose(loop["poles_re"], -16 * 0.01 / 3, rtol=1e-3)
    assert (tuned["conventional"]["convention"], tuned["conventional"]["dt"]) == ("continuous", 0.0)
    stored = {q["name"]: np.array(q["value"]) for q in tuned["kalman_stored"]["quantities"]}
    history = oracle.kalman_history(5.0, 21)  # 0, 5, ..., 105 s
    np.testing.assert_allclose(stored["history"], history.K, rtol=1e-9, atol=1e-12)
    assert stored["gains"].shape == (5, 3)
    assert stored["edges"].tolist() == [0, 1, 2, 5, 10, 22]
    assert all(abs(export["relative_change"]) < 1e-12 for export in ran[1]["exports"])
    assert len(ran[1]["exports"]) == 14


def test_the_estimated_bias_survives_single_precision(ran):
    loop, stored = ran[1]["single_precision"]
    assert (loop["form"], stored["form"]) == ("loop", "stored gains")
    for check in (loop, stored):
        # float32 resolves 1e-7 of an altitude that grows to 1e4 ft; a loop of 0.1 s keeps 1e-3
        assert 0 < check["share"] < 2e-3
        assert check["warning"] == ""


def test_figures_hold_the_curves(ran):
    folder, result = ran
    names = {name for name in result["artifacts"] if name.endswith(".csv") and "figures" in name}
    assert len(names) == 11
    lines = (folder / "figures/fig5_kalman.csv").read_text().splitlines()[1:]
    curve = {float(x): float(y) for label, x, y in (r.split(",") for r in lines) if "5 s" in label}
    assert curve[200.0] == as_printed(oracle.P11[5.0][200])


def test_twenty_random_starts_agree_with_the_closed_form():
    problem = conventional.fastest_decay(CHANNEL)
    solution = Ipopt(seed=7, starts=20)(problem)
    found = conventional.gains_of(solution)
    expected = oracle.triple_pole_gains(CHANNEL.eta)
    np.testing.assert_allclose([found.K1, found.K2p, found.K3], expected, rtol=1e-6)
    starts = solution.certificate.starts
    assert (starts.count, starts.agreeing) == (20, 20)
    assert starts.worst < 1 + 1e-6
    known = conventional.closed_form(CHANNEL)(problem)
    assert known.status is Status.CONVERGED
    assert known.value == pytest.approx(solution.value, rel=1e-9)


def test_a_wrong_closed_form_is_not_believed():
    problem = conventional.fastest_decay(CHANNEL)
    wide = Channel.of(Settings(bound=8e-4))
    assert conventional.closed_form(wide)(problem).status is Status.INFEASIBLE
    tight = Channel.of(Settings(bound=2e-4))
    assert conventional.closed_form(tight)(problem).status is Status.STALLED


@pytest.mark.parametrize("largest", [1e2, 1e3])
def test_least_ise_with_limited_gains(largest):
    """1/4 + sqrt(2/G) by differential evolution and by hand; IPOPT finds the same."""
    channel = Channel.of(Settings(q_a=1.0, bound=1.0))
    from tuner.problem.parameters import Positive
    from tuner.problem.problem import Problem
    from tuner.problem.space import Space

    posed = conventional.least_ise(channel)
    box = {name: Positive(8.0, 1e-2, largest) for name in ("K1", "K2p", "K3")}
    problem = Problem(
        "ise", Space.of(**box), None, posed.build, posed.objective, constraints=posed.constraints
    )
    expected, gains = oracle.least_ise_in_box(largest)
    solution = Ipopt(seed=0, starts=1)(problem)
    assert solution.status is Status.UNATTAINED
    assert solution.value == pytest.approx(expected, rel=1e-6)
    found = [float(p.value) for p in solution.parameters.values()]
    np.testing.assert_allclose(found, gains, rtol=1e-4)


def test_forms_and_histories_are_the_oracles():
    for name, design in oracle.DESIGNS.items():
        gains = FORMS[name].at(1.0)
        assert [gains.K1, gains.K2p, gains.K3] == [as_printed(text) for text in design.gains]
    at = times(300.0, 5.0)
    gains = FORMS["triple pole"].at(CHANNEL.eta)
    ours = loop_history(CHANNEL, gains, 5.0, 300.0)
    theirs = oracle.conventional_variance(oracle.triple_pole_gains(0.01), at[1:])
    np.testing.assert_allclose(ours[1:], theirs, rtol=1e-9)
    for t, text in oracle.LOOP_VARIANCE.items():
        assert ours[round(t / 5)] == as_printed(text)
    for Ts, numbers in oracle.P11.items():
        P = np.asarray(kalman_history(CHANNEL, Ts, 200.0).P)
        for t, text in numbers.items():
            assert P[round(t / Ts), 0, 0] == as_printed(text)
    P = np.asarray(riccati_history(CHANNEL, 1.0, 100.0).P)
    for t, text in oracle.P11_RICCATI.items():
        assert P[t, 0, 0] == as_printed(text)


def test_steady_gains_of_every_origin():
    for Ts, (A, B, K2, K3) in oracle.STEADY.items():
        found = paper.steady_gains(CHANNEL.q_a, CHANNEL.q_b, Ts)
        printed = [as_printed(text) for text in (A, B, K2, K3)]
        assert printed == [found.A, found.B, found.K2, found.K3]
    problem = scheme.steady(CHANNEL, 5.0)
    exact = scheme.riccati_gains(CHANNEL, 5.0)(problem)
    searched = Gradient("l-bfgs-b", seed=0, starts=1)(problem)
    assert exact.status is searched.status is Status.CONVERGED
    assert searched.value == pytest.approx(exact.value, rel=1e-10)
    assert scheme.printed_gains(CHANNEL, 5.0)(problem).value > exact.value


@pytest.mark.parametrize("Ts", oracle.KALMAN_REACHES)
def test_when_the_bound_is_reached(Ts):
    assert scheme.reaches(CHANNEL, Ts) == float(oracle.KALMAN_REACHES[Ts])


def test_replay_of_stored_gains():
    found = scheme.replay(CHANNEL, 5.0, 200.0, by="sample"), oracle.REPLAY_BY_INDEX
    held = scheme.replay(CHANNEL, 5.0, 200.0, by="time"), oracle.REPLAY_BY_TIME_HELD
    for ratio, printed in (found, held):
        for t, text in printed.items():
            assert ratio[round(t / 2.5)] == as_printed(text)


def test_sensitivities_are_shares():
    found = scheme.sensitivities(CHANNEL, 5.0, 200.0)
    for t, texts in oracle.SENSITIVITY.items():
        if t <= 200:
            here = [found[name][round(t / 5)] for name in ("q_a", "q_b", "sigma2_ab")]
            assert here == [as_printed(text) for text in texts]


def test_stages_of_triple_poles():
    one, two = (
        Gradient("l-bfgs-b", seed=0, starts=1)(conventional.staged(CHANNEL, 105.0, stages))
        for stages in (1, 2)
    )
    assert one.value == as_printed(oracle.ONE_STAGE)
    assert two.value == as_printed(oracle.TWO_STAGES)
    assert float(two.parameters["switch"].value) == pytest.approx(oracle.TWO_STAGE_SWITCH, rel=1e-3)


def test_stored_gains_are_scored_over_the_whole_history():
    storage = scheme.Storage.of(CHANNEL, 5.0, 4)
    means = oracle.segment_means(oracle.kalman_history(5.0, 21).K, storage.edges)
    for a, b, mean in zip(storage.edges, storage.edges[1:], storage.means, strict=False):
        # the oracle repeats every mean for all samples of its segment
        np.testing.assert_allclose(means[a:b], np.tile(mean, (b - a, 1)), rtol=1e-9, atol=1e-15)
    problem = storage.problem()
    # "4 + first" of the independent calculation: 1.217
    assert problem.value(problem.space.start()) == pytest.approx(1.217, abs=5e-4)
    optimal = {
        f"K{i + 1}_{s}": storage.means[s, i]
        for s in range(1, len(storage.edges) - 1)
        for i in range(3)
    }
    assert problem.score(optimal) == pytest.approx(problem.value(problem.space.start()), rel=1e-12)


@pytest.mark.parametrize("Ts", [0.1, 0.5, 0.99])
def test_printed_noise_is_refused_below_a_second(Ts):
    expected = np.linalg.eigvalsh(np.asarray(oracle.printed_Q(Ts))[-2:, -2:])[0]
    assert expected < 0
    with pytest.raises(ValueError, match=r"printed below \(12\) has the eigenvalue -") as e:
        paper.printed_noise(CHANNEL.q_a, CHANNEL.k_gh, Ts)
    assert f"{expected:.6g}" in str(e.value)


def test_printed_noise_is_a_covariance_above_a_second():
    assert np.linalg.eigvalsh(paper.printed_noise(CHANNEL.q_a, CHANNEL.k_gh, 2.0))[0] > 0


def test_metres_change_the_unit_and_nothing_else():
    metric = Channel.of(Settings(unit="m"))
    assert metric.eta == pytest.approx(CHANNEL.eta, rel=1e-14)
    feet, metres = (np.asarray(kalman_history(c, 5.0, 100.0).P) for c in (CHANNEL, metric))
    np.testing.assert_allclose(metres, feet * 0.3048**2, rtol=1e-10, atol=1e-12)
    assert metric.bound == pytest.approx(4e-4 * 0.3048**2, rel=1e-14)
    assert Channel.of(Settings(unit="m", q_a=0.01)).q_a == 0.01


def test_a_bound_out_of_reach_is_said():
    never = Channel.of(Settings(k_gh=0.0, q_b=1e22))
    with pytest.raises(ValueError, match="does not bring the bias's variance below 0.0004 within"):
        scheme.reaches(never, 5.0)


@pytest.mark.parametrize("setting", ["Ts=0", "Ts=-1", "bound=0", "q_a=-1", "unit=km", "seconds=10"])
def test_bad_settings_are_refused(setting, capfd):
    assert invoke(["run", "ha1981", "--dry-run", "--set", setting]) == 2
    assert f"setting {setting.split('=')[0]}" in capfd.readouterr().err


def test_every_form_has_the_variance_it_is_scaled_to():
    for gains in FORMS.values():
        found = gains.at(0.37)
        share = oracle.gain_variance((found.K1, found.K2p, found.K3))
        assert share == pytest.approx(0.37, rel=1e-14)


def test_ise_by_parseval_is_that_of_the_step():
    for name, design in oracle.DESIGNS.items():
        found = FORMS[name].at(1.0)
        loop = conventional.Loop(jnp.ones(()), *map(jnp.asarray, (found.K1, found.K2p, found.K3)))
        assert float(conventional.ise_of_step(loop, None)) == as_printed(design.ise)
    unstable = conventional.Loop(*map(jnp.asarray, (1.0, 1.0, 1.0, 2.0)))
    assert float(conventional.ise_of_step(unstable, None)) == np.inf
