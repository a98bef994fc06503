"""Work that other processors help with: the same results, in order, by threads that are kept."""

import threading
import time

import pytest

from tuner.processors import alone, beside_others, helped, side_by_side

PATIENCE = 30  # s


@pytest.fixture(params=[1, 2, 5])
def processors(request, monkeypatch):
    """So many processors, of whatever machine."""
    monkeypatch.setattr("os.cpu_count", lambda: request.param)
    return request.param


def test_results_have_the_order_of_what_is_given(processors):
    assert side_by_side(lambda one: one**2, range(40)) == [k**2 for k in range(40)]
    assert side_by_side(abs, []) == []


def test_each_processor_has_its_share(processors):
    together = threading.Barrier(processors)
    side_by_side(lambda _: together.wait(PATIENCE), range(processors))


def test_threads_are_kept(processors):
    def idents(_):
        time.sleep(1e-3)
        return threading.get_ident()

    used = {ident for _ in range(20) for ident in side_by_side(idents, range(8))}
    assert len(used) <= processors
    assert threading.get_ident() in used


def test_within_others_it_is_this_thread_alone(processors):
    def idents(_):
        inner = side_by_side(lambda _: (threading.get_ident(), alone()), range(4))
        return set(inner) == {(threading.get_ident(), processors == 1)}

    assert all(side_by_side(idents, range(8)))
    assert alone()
    with beside_others():
        assert not alone()
        with beside_others():
            pass
        assert not alone()
    assert alone()


def test_the_first_error_is_raised_and_nothing_else_begins(processors):
    begun, rest = [], threading.Event()

    def failing(k):
        begun.append(k)
        if k == 3:
            rest.wait(0.05)  # a later one fails first
        if k >= 3:
            raise ValueError(f"part {k}")

    with pytest.raises(ValueError, match="^part 3$"):
        side_by_side(failing, range(1000))
    assert len(begun) < 3 + 2 * processors
    assert alone()


def test_it_goes_on_without_threads_that_have_other_work(monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    over = threading.Event()
    with helped(lambda: over.wait(PATIENCE), 1) as ask:
        ask()
        assert (
            side_by_side(lambda _: threading.get_ident(), range(3)) == [threading.get_ident()] * 3
        )
        over.set()


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt])
def test_helpers_are_not_waited_for_where_something_is_raised(error, monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 2)
    begun, over, ended = threading.Event(), threading.Event(), threading.Event()

    def work():
        begun.set()
        over.wait(PATIENCE)
        ended.set()

    def raising():
        with helped(work, 3) as ask:
            ask()
            assert begun.wait(PATIENCE)
            raise error

    with pytest.raises(error):
        raising()
    assert not ended.is_set()
    over.set()
    assert ended.wait(PATIENCE)


def test_helpers_work_once_when_they_are_asked_and_are_waited_for(monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 3)
    begun, ended = threading.Barrier(3), []

    def work():
        begun.wait(PATIENCE)
        time.sleep(0.01)
        ended.append(0)

    with helped(work, 2):
        pass
    assert ended == []
    with helped(work, 2) as ask:
        ask()
        ask()
        begun.wait(PATIENCE)
    assert ended == [0, 0]
