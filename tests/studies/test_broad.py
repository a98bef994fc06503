"""The BROAD study on synthetic trials: reading, refusing and judging; one real trial if there."""

import hashlib
import re
import shutil
from functools import cache
from pathlib import Path
from types import SimpleNamespace

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from filters import ImuSample, assembled, blocks, run
from studies.broad import Settings, claims, contest, other_filters, paper, peers, plan
from studies.broad.contest import Contest, Outcome, side_by_side
from studies.broad.contestants import BLOCK, filter_of, start
from studies.broad.figures import figures
from studies.broad.problems import Case
from studies.broad.trials import GRAVITY, read
from tuner.cli import invoke
from tuner.data.simulation import Sensor, Swing, measure, simulate
from tuner.run.comparison import Verdict

REAL = Path(__file__).parents[2].parent / "shared" / "data" / "broad" / "data_mat"
HZ, REST, SECONDS = 50.0, 2.0, 12.0
RESTING, SAMPLES = round(REST * HZ), round(SECONDS * HZ)
QUICK = {"xla_backend_optimization_level": 0}
compiled = jax.jit(run, static_argnums=0, compiler_options=QUICK)
LOST = slice(300, 310)
"""Samples in motion of which the cameras have lost the truth."""
FIELD = np.array([0.0, 20.0, -44.0])
"""Of the earth, microtesla: y is north, and it points down."""
MOUNTED = Rotation.from_euler("zyx", [140.0, -50.0, 70.0], degrees=True)
"""A sensor turned by this against that of :func:`made`."""


SWINGS = ("01_undisturbed_swing", "02_undisturbed_swing")


@pytest.fixture(scope="module", autouse=True)
def quick():
    """Without the compiler's optimisation, which changes no formula and takes most of the time."""
    with pytest.MonkeyPatch.context() as patch:
        function = contest._judged.__wrapped__
        patch.setattr(
            contest, "_judged", jax.jit(function, static_argnums=(0, 1), compiler_options=QUICK)
        )
        yield


@cache
def made(seed):
    """A trial as its file holds it: 2 s of rest, then a swing with noise and bias."""
    motion = simulate(
        seconds=SECONDS - REST, dt=1 / HZ, seed=seed, swing=Swing((0.4, 0.3, 0.6), 0.1, 0.6)
    )
    still = np.tile([1.0, 0.0, 0.0, 0.0], (RESTING, 1))
    turns = Rotation.from_quat(motion.q, scalar_first=True)
    # Gyroscopes show the mean rate since the last sample; the rate at the sample itself, summed
    # up, is half a sample ahead: 0.5 deg in this motion.
    mean = (turns[:-1].inv() * turns[1:]).as_rotvec() * HZ
    whole = motion._replace(
        q=np.vstack([still, motion.q]),
        rate=np.vstack([np.zeros((RESTING + 1, 3)), mean]),
        force=np.vstack([np.tile(motion.force[0], (RESTING, 1)), motion.force]),
    )
    sample = measure(
        whole,
        gyroscope=Sensor(2e-3, (1e-3, -1e-3, 1e-3)),
        accelerometer=Sensor(0.02),
        seed=seed,
    )
    truth = whole.q.copy()
    truth[LOST] = np.nan
    return {
        "imu_acc": np.asarray(sample.acc),
        "imu_gyr": np.asarray(sample.gyr),
        "imu_mag": Rotation.from_quat(whole.q, scalar_first=True).inv().apply(FIELD),
        "opt_quat": truth,
        "opt_pos": np.zeros((SAMPLES, 3)),
        "movement": (np.arange(SAMPLES) >= RESTING)[:, None],
        "sampling_rate": HZ,
    }


def written(folder, name="01_undisturbed_swing", seed=1, **changed):
    """A trial's file; what is changed to None is left out."""
    folder.mkdir(exist_ok=True)
    arrays = {key: value for key, value in (made(seed) | changed).items() if value is not None}
    savemat(folder / f"{name}.mat", arrays)
    return folder


def mounted(seed=1):
    """The same motion, felt by a sensor that is mounted askew."""
    whole = made(seed)
    turns = Rotation.from_quat(np.nan_to_num(whole["opt_quat"], nan=0.5), scalar_first=True)
    truth = (turns * MOUNTED).as_quat(scalar_first=True)
    truth[LOST] = np.nan
    felt = {
        key: MOUNTED.inv().apply(np.array(whole[key])) for key in ("imu_acc", "imu_gyr", "imu_mag")
    }
    return felt | {"opt_quat": truth}


def only(folder, acc_unit="m/s^2", gyr_unit="rad/s", seconds=None):
    (trial,) = read(str(folder), acc_unit, gyr_unit, seconds)
    return trial


# ------------------------------------------------------------------------------------ reading


def test_a_trial_is_read_as_it_was_written(tmp_path):
    trial = only(written(tmp_path))
    whole = made(1)
    assert (trial.name, trial.rate_hz) == ("01_undisturbed_swing", HZ)
    data = (tmp_path / "01_undisturbed_swing.mat").read_bytes()
    assert trial.source.sha256 == hashlib.sha256(data).hexdigest()
    assert (trial.source.samples, trial.source.rate_hz) == (SAMPLES, HZ)
    np.testing.assert_array_equal(trial.acceleration, whole["imu_acc"])
    np.testing.assert_array_equal(trial.rate, whole["imu_gyr"])
    counts = np.arange(SAMPLES) >= RESTING
    counts[LOST] = False
    np.testing.assert_array_equal(np.isnan(trial.truth), np.repeat(~counts[:, None], 4, axis=1))
    # divided by its own length
    np.testing.assert_allclose(trial.truth[counts], whole["opt_quat"][counts], rtol=0, atol=1e-15)


def test_only_the_beginning_is_read(tmp_path):
    trial = only(written(tmp_path), seconds=5.0)
    assert trial.truth.shape == (250, 4)
    np.testing.assert_array_equal(trial.rate, made(1)["imu_gyr"][:250])


def test_trials_come_by_name_and_the_name_says_whether_disturbed(tmp_path):
    written(tmp_path, "26_disturbed_phone", seed=2)
    written(tmp_path, "01_undisturbed_swing", seed=1)
    (tmp_path / "notes.txt").write_text("no trial")
    found = read(str(tmp_path), "m/s^2", "rad/s", None)
    assert [(trial.name[:2], trial.disturbed) for trial in found] == [("01", False), ("26", True)]
    assert found[0].source.sha256 != found[1].source.sha256


def test_units_are_converted(tmp_path):
    whole = made(1)  # the standard gravity, by which g is defined, is not the benchmark's 9.81
    written(tmp_path, imu_acc=whole["imu_acc"] / 9.80665, imu_gyr=np.degrees(whole["imu_gyr"]))
    trial = only(tmp_path, "g", "deg/s")
    # a division and a multiplication
    np.testing.assert_allclose(trial.acceleration, whole["imu_acc"], rtol=1e-15)
    np.testing.assert_allclose(trial.rate, whole["imu_gyr"], rtol=1e-15)


def test_a_field_is_read_and_says_where_north_is(tmp_path):
    trial = only(written(tmp_path, **mounted()))
    np.testing.assert_array_equal(trial.field, mounted()["imu_mag"])
    begins = Rotation.from_quat(trial.start, scalar_first=True)
    # the accelerometers' noise of 0.02 m/s^2 is 0.1 deg
    assert np.degrees((begins * MOUNTED.inv()).magnitude()) < 0.5


@pytest.mark.parametrize("missing", [np.nan, 0.0])
def test_a_field_that_comes_late(missing, tmp_path):
    whole = mounted()
    late = whole | {"imu_mag": whole["imu_mag"].copy()}
    late["imu_mag"][:40] = missing
    begins = Rotation.from_quat(only(written(tmp_path, **late)).start, scalar_first=True)
    assert np.degrees((begins * MOUNTED.inv()).magnitude()) < 0.5
    late["imu_mag"][:RESTING] = missing
    trial = only(written(tmp_path, **late))
    assert trial.start is None
    assert trial.field.shape == (SAMPLES, 3)


def test_without_a_magnetometer_six_axes_compete(tmp_path):
    written(tmp_path, "01_undisturbed_swing")
    assert "mahony_field" in [task.problem.name for task in planned(tmp_path).tasks]
    written(tmp_path, "02_undisturbed_swing", seed=2, imu_mag=None)
    assert [trial.field is None for trial in read(str(tmp_path), "m/s^2", "rad/s", None)] == [
        False,
        True,
    ]
    names = [task.problem.name for task in planned(tmp_path).tasks]
    assert names == [
        *("room", "room_now", "gravity", "two_step", "mahony", "madgwick"),
        *("gravity_lead", "two_step_lead", "mahony_lead", "madgwick_lead"),
        *(f"without_{swing}" for swing in SWINGS),
        *(f"room_now_without_{swing}" for swing in SWINGS),
        *(f"alone_{swing}" for swing in SWINGS),
    ]
    sentence = r"^madgwick_field need a magnetic field .* 02_undisturbed_swing has none; leave .*"
    with pytest.raises(ValueError, match=sentence):
        planned(tmp_path, contestants=("madgwick_field",))


def test_what_is_infinite_in_a_field_is_missing(tmp_path):
    field = made(1)["imu_mag"].copy()
    field[8] = np.inf
    trial = only(written(tmp_path, imu_mag=field))
    assert np.isnan(trial.field[8]).all()
    assert not np.isnan(np.delete(trial.field, 8, axis=0)).any()


def test_a_field_without_a_number_is_none(tmp_path):
    trial = only(written(tmp_path, imu_mag=np.full((SAMPLES, 3), np.nan)))
    assert trial.field is trial.start is None


def planned(folder, **settings):
    return plan(Settings(folder=str(folder), **settings), (), 0, "")


# ------------------------------------------------------------------------------------ refusing


def holed(name, at):
    values = made(1)[name].copy()
    values[at] = np.nan
    return {name: values}


def scaled(name, factor):
    return {name: factor * made(1)[name]}


REFUSED = {
    "missing array": ({"opt_quat": None}, "01_undisturbed_swing.mat has no opt_quat"),
    "missing rate": ({"sampling_rate": None}, "has no sampling_rate"),
    "rate zero": ({"sampling_rate": 0.0}, "has a sampling_rate of 0 Hz; it must be positive"),
    "rate empty": ({"sampling_rate": np.zeros((0, 0))}, "sampling_rate"),
    "rate negative": ({"sampling_rate": -1.0}, "has a sampling_rate of -1 Hz; it must be positive"),
    "rates": ({"sampling_rate": np.ones(2)}, "has 2 numbers as sampling_rate; give one, in Hz"),
    "rate NaN": ({"sampling_rate": np.nan}, "has a sampling_rate of nan Hz"),
    "transposed": (
        {"imu_gyr": made(1)["imu_gyr"].T},
        "column 'imu_gyr' (mapped to gyr) has shape (3, 600), so its samples lie in rows",
    ),
    "field": (
        {"imu_mag": np.ones((SAMPLES, 2))},
        "mag has 3 axes (x, y, z), and 'imu_mag' is 2 columns",
    ),
    "short": (
        {"opt_quat": made(1)["opt_quat"][:-1]},
        "column 'opt_quat' (mapped to att) has 599 rows where 'imu_gyr' has 600",
    ),
    "NaN": (holed("imu_acc", (7, 1)), "imu_acc of 01_undisturbed_swing has no number at sample 7"),
    "NaN rate": (holed("imu_gyr", (9, 0)), "imu_gyr of 01_undisturbed_swing has no number at"),
    "no rest": (
        {"movement": np.ones((SAMPLES, 1), bool)},
        "01_undisturbed_swing rests for 0 s before its movement; 1 s are needed",
    ),
    "no movement": ({"movement": np.zeros((SAMPLES, 1), bool)}, "01_undisturbed_swing"),
    "no truth": (holed("opt_quat", slice(None)), "column 'opt_quat' (mapped to att) is missing in"),
    "no truth in motion": (
        holed("opt_quat", slice(RESTING, None)),
        "is NaN throughout the movemen",
    ),
    "truth of zeros": (
        {"opt_quat": np.zeros((SAMPLES, 4))},
        "opt_quat of 01_undisturbed_swing",
    ),
    "g": (scaled("imu_acc", 1 / GRAVITY), "which is in g, not m/s^2; say so with --set acc_unit=g"),
    "twice": (scaled("imu_acc", 2.0), "read 19.62 m/s^2 at rest, and gravity is 9.81; check"),
    "degrees": (scaled("imu_gyr", np.degrees(1)), "not rad/s; say so with --set gyr_unit=deg/s"),
    "thrice": (scaled("imu_gyr", 3.0), "times the rate of the truth; check their unit"),
    "axes": (
        {"imu_acc": made(1)["imu_acc"][:, ::-1]},
        "the accelerometers of 01_undisturbed_swing at rest are 90 deg off the truth's vertical",
    ),
    "inverted truth": (
        {"opt_quat": np.roll(made(1)["opt_quat"], 1, axis=1)},
        "are 180 deg off the truth's",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_trial_that_cannot_be_used_is_refused_in_a_sentence(case, tmp_path):
    changed, sentence = REFUSED[case]
    written(tmp_path, **changed)
    # one line: the dot matches no end of it
    with pytest.raises(ValueError, match=rf"^.*{re.escape(sentence)}.*\Z"):
        only(tmp_path)


@pytest.mark.parametrize(
    ("units", "sentence"),
    [
        (("g", "rad/s"), "read 96.19 m/s.2 at rest, and gravity is"),
        (("m/s^2", "deg/s"), "times the rate"),
    ],
)
def test_a_wrong_unit_is_refused(units, sentence, tmp_path):
    written(tmp_path)
    with pytest.raises(ValueError, match=sentence):
        only(tmp_path, *units)


def damage(path):
    path.write_bytes(path.read_bytes()[:5000])


def no_matrix(path):
    path.write_bytes(b"time,acc\n0,1\n")


def empty(path):
    path.write_bytes(b"")


@pytest.mark.parametrize("spoil", [damage, no_matrix, empty])
def test_a_damaged_file_is_refused(spoil, tmp_path):
    spoil(written(tmp_path) / "01_undisturbed_swing.mat")
    with pytest.raises(ValueError, match=r"^01_undisturbed_swing.mat(:| has no) [^\n]*\Z"):
        only(tmp_path)


@pytest.mark.parametrize("name", ["", "nowhere", "."])
def test_a_folder_without_trials_is_refused(name, tmp_path):
    folder = str(tmp_path / name) if name else ""
    with pytest.raises(ValueError, match=r"there are no recordings .*--set folder=PATH"):
        read(folder, "m/s^2", "rad/s", None)


def test_trials_of_two_rates_are_refused(tmp_path):
    written(tmp_path, "01_undisturbed_swing", sampling_rate=HZ)
    written(tmp_path, "02_undisturbed_swing", sampling_rate=1.1 * HZ)
    with pytest.raises(ValueError, match="sample rates from 50 to 55 Hz; give those of one rate"):
        read(str(tmp_path), "m/s^2", "rad/s", None)


@pytest.mark.parametrize("words", [[], ["--set", "folder=nowhere"]])
def test_the_command_line_says_so_in_one_line(words, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    assert invoke(["run", "broad", *words, "--out", "run"]) == 2
    said = capfd.readouterr()
    assert said.out == ""
    assert said.err.startswith("tuner: there are no recordings")
    assert "--set folder=PATH" in said.err
    assert said.err.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


# ------------------------------------------------------------------------------------- judging


def inclination_rmse(q, truth):
    """In NumPy: the angle between the two verticals, where there is a truth, deg."""
    seen = ~np.isnan(truth).any(axis=1)
    found, true = (Rotation.from_quat(rows[seen], scalar_first=True) for rows in (q, truth))
    up = (found * true.inv()).apply([0.0, 0.0, 1.0])
    angle = np.arctan2(np.hypot(up[:, 0], up[:, 1]), up[:, 2])
    return np.degrees(np.sqrt(np.mean(angle**2)))


def alone(trial):
    """The error of one trial, by hand: in its own blocks, without an unfinished one."""
    samples = ImuSample(jnp.asarray(trial.acceleration), jnp.asarray(trial.rate))
    cut = blocks(samples, round(BLOCK * trial.rate_hz))
    filter = filter_of("room", trial.rate_hz)
    _, found = compiled(filter, assembled(filter, start("room")), cut)
    q = np.asarray(found.att).reshape(-1, 4)
    return inclination_rmse(q, trial.truth[: len(q)])


@pytest.fixture(scope="module")
def pair(tmp_path_factory):
    """A longer and a shorter trial."""
    folder = tmp_path_factory.mktemp("pair")
    written(folder, "01_undisturbed_swing", seed=1)
    short = {k: v[:500] if np.size(v) > 1 else v for k, v in made(2).items()}
    written(folder, "02_undisturbed_swing", seed=2, **short)
    return Contest(tuple(read(str(folder), "m/s^2", "rad/s", None)))


def test_errors_of_trials_side_by_side(pair):
    """The shorter trial, filled up beside the longer, has the error that it has alone."""
    assert [len(trial.rate) for trial in pair.trials] == [SAMPLES, 500]
    found = pair.judged("room", start("room"))
    errors = found.inclination
    assert errors.shape == (2,)
    assert (errors < 0.5).all()
    # a compilation of its own: rounding, which the corrections keep small
    assert errors[1] == pytest.approx(alone(pair.trials[1]), rel=1e-9)
    np.testing.assert_array_equal(np.isnan(found.last[:500]), np.isnan(pair.trials[1].truth[:, 0]))
    assert np.sqrt(np.nanmean(found.last**2)) == pytest.approx(errors[1], rel=1e-9)
    filled = side_by_side("room", pair.trials)
    assert filled.inputs.gyr.shape == (SAMPLES // 10, 2, 10, 3)
    at_rest = filled.inputs.acc[50:, 1].reshape(-1, 3)
    np.testing.assert_array_equal(at_rest, np.tile(pair.trials[1].acceleration[-1], (100, 1)))
    assert not filled.inputs.gyr[50:, 1].any()
    assert np.isnan(filled.truth[50:, 1]).all()


def test_what_was_judged_is_kept(pair):
    assert pair.judged("room", start("room")) is pair.judged("room", start("room"))
    assert pair.judged("room_now", start("room_now")) is pair.judged("room", start("room"))
    assert pair.data("room") is pair.data("room_now")


def test_a_field_gives_the_heading(tmp_path):
    """From a start 140 deg away from heading 0; the second trial has gaps in its field."""
    written(tmp_path, "01_undisturbed_swing", **mounted(1))
    gaps = mounted(2)
    gaps["imu_mag"][::3] = np.nan
    written(tmp_path, "02_undisturbed_swing", seed=2, **gaps)
    both = Contest(tuple(read(str(tmp_path), "m/s^2", "rad/s", None)))
    field = both.data("mahony_field").inputs.mag
    np.testing.assert_array_equal(field[:, 0], mounted(1)["imu_mag"])
    np.testing.assert_array_equal(field[:, 1], gaps["imu_mag"])
    assert both.data("mahony").inputs.mag is None
    found = both.judged("mahony_field", start("mahony_field"))
    assert (found.errors["total"] < 2.0).all()
    for part in ("heading", "inclination"):
        assert (found.errors[part] < found.errors["total"]).all()


# ------------------------------------------------------------------------------------ comparing


def solution(factor=1.0, **changed):
    values = {key: np.asarray(value) * factor for key, value in start("room").items()} | changed
    return SimpleNamespace(
        value=0.0,
        status=SimpleNamespace(trusted=True),
        parameters={key: SimpleNamespace(value=value, unit="m") for key, value in values.items()},
    )


def test_trials_left_out_are_judged_by_the_parameters_of_the_others(pair):
    folds = [solution(2.0), solution(0.5)]
    names = [f"without_{trial.name}" for trial in pair.trials]
    found = {(name, "x"): each for name, each in zip(names, folds, strict=True)}
    errors = other_filters.left_out(Case(pair, range(2), ()), found)
    for i in range(2):
        values = {key: p.value for key, p in folds[i].parameters.items()}
        assert errors[i] == pytest.approx(pair.judged("room", values).inclination[i], rel=1e-12)
    assert errors[0] != pair.judged("room", start("room")).inclination[0]
    np.testing.assert_array_equal(other_filters.left_out(Case(pair, [1], ()), found), errors[1:])


def solved(*trials):
    """The problems of the room filters, with trials left out."""
    kinds = ("without", "room_now_without", "alone")
    return ["room", "room_now", *(f"{kind}_{trial}" for kind in kinds for trial in trials)]


def compared(case, found):
    return [row for each in claims.claims_of(case) for row in each.compare(case, found)]


def test_a_claim_alone_solves_what_it_needs(tmp_path):
    written(tmp_path, "01_undisturbed_swing")
    written(tmp_path, "26_disturbed_swing", seed=2)
    whole = planned(tmp_path)
    folds = ["without_01_undisturbed_swing", "without_26_disturbed_swing"]
    now = [f"room_now_{name}" for name in folds]  # for those without a lead
    needs = {
        "inclination_loo_deg": folds,
        "inclination_vqf_tuned_deg": now,
        "inclination_vqf_lead_loo_deg": folds,
        "inclination_room_deg": ["room"],
        "inclination_madgwick_deg": ["madgwick", *now],
        "inclination_madgwick_lead_deg": ["madgwick_lead", *folds],
        "inclination_mahony_default_deg": now,
        "inclination_room_now_gain_deg": now,
        "inclination_gap_deg": [*folds, *(n.replace("without", "alone") for n in folds)],
        "inclination_gyroscopes_deg": now,
        "delay_lead_ms": ["room"],
        "delay_sensor_ms": [],
        "mahony_published_total_deg": [],
        "inclination_transfer_deg": ["room", "undisturbed"],
    }
    for name, problems in needs.items():
        assert [task.problem.name for task in whole.only([name]).tasks] == problems
    # nothing is transferred between calm trials
    calm = planned(written(tmp_path / "calm"), folds=0)
    assert "inclination_transfer_deg" not in [each.name for each in calm.claims]


def test_the_exported_room_filter_is_told_by_its_facts(pair):
    posed = pair.problem("room", "room")
    told = {q.name: q for q in posed.quantities(solution())}
    assert told["place"].meaning == "of the measurement that it stays where it was"
    held = {name: told[name].value.tolist() for name in ("speed", "bias0", "tilt0", "gyroscope")}
    assert held == {"speed": 0.3, "bias0": 0.02, "tilt0": 0.03, "gyroscope": 0.0}
    assert told["q0"].value.tolist() == [0.0, 0.0, 0.0, 0.0]
    exported = posed.what_is_exported()
    assert (exported.filter, exported.dt) == ("BoundedMotionKalman", 1 / HZ)
    assert exported.states[:3] == ("turn_x", "turn_y", "turn_z")
    assert exported.states[-1] == "matrix_zz"


PEERS = {"worse": (0.9, Verdict.HOLDS), "better": (1e-3, Verdict.FAILS)}


@pytest.mark.parametrize("case", PEERS)
def test_the_room_filter_is_held_against_peers(case, pair, monkeypatch):
    error, verdict = PEERS[case]
    theirs = np.array([5.0, error])
    peer = peers.Peer(theirs, theirs, 2.0, theirs, (2.0, 0.002), theirs, theirs)
    monkeypatch.setattr(other_filters, "vqf", lambda contest: peer)
    found = {(name, "x"): solution() for name in solved("02_undisturbed_swing")}
    table = {row.quantity: row for row in compared(Case(pair, [1], ("room",)), found)}
    own = pair.judged("room", start("room")).inclination
    assert table["inclination_loo_deg"].ours == own[1]
    for theirs in ("", "_tuned", "_lead", "_lead_loo", "_lead_alone"):
        row = table[f"inclination_vqf{theirs}_deg"]
        assert ("without a lead" in row.where) == ("lead" not in theirs)
        # only the trial that was left out decides; the number is that of all
        assert (row.verdict, row.ours) == (verdict, pytest.approx((5.0 + error) / 2))
    for state in ("_default", ""):
        assert table[f"inclination_room{state}_deg"].ours == pytest.approx(own.mean())
        assert table[f"inclination_room{state}_deg"].verdict is Verdict.HOLDS
    assert table["mahony_published_total_deg"].verdict is Verdict.NOT_IDENTIFIABLE
    assert "01_undisturbed_swing" in table["mahony_published_total_deg"].note


def test_without_vqf_nothing_is_claimed_of_it(pair, monkeypatch):
    monkeypatch.setattr(other_filters, "vqf", lambda contest: None)
    table = compared(Case(pair, [], ("room",)), {(name, "x"): solution() for name in solved()})
    found = {row.quantity: row for row in table}
    assert found["inclination_vqf_tuned_deg"].verdict is Verdict.NOT_IDENTIFIABLE
    assert found["inclination_vqf_deg"].ours is None
    assert found["inclination_vqf_lead_alone_deg"].verdict is Verdict.NOT_IDENTIFIABLE
    assert "inclination_gap_deg" not in found
    assert "inclination_loo_deg" not in found


def test_vqf_is_judged_like_the_others(pair):
    package = pytest.importorskip("vqf")
    found = peers.vqf(pair)
    for i, trial in enumerate(pair.trials):
        rate, acceleration = (np.ascontiguousarray(x) for x in (trial.rate, trial.acceleration))
        q = package.VQF(1 / HZ).updateBatch(rate, acceleration)["quat6D"]
        assert found.default[i] == pytest.approx(inclination_rmse(q, trial.truth), rel=1e-9)
    assert found.tuned.mean() <= found.default.mean()
    # tuned on one trial alone, no time constant and lead that were tried for both are better on it
    assert (found.alone <= found.ahead + 1e-4).all()
    assert (found.alone <= found.left_out + 1e-4).all()


# ------------------------------------------------------------------------------------ published

PAPER = {"madgwick": (4.96, 3.92, 2.71), "mahony": (7.49, 6.30, 3.70)}


@pytest.mark.parametrize("name", PAPER)
def test_published_errors_of_all_trials_are_those_of_the_paper(name):
    assert len(paper.NAMES) == 39
    found = paper.means(name, paper.NAMES)
    assert tuple(found) == paper.PARTS
    np.testing.assert_allclose(list(found.values()), PAPER[name], rtol=0, atol=0.005)


# The group means of the authors' files, which catch what a mean over all would let pass.
GROUPS = {
    "rotation": (range(1, 10), (2.5874, 2.2215, 1.2717), (4.3982, 4.1535, 1.4129)),
    "translation": (range(10, 19), (5.1372, 3.7517, 3.2740), (10.1456, 8.5910, 5.1571)),
    "combined": (range(19, 24), (5.8077, 4.7018, 3.0617), (5.7569, 4.1563, 3.9268)),
    "tapping": (range(24, 26), (2.8423, 2.0004, 2.0192), (4.0932, 3.7591, 1.6059)),
    "vibration": (range(26, 28), (6.7604, 6.3828, 1.6916), (5.4778, 5.1740, 1.6213)),
    "stationary magnet": (range(28, 32), (6.6357, 5.0063, 3.7976), (8.0382, 5.5062, 5.8256)),
    "attached magnet": (range(32, 37), (6.9240, 5.4072, 3.7874), (13.0808, 11.5164, 5.3152)),
    "office": (range(37, 39), (5.6688, 4.7851, 2.9299), (4.2592, 3.2974, 2.6948)),
}


@pytest.mark.parametrize("group", GROUPS)
def test_published_errors_of_groups(group):
    numbers, *means = GROUPS[group]
    names = [name for name in paper.NAMES if int(name[:2]) in numbers]
    assert len(names) == len(numbers)
    for name, expected in zip(("madgwick", "mahony"), means, strict=True):
        found = list(paper.means(name, names).values())
        np.testing.assert_allclose(found, expected, rtol=0, atol=6e-4)  # three decimals are kept


def test_nothing_is_published_of_other_trials():
    with pytest.raises(ValueError, match=r"^nothing is published of 40_walk: .*not of BROAD\Z"):
        paper.means("mahony", ["40_walk", paper.NAMES[0]])


def stand_in(names=paper.NAMES[:3], factor=1.0, whole=True, start=True):
    """A contest in which filters do as published, times a factor."""

    def judged(name, values):
        found = paper.means(name.removesuffix("_field"), names)
        return Outcome({part: np.array([factor * error]) for part, error in found.items()}, None)

    trials = [SimpleNamespace(name=name, start=start or None, disturbed=False) for name in names]
    return SimpleNamespace(trials=trials, whole=whole, judged=judged)


def published(contest):
    case = Case(contest, [], ())
    each = [c for c in claims.claims_of(case) if "_published_" in c.name]
    return [row for claim in each for row in claim.compare(case, {})]


@pytest.mark.parametrize(
    ("factor", "verdict"),
    [(1.0, Verdict.MATCH), (0.985, Verdict.MATCH), (1.03, Verdict.DIFFERS)],
)
def test_published_errors_are_those_of_the_same_trials(factor, verdict):
    found = published(stand_in(factor=factor))
    assert [row.quantity for row in found] == [
        f"{name}_published_{part}_deg"
        for name in ("madgwick", "mahony")
        for part in ("total", "heading", "inclination")
    ]
    assert {row.verdict for row in found} == {verdict}
    assert found[0].paper == pytest.approx((2.310 + 1.497 + 2.471) / 3)
    assert found[0].ours == pytest.approx(factor * found[0].paper)
    assert "3 of 39 trials" in found[0].where
    assert found[3].note.startswith("7.49 over all")


INCOMPARABLE = {
    "foreign": ({"names": paper.NAMES[:1]}, "40_walk", "nothing is published of 40_walk"),
    "cut": ({"whole": False}, None, "only a part of each trial"),
    "no field": ({"start": False}, None, "no imu_mag at rest in 01_undisturbed_slow_rotation_A"),
}


@pytest.mark.parametrize("case", INCOMPARABLE)
def test_other_samples_than_the_published_ones_are_not_compared(case):
    changed, name, sentence = INCOMPARABLE[case]
    contest = stand_in(**changed)
    if name:
        contest.trials.append(SimpleNamespace(name=name, start=True, disturbed=False))
    found = published(contest)
    assert [(row.verdict, row.ours) for row in found] == 6 * [(Verdict.NOT_IDENTIFIABLE, None)]
    assert found[0].note.startswith(sentence)


# ------------------------------------------------------------------------------------ drawing


class Judged:
    """Trials of 4 s at 50 Hz whose errors are their numbers; in the last, 1.2 s to 3 s count."""

    def __init__(self, names):
        self.trials = [
            SimpleNamespace(name=name, disturbed="_disturbed_" in name) for name in names
        ]
        self.rate_hz = 50.0

    def data(self, name):
        return SimpleNamespace(truth=np.zeros((200, len(self.trials), 4)))

    def judged(self, name, values):
        errors = 1.0 + np.arange(len(self.trials))
        last = np.full(200, np.nan)
        last[50:150] = np.repeat([3.0, 4.0], 50)
        last[50:60] = np.nan
        last[100:125] = 0.0
        return Outcome({"inclination": errors}, last)

    def judged_each(self, name, values):
        return self.judged(name, None)


def test_figures(monkeypatch):
    names = ["01_calm", "03_calm", "26_disturbed_a", "28_disturbed_b"]
    found = {("room", "x"): solution()} | {(f"without_{n}", "x"): solution() for n in names}
    by_trial, in_time = figures(Case(Judged(names), [0, 2], ("room",)), found)
    room, left = by_trial.lines
    np.testing.assert_array_equal(left.x, [1, 26])
    np.testing.assert_array_equal(left.y, [1, 3])
    np.testing.assert_array_equal(room.x, [1, 3, 26, 28])
    np.testing.assert_array_equal(room.y, [1, 2, 3, 4])
    assert by_trial.x_label == "number of the trial"
    assert by_trial.title == "Mean inclination error of 4 trials, with a lead: room 2.50 deg"
    assert in_time.title == "Inclination error in 28_disturbed_b, with a lead: room 4.00 deg"
    (line,) = in_time.lines
    np.testing.assert_allclose(line.x, [1.5, 2.5])
    # half of the second window has no error at all
    np.testing.assert_allclose(line.y, [3.0, 4.0 / np.sqrt(2)])


def test_trials_without_numbers_stand_in_a_row():
    case = Case(Judged(["a", "b_disturbed_x"]), [], ("room",))
    by_trial, _ = figures(case, {("room", "x"): solution()})
    np.testing.assert_array_equal(by_trial.lines[0].x, [1, 2])
    assert by_trial.x_label == "trial, in the order of their names"


# --------------------------------------------------------------------------------- real trials


@pytest.mark.skipif(not REAL.is_dir(), reason="no recordings of BROAD beside the repository")
def test_a_real_trial_at_the_start_values(tmp_path):
    (path,) = REAL.glob("16_*.mat")
    shutil.copy(path, tmp_path)
    trial = only(tmp_path)
    assert trial.rate_hz == pytest.approx(2000 / 7)
    assert not trial.disturbed
    assert 0.2 < alone(trial) < 0.7


@pytest.mark.skipif(not REAL.is_dir(), reason="no recordings of BROAD beside the repository")
def test_a_real_trial_has_the_published_errors(tmp_path):
    """Mahony's filter with a magnetometer, which the authors ran in single precision."""
    (path,) = REAL.glob("16_*.mat")
    shutil.copy(path, tmp_path)
    trial = only(tmp_path)
    found = Contest((trial,)).judged("mahony_field", start("mahony_field"))
    for part, error in paper.means("mahony", [trial.name]).items():
        assert found.errors[part][0] == pytest.approx(error, rel=claims.CLOSE)
