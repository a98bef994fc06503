"""Syntax trees in threads: Python 3.11 fails where two are made at once."""

import ast
import gc
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import filters.linear
from tuner.syntax import parsed


def test_trees_in_threads():
    text = Path(filters.linear.__file__).read_text("utf-8")

    def hand_over(*_):
        """As JAX's callback of the collector does: another thread goes on."""
        time.sleep(1e-4)

    gc.callbacks.append(hand_over)
    try:
        with ThreadPoolExecutor(4) as pool:
            trees = list(pool.map(lambda _: parsed(text), range(24)))
    finally:
        gc.callbacks.remove(hand_over)
    assert {ast.dump(tree) == ast.dump(trees[0]) for tree in trees} == {True}
    assert isinstance(parsed("1 + x", mode="eval").body, ast.BinOp)
