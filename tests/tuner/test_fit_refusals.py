"""What a fit refuses on the command line: one sentence, exit code 2, and nothing written."""

import json
from importlib.metadata import EntryPoint

import numpy as np
import pytest

import tuner.catalogue
from tests.tuner import fit_cases as cases

SIX = ("--map", "gyr=gx,gy,gz:rad/s", "--map", "acc=ax,ay,az:m/s^2")
CLIMB = ("climb.csv", "--filter", "vertical", "--map", "acc=acc", "--map", "baro=baro")
QUATERNION = ("--truth", "att=q0,q1,q2,q3")


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    """The recordings that are spoilt below."""
    folder = tmp_path_factory.mktemp("good")
    cases.write(folder / "level.csv", cases.level(samples=100))
    cases.write(folder / "climb.csv", cases.climb(samples=200))
    cases.write(folder / "imu.csv", cases.imu(seconds=8.0, bursts=False))
    return folder


def refused(outcome, here, *words):
    """Exit code 2, one sentence, the last line of stderr, and no folder."""
    code, out, err = outcome
    assert (code, out) == (2, ""), (out, err)
    assert [line for line in err.splitlines() if line.startswith("tuner: ")] == err.splitlines()[
        -1:
    ]
    assert "Traceback" not in err
    told = err.splitlines()[-1]
    for word in words:
        assert word in told
    assert not (here / "out").exists()
    assert not (here / "runs").exists()


def level(*words):
    return ("level.csv", "--filter", "local-level", *words)


def imu(*words, filter="madgwick"):
    return ("imu.csv", "--filter", filter, *words)


REFUSED = {
    "unknown filter": (("level.csv", "--filter", "local-levle"), ("local-level",)),
    "no map": (level(), ("--map", "z (measured level)")),
    "unknown channel": (level("--map", "y=z"), ("'y=z'", "'z', 'sigma'")),
    "unknown column": (level("--map", "z=zz"), ("'zz'", "z")),
    "unknown unit": (imu(*SIX[:2], "--map", "acc=ax,ay,az:m/sek", *QUATERNION), ("m/sek", "m/s")),
    "unit of another dimension": (
        imu("--map", "gyr=gx,gy,gz:m/s", *SIX[2:], *QUATERNION),
        ("m/s", "rad/s"),
    ),
    "needed channel not mapped": (
        imu(*SIX[:2], *QUATERNION),
        ("acc", "--map acc=COLUMN,COLUMN,COLUMN"),
    ),
    "channel mapped twice": (level("--map", "z=z", "--map", "z=level"), ("'z' is mapped 2 times",)),
    "too few columns": (imu("--map", "gyr=gx,gy:rad/s", *SIX[2:], *QUATERNION), ("gyr", "3")),
    "unknown truth": (level("--map", "z=z", "--truth", "lvl=level"), ("lvl", "level")),
    "detail as truth": (level("--map", "z=z", "--truth", "variance=level"), ("variance", "level")),
    "two truths": (
        (*CLIMB, "--truth", "height=baro", "--truth", "climb=acc"),
        ("height and climb", "give one"),
    ),
    "truth and likelihood": (
        level("--map", "z=z", "--truth", "level=level", "--objective", "likelihood"),
        ("likelihood takes no truth", "level"),
    ),
    "truth of too few parts": (
        imu(*SIX, "--truth", "att=q0,q1,q2"),
        ("att", "3", "4"),
    ),
    "no truth and no likelihood": (
        imu(*SIX),
        ("madgwick outputs no innovation", "--truth att=COLUMN,COLUMN,COLUMN,COLUMN"),
    ),
    "unknown objective": (level("--map", "z=z", "--objective", "likely"), ("likelihood",)),
    "objective without truth": (level("--map", "z=z", "--objective", "rmse"), ("--truth",)),
    "objective of an attitude": (
        level("--map", "z=z", "--truth", "level=level", "--objective", "heading"),
        ("heading", "attitude", "rmse"),
    ),
    "unknown solver": (level("--map", "z=z", "--solver", "nelder"), ("nelder-mead",)),
    "no start": (level("--map", "z=z", "--starts", "0"), ("--starts",)),
    "unknown start": (level("--map", "z=z", "--start", "QQ=1"), ("'QQ'", "R, q")),
    "unknown fix": (level("--map", "z=z", "--fix", "p=1"), ("'p'", "R, q")),
    "unknown bound": (level("--map", "z=z", "--bound", "p=1..2"), ("'p'", "R, q")),
    "unknown option": (level("--map", "z=z", "--set", "law=one"), ("'law'",)),
    "option of another kind": (
        (*CLIMB, "--set", "gravity=gone"),
        ("removed", "included"),
    ),
    "dt as option": (level("--map", "z=z", "--set", "dt=1"), ("'dt'",)),
    "start in words": (level("--map", "z=z", "--start", "q=small"), ("small", "number")),
    "start that is no number": (level("--map", "z=z", "--start", "q=nan"), ("nan", "finite")),
    "start without a value": (level("--map", "z=z", "--start", "q"), ("NAME=VALUE",)),
    "start twice": (level("--map", "z=z", "--start", "q=1", "--start", "q=2"), ("twice",)),
    "negative start": (level("--map", "z=z", "--start", "q=-1"), ("q", "positive")),
    "negative fix": (level("--map", "z=z", "--fix", "q=-1"), ("q", "negative")),
    "bound of one number": (level("--map", "z=z", "--bound", "q=1"), ("LOW..HIGH",)),
    "bound that falls": (level("--map", "z=z", "--bound", "q=2..1"), ("rise",)),
    "bound twice": (level("--map", "z=z", "--bound", "q=1..2", "--bound", "q=1..3"), ("twice",)),
    "start outside its bound": (
        level("--map", "z=z", "--start", "q=5", "--bound", "q=0.1..1"),
        ("q begins at 5", "0.1 to 1"),
    ),
    "fixed and started": (
        level("--map", "z=z", "--start", "q=5", "--fix", "q=5"),
        ("one of them",),
    ),
    "everything fixed": (
        level("--map", "z=z", "--fix", "q=1", "--fix", "R=1"),
        ("nothing is left to tune", "q, R"),
    ),
    "no such file": (("nowhere.csv", "--filter", "local-level", "--map", "z=z"), ("nowhere.csv",)),
    "unknown column of recordings": (level("--map", "z=z", "--by", "trip"), ("trip",)),
    "rate that is none": (level("--map", "z=z", "--rate", "-5"), ("-5",)),
}


@pytest.mark.parametrize("case", REFUSED)
def test_wishes_that_cannot_be(cli, here, recordings, case):
    words, told = REFUSED[case]
    (file, *rest) = words
    refused(cli("fit", recordings / file, *rest, "--out", "out"), here, *told)


def spoilt(columns, **changed):
    return columns | changed


def some(columns, rows):
    return {name: np.asarray(values)[rows] for name, values in columns.items()}


LEVEL, IMU = cases.level(samples=100), cases.imu(seconds=8.0, bursts=False)
TURNED = dict(zip(("q1", "q2", "q3"), (-IMU["q1"], -IMU["q2"], -IMU["q3"]), strict=True))
FACTORS = {
    "in g": {name: IMU[name] / 9.80665 for name in ("ax", "ay", "az")},
    "in degrees": {name: np.degrees(40 * IMU[name]) for name in ("gx", "gy", "gz")},
}
BAD = {
    "empty file": ("", level("--map", "z=z"), ("empty",)),
    "one sample": (some(LEVEL, slice(1)), level("--map", "z=z"), ("1",)),
    "all missing": (
        spoilt(LEVEL, z=np.full(100, np.nan)),
        level("--map", "z=z"),
        ("z", "missing"),
    ),
    "clock that runs backwards": (
        some(LEVEL, np.r_[0:50, 40, 51:100]),
        level("--map", "z=z"),
        ("t", "backwards"),
    ),
    "clock that restarts": (
        some(LEVEL, np.r_[0:50, 0:50]),
        level("--map", "z=z"),
        ("t",),
    ),
    "huge values": (spoilt(LEVEL, z=1e99 * LEVEL["z"]), level("--map", "z=z"), ("another unit",)),
    "acc in g": (spoilt(IMU, **FACTORS["in g"]), imu(*SIX, *QUATERNION), ("acc", ":g")),
    "acc half as large": (
        spoilt(IMU, **{name: 0.5 * IMU[name] for name in ("ax", "ay", "az")}),
        imu(*SIX, *QUATERNION),
        ("acc reads 4.9", "where 9.8 is right", "acc=...*2"),
    ),
    "acc without gravity": (
        spoilt(IMU, **{name: 0.01 * np.sin(9 * IMU["t"]) for name in ("ax", "ay", "az")}),
        imu(*SIX, *QUATERNION),
        ("acc reads", "gravity was taken out"),
    ),
    "gyr in degrees": (spoilt(IMU, **FACTORS["in degrees"]), imu(*SIX, *QUATERNION), ("deg/s",)),
    "truth in another frame": (
        spoilt(IMU, **TURNED),
        imu(*SIX, *QUATERNION),
        ("att", "up", "write att=q0,-q1,-q2,-q3"),
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_data_that_cannot_be(cli, here, case):
    data, (file, *words), told = BAD[case]
    if isinstance(data, str):
        (here / file).write_text(data)
    else:
        cases.write(here / file, data)
    refused(cli("fit", file, *words, "--out", "out"), here, *told)


def test_channels_that_never_overlap_in_time(cli, here):
    cases.write(here / "acc.csv", {"t": np.arange(50) / 10, "acc": np.sin(np.arange(50.0))})
    cases.write(here / "baro.csv", {"t": 100 + np.arange(50) / 10, "baro": np.arange(50.0)})
    words = ("--filter", "vertical", "--map", "acc=acc:m/s^2", "--map", "baro=baro:m")
    outcome = cli("fit", "acc.csv", "baro.csv", *words, "--out", "out")
    refused(outcome, here, "do not overlap")


def test_a_class_that_declares_nothing(cli, here, recordings, monkeypatch):
    class Plain:
        pass

    class Offered(EntryPoint):
        def load(self):
            return Plain

    installed = tuner.catalogue.entry_points

    def points(group):
        more = [Offered("plain", "plain:Plain", group)] if group == "tuner.filters" else []
        return [*installed(group=group), *more]

    monkeypatch.setattr(tuner.catalogue, "entry_points", points)
    words = (recordings / "level.csv", "--filter", "plain", "--map", "z=z", "--out", "out")
    refused(cli("fit", *words), here, "Plain declares no inputs", "filters.Channel")


@pytest.mark.parametrize("dry", [(), ("--dry-run",)], ids=["run", "dry"])
def test_no_folder_is_made_before_all_is_well(cli, here, recordings, dry):
    words = ("fit", recordings / "level.csv", "--filter", "local-level", "--map", "z=z", *dry)
    refused(cli(*words, "--objective", "rmse", "--out", "out"), here, "--truth")


# Data from which little can be learnt: a result or a sentence, never a traceback.

STRANGE = {
    "constant": spoilt(LEVEL, z=np.full(100, 3.0)),
    "zero": spoilt(LEVEL, z=np.zeros(100)),
    "three samples": some(LEVEL, slice(3)),
    "large values": spoilt(LEVEL, z=1e40 * LEVEL["z"]),
    "small values": spoilt(LEVEL, z=1e-40 * LEVEL["z"]),
    "one outlier": spoilt(LEVEL, z=np.where(LEVEL["t"] == 50, 1e9, LEVEL["z"])),
    "two measurements": spoilt(LEVEL, z=np.where(np.isin(LEVEL["t"], (3, 70)), 1.0, np.nan)),
}


@pytest.mark.parametrize("case", STRANGE)
@pytest.mark.parametrize("filter", ["local-level", "alpha-beta"])
def test_little_to_learn_from(cli, here, case, filter):
    cases.write(here / "level.csv", STRANGE[case])
    words = ("fit", "level.csv", "--filter", filter, "--map", "z=z", "--starts", 1)
    code, out, err = cli(*words, "--json", "--out", "out")
    assert "Traceback" not in err
    if code == 2:
        refused((code, out, err), here)
        return
    result = json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} is not JSON"))
    statuses = {s["status"] for s in result["solutions"] if not s["problem"].endswith("_part")}
    assert (code == 0) == (statuses == {"converged"})
    assert len(result["fit"]["lines"]) == 5
