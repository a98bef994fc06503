"""Where data come from: equal data have equal digests, and only they."""

import itertools

import jax.numpy as jnp
import numpy as np
import pytest

from tuner.data.source import Source

DRAW = np.random.default_rng(5).standard_normal((6, 2))


def digests(sources):
    return [source.sha256 for source in sources]


def all_differ(sources):
    found = digests(sources)
    assert all(len(one) == 64 for one in found)
    for one, other in itertools.combinations(found, 2):
        assert one != other


def test_simulated_records():
    source = Source.simulated("two", [DRAW, np.zeros(3)], 50.0)
    assert (source.name, source.samples, source.rate_hz) == ("two", 12, 50.0)
    assert Source.simulated("one", [DRAW[:, 0]], 50.0).samples == 6
    # The digest is that of the numbers, whatever they are called and wherever they lie.
    again = Source.simulated("again", [jnp.asarray(DRAW), np.zeros(3)], 50.0)
    assert again.sha256 == source.sha256
    assert Source.simulated("x", [np.asfortranarray(DRAW), np.zeros(3)], 50.0).sha256 == (
        source.sha256
    )


def test_digests_of_records_differ_where_anything_does():
    last = DRAW.copy()
    last[-1, -1] = np.nextafter(last[-1, -1], np.inf)
    records = [
        ([DRAW], 50.0),
        ([DRAW], 51.0),
        ([last], 50.0),
        ([DRAW.T], 50.0),
        ([DRAW.ravel()], 50.0),
        ([DRAW[:3], DRAW[3:]], 50.0),
        ([DRAW[3:], DRAW[:3]], 50.0),
        ([DRAW, np.zeros(0)], 50.0),
        ([DRAW.astype(np.float32)], 50.0),
    ]
    all_differ(Source.simulated("record", made, rate) for made, rate in records)


def test_joined_sources():
    one, two = (Source.simulated(name, [DRAW * k], 50.0) for name, k in (("a", 1), ("b", 2)))
    both = Source.joined("both", iter([one, two]))
    assert (both.name, both.samples, both.rate_hz) == ("both", 24, 50.0)
    longer = Source(one.name, one.sha256, one.samples + 1, one.rate_hz)
    faster = Source(one.name, one.sha256, one.samples, 100.0)
    joined = ([one, two], [two, one], [one, one], [longer, two], [faster, two])
    all_differ([*(Source.joined("both", parts) for parts in joined), one, two])
    assert Source.joined("alone", [one]) == one
    renamed = Source("c", one.sha256, one.samples, one.rate_hz)
    assert Source.joined("both", [renamed, two]).sha256 == both.sha256


def test_models():
    assert Source.model("plant", [1.0, 2]) == Source.model("plant", (1.0, 2))
    assert Source.model("plant", [1.0]).samples == 0
    assert Source.model("plant", [1.0], 10.0).rate_hz == 10.0
    assert Source.model("plant", [np.float64(1.0)]).sha256 == Source.model("x", [1.0]).sha256


def test_digests_of_models_differ_where_anything_does():
    long, fine = np.arange(2000.0), np.array([0.1, 0.2])
    changed = long.copy()
    changed[1000] += 1e-9
    models = (
        [1.0, 23.0],
        [1.02, 3.0],
        [1.0],
        [1],
        ["1.0"],
        [[1.0, 23.0]],
        [1.0, [23.0]],
        # NumPy's own text of an array shows eight digits, and leaves out the middle of long ones.
        [fine],
        [fine + np.array([0.0, 1e-12])],
        [fine, fine],
        [(fine, fine)],
        [long],
        [changed],
        [None],
        [],
    )
    all_differ(Source.model("model", numbers) for numbers in models)


@pytest.mark.parametrize("made", [[], ()])
def test_nothing_is_no_source(made):
    with pytest.raises(ValueError, match=r"^none: there are no records to name$"):
        Source.simulated("none", made, 1.0)
    with pytest.raises(ValueError, match=r"^none: there are no sources to join$"):
        Source.joined("none", made)
