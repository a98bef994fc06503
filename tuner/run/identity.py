"""The identity of a run: digests of all that its numbers depend on."""

import hashlib
from collections.abc import Callable, Mapping
from typing import Any

from tuner.code_version import OURS, code_of, code_version
from tuner.run.recipe import Recipe
from tuner.run.study import Plan, Study

WHAT = {
    "settings": "other settings or claims, another seed or log",
    "data": "other data",
    "code": "another version of the code",
}
"""The meaning of a difference in each part of an identity."""


def identity_of_run(study: Study, recipe: Recipe, plan: Plan) -> dict[str, str]:
    """The digests of a run's settings with its seed and logs, of its data, and of the code."""
    own = code_of(_module(study.plan))
    return {
        "settings": hashlib.sha256(recipe.to_toml()).hexdigest(),
        "data": plan.source.sha256,
        "code": hashlib.sha256(f"{code_version()}{own}".encode()).hexdigest(),
    }


def differences(one: Mapping[str, str], other: Mapping[str, str]) -> list[str]:
    """The differences between two runs in words; none where they are the same."""
    return [words for part, words in WHAT.items() if one.get(part) != other.get(part)]


def _module(plan: Callable[..., Any]) -> str:
    """The module that a plan's function is in; "" where it is our own."""
    function = getattr(plan, "func", plan)  # of a partial
    module = str(getattr(function, "__module__", ""))
    return "" if module.partition(".")[0] in OURS else module
