"""Symmetric matrices among the arrays of a loop."""

import jax
import jax.numpy as jnp
import numpy as np

from filters.small_linalg import contracted
from tuner.code.filled_rows import FilledRows
from tuner.code.straight_line import Slot, straight_line
from tuner.native.even import Carried, even_slots, without_turns

N = 10
START = np.eye(N)


def evenly(P):
    return (P + P.T) / 2


def moved(F, P, Q):
    """F P F' + Q, as filters compute it."""
    return evenly(contracted(F.T, contracted(P, F.T))) + Q


def analysed(step, F, Q, *, even=True):
    """Operations of a step, those without turns, results, and the symmetric matrices."""
    slots = [Slot((N, N), np.dtype(float)) for _ in range(3)]
    code = straight_line(jax.make_jaxpr(step)(F, START, Q), slots)
    carried = [Carried(slots[1], code.results[0], START, even)]
    found = even_slots(code.operations, carried, {slots[0]: F, slots[2]: Q})
    operations, results = without_turns(code.operations, code.results, carried, found)
    return code.operations, operations, results, found


def names(operations):
    return [one.name for one in operations]


def drawn(even):
    root = np.random.default_rng(7).normal(size=(N, N))
    return root @ root.T if even else root


def test_a_covariance_is_symmetric_and_its_products_need_no_turn():
    before, after, (result,), even = analysed(moved, drawn(False), drawn(True))
    products = [one for one in before if one.name == "dot_general"]
    assert [one.outputs[0] in even for one in products] == [False, True]
    assert result in even
    assert names(before).count("transpose") > names(after).count("transpose")
    assert not any(one.inputs[0] in even for one in after if one.name == "transpose")


def test_a_matrix_that_is_only_added_to_keeps_its_turn():
    """No product computes one half of it anew: what rounding adds would remain."""
    before, after, (result,), even = analysed(lambda F, P, Q: evenly(P) + Q, START, drawn(True))
    assert result in even
    assert names(after) == names(before)
    assert "transpose" in names(after)


def test_what_does_not_stay_symmetric_is_found():
    """It begins as the unit matrix; what is added is symmetric in one case alone."""
    for Q, stays in ((drawn(True), True), (drawn(False), False)):
        before, after, (result,), even = analysed(lambda F, P, Q: evenly(P) + Q, drawn(False), Q)
        assert (result in even) == stays
        assert names(after) == names(before)


def test_a_matrix_that_begins_otherwise_is_not_taken_as_symmetric():
    _, _, (result,), even = analysed(moved, drawn(False), drawn(False), even=False)
    assert result not in even


def test_small_matrices_are_left_alone():
    small = Slot((3, 3), np.dtype(float))
    code = straight_line(jax.make_jaxpr(lambda P: P + P.T)(jnp.eye(3)), [small])
    carried = [Carried(small, code.results[0], np.eye(3), even=True)]
    assert not even_slots(code.operations, carried, {})


def test_rows_are_filled_up_only_where_own_memory_is_read_along_them():
    rows = FilledRows(4)
    head = "for (int i1 = 0; i1 < 15; i1++) {"

    def longer(statement):
        return rows.longer([head, f"    {statement}"], {"m1", "m2", "table"})

    longest = (head.replace("15;", "16;"), 1)
    assert longer("m1[(16 * i0) + i1] = m2[i1 + 16] * table[i1] + p[i0];") == longest
    assert longer("m1[(16 * i0) + i1] = p[i1];") is None  # of others
    assert longer("m1[(16 * i0) + i1] = m2[(16 * i1) + i0];") is None  # across
    assert longer("m1[(16 * i0) + i1] = m2[table[i1]];") is None
    assert rows.longer(["while (n-- > 0) {", "m1[0] = 0.0;"], {"m1"}) is None
