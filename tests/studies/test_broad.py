"""The BROAD study on synthetic trials: reading, refusing and judging; one real trial if there."""

import re
import shutil
from functools import cache
from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from scipy.io import savemat
from scipy.spatial.transform import Rotation

from filters import ImuSample, blocks, run
from studies.broad import contest
from studies.broad.contest import BLOCK, FREE, filter_of, judged, room, side_by_side
from studies.broad.trials import GRAVITY, read
from tuner.cli import invoke
from tuner.simulation import Sensor, Swing, measure, simulate

REAL = Path(__file__).parents[2].parent / "shared" / "data" / "broad" / "data_mat"
HZ, REST, SECONDS = 50.0, 2.0, 12.0
RESTING, SAMPLES = round(REST * HZ), round(SECONDS * HZ)
QUICK = {"xla_backend_optimization_level": 0}
compiled = jax.jit(run, static_argnums=0, compiler_options=QUICK)
LOST = slice(300, 310)
"""Samples in motion of which the cameras have lost the truth."""


@pytest.fixture(scope="module", autouse=True)
def quick():
    """Without the compiler's optimisation, which changes no formula and takes most of the time."""
    with pytest.MonkeyPatch.context() as patch:
        for module, name in [(contest, "_judged")]:
            function = getattr(module, name).__wrapped__
            patch.setattr(module, name, jax.jit(function, static_argnums=0, compiler_options=QUICK))
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
        "imu_acc": np.asarray(sample.acceleration),
        "imu_gyr": np.asarray(sample.rate),
        "imu_mag": np.ones((SAMPLES, 3)),
        "opt_quat": truth,
        "opt_pos": np.zeros((SAMPLES, 3)),
        "movement": (np.arange(SAMPLES) >= RESTING)[:, None],
        "sampling_rate": HZ,
    }


def written(folder, name="01_undisturbed_swing", seed=1, **changed):
    """A trial's file; what is changed to None is left out."""
    arrays = {key: value for key, value in (made(seed) | changed).items() if value is not None}
    savemat(folder / f"{name}.mat", arrays)
    return folder


def only(folder, acc_unit="m/s^2", gyr_unit="rad/s", seconds=None):
    (trial,) = read(str(folder), acc_unit, gyr_unit, seconds)
    return trial


# ------------------------------------------------------------------------------------ reading


def test_a_trial_is_read_as_it_was_written(tmp_path):
    trial = only(written(tmp_path))
    whole = made(1)
    assert (trial.name, trial.rate_hz, len(trial.sha256)) == ("01_undisturbed_swing", HZ, 64)
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
    assert found[0].sha256 != found[1].sha256


def test_units_are_converted(tmp_path):
    whole = made(1)
    written(tmp_path, imu_acc=whole["imu_acc"] / GRAVITY, imu_gyr=np.degrees(whole["imu_gyr"]))
    trial = only(tmp_path, "g", "deg/s")
    # a division and a multiplication
    np.testing.assert_allclose(trial.acceleration, whole["imu_acc"], rtol=1e-15)
    np.testing.assert_allclose(trial.rate, whole["imu_gyr"], rtol=1e-15)


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
    "rate NaN": ({"sampling_rate": np.nan}, "has a sampling_rate of nan Hz"),
    "transposed": (
        {"imu_gyr": made(1)["imu_gyr"].T},
        "imu_gyr of 01_undisturbed_swing.mat has the shape (3, 600); 600 samples of movement need "
        "(600, 3)",
    ),
    "short": ({"opt_quat": made(1)["opt_quat"][:-1]}, "opt_quat of 01_undisturbed_swing.mat has"),
    "NaN": (holed("imu_acc", (7, 1)), "imu_acc of 01_undisturbed_swing has no number at sample 7"),
    "NaN rate": (holed("imu_gyr", (9, 0)), "imu_gyr of 01_undisturbed_swing has no number at"),
    "no rest": (
        {"movement": np.ones((SAMPLES, 1), bool)},
        "01_undisturbed_swing rests for 0 s before its movement; 1 s are needed",
    ),
    "no movement": ({"movement": np.zeros((SAMPLES, 1), bool)}, "01_undisturbed_swing"),
    "no truth": (holed("opt_quat", slice(None)), "is NaN throughout the movement: there is no tru"),
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
        "at rest the accelerometers of 01_undisturbed_swing point 90 deg away from the truth's",
    ),
    "inverted truth": (
        {"opt_quat": np.roll(made(1)["opt_quat"], 1, axis=1)},
        "point 180 deg away from the truth's",
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
        (("g", "rad/s"), "read 96.2. m/s.2 at rest, and gravity is"),
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
    with pytest.raises(ValueError, match=r"01_undisturbed_swing.mat is no MAT v5 file that can be"):
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


def start(name="room"):
    return {key: p.constrain(jnp.asarray(p.start())) for key, p in FREE[name].items()}


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
    _, found = compiled(filter_of("room", trial.rate_hz), room(start()), cut)
    q = np.asarray(found.q).reshape(-1, 4)
    return inclination_rmse(q, trial.truth[: len(q)])


def test_errors_of_trials_side_by_side(tmp_path):
    """The shorter trial, filled up beside the longer, has the error that it has alone."""
    written(tmp_path, "01_undisturbed_swing", seed=1)
    short = {k: v[:500] if np.size(v) > 1 else v for k, v in made(2).items()}
    written(tmp_path, "02_undisturbed_swing", seed=2, **short)
    trials = read(str(tmp_path), "m/s^2", "rad/s", None)
    assert [len(trial.rate) for trial in trials] == [SAMPLES, 500]
    errors = judged("room", start(), trials)
    assert errors.shape == (2,)
    assert (errors < 0.5).all()
    # a compilation of its own: rounding, which the corrections keep small
    assert errors[1] == pytest.approx(alone(trials[1]), rel=1e-9)
    filled = side_by_side("room", trials)
    assert filled.inputs.rate.shape == (SAMPLES // 10, 2, 10, 3)
    at_rest = filled.inputs.acceleration[50:, 1].reshape(-1, 3)
    np.testing.assert_array_equal(at_rest, np.tile(trials[1].acceleration[-1], (100, 1)))
    assert not filled.inputs.rate[50:, 1].any()
    assert np.isnan(filled.truth[50:, 1]).all()


@pytest.mark.skipif(not REAL.is_dir(), reason="no recordings of BROAD beside the repository")
def test_a_real_trial_at_the_start_values(tmp_path):
    (path,) = REAL.glob("16_*.mat")
    shutil.copy(path, tmp_path)
    trial = only(tmp_path)
    assert trial.rate_hz == pytest.approx(2000 / 7)
    assert not trial.disturbed
    assert 0.2 < alone(trial) < 0.7
