"""Command lines with bad words."""

from collections.abc import Iterator
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from benchmarks.bad_inputs.case import Case
from benchmarks.bad_inputs.logs import text
from benchmarks.bad_inputs.mutate import HOSTILE, Random

LOG = "good.csv"
COMMANDS: dict[str, list[list[str]]] = {
    "run": [["kownacki2010"], ["design"], ["fit"], ["ha1981"], ["rest"], ["toy"]],
    "fit": [[LOG, "--filter", "local-level", "--map", "z=gx"], [LOG], []],
    "check": [["--filter", "local-level", "--log", LOG, "--map", "z=gx"], []],
    "columns": [[LOG], []],
    "list": [[], ["filters"], ["formats"]],
    "compare": [["nowhere"], []],
    "export": [["nowhere", "--to", "json"], []],
    "init": [[], ["--kind", "level"]],
}
OPTIONS = (
    "--log", "--map", "--truth", "--rate", "--time", "--by", "--from", "--to", "--set", "--claim",
    "--out", "--seed", "--storage", "--jobs", "--start", "--fix", "--bound", "--objective",
    "--solver", "--starts", "--filter", "--model", "--tol", "--problem", "--density", "--memory",
    "--precision", "--kind", "--output", "--drop-repeats", "--resume", "--force", "--json", "--md",
    "--tunable", "--no-hold-out", "--bogus",
)  # fmt: skip
KEYS = (
    "R", "Q", "P0", "q", "seconds", "step", "starts", "grid", "solvers", "cutoff_hz", "A", "C", "G",
    "sample_time", "error", "held_out", "against", "settings", "", "reading", "noise", "trials",
)  # fmt: skip


def drawn(strategy: Any, count: int, number: int) -> list[Any]:
    """A number of examples of a strategy, the same for the same number."""
    found: list[Any] = []

    @seed(number)
    @settings(
        max_examples=count, database=None, phases=[Phase.generate], deadline=None,
        suppress_health_check=list(HealthCheck), derandomize=False,
    )  # fmt: skip
    @given(strategy)
    def collect(example: Any) -> None:
        found.append(example)

    collect()
    return found


_word = st.one_of(
    st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), max_size=12),
    st.sampled_from([str(value)[:2000].replace("\0", "") for value in HOSTILE]).filter(
        lambda word: "\ud800" not in word
    ),
    st.floats().map(str),
    st.integers().map(str),
)
_pair = st.tuples(st.sampled_from(KEYS), _word).map("=".join)
_nest = st.integers(1, 3000).map(lambda n: f"P0={'[' * n}{']' * n}")


@st.composite
def _lines(draw: Any) -> tuple[str, ...]:
    command = draw(st.sampled_from(sorted(COMMANDS)))
    words = [command, *draw(st.sampled_from(COMMANDS[command]))]
    for _ in range(draw(st.integers(1, 3))):
        option = draw(st.sampled_from(OPTIONS))
        value = draw(st.one_of(_pair, _nest) if option == "--set" else st.one_of(_word, _pair))
        words += [option, value]
    if command in ("run", "fit"):
        words.append("--dry-run")
    return tuple(words)


def cases(random: Random) -> Iterator[Case]:
    """An endless series of command lines."""
    while True:
        for line in drawn(_lines(), 200, int(random.integers(2**31))):
            yield Case(f"line: {line[0]}", list(line), {LOG: text()})
