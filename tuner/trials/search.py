"""The trials of one search, made by any number of processes on any number of machines.

Every process asks Optuna for a trial, says while it works on it that it does, and tells its value.
Trials of a process that was lost are given to another. The total is exact: a trial counts where
fewer than the total, of those with lower numbers, are finished, worked on or waiting.
"""

import contextlib
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from threading import Event, Thread
from typing import TYPE_CHECKING, Any, TypeAlias

from tuner.trials.database import (
    HEARTBEAT,
    DatabaseError,
    as_database_error,
    close,
    open_storage,
    quiet,
    watched,
)

if TYPE_CHECKING:
    import optuna

Evaluate: TypeAlias = "Callable[[optuna.Trial], float]"
"""The value of a trial, whose coordinates it suggests."""
POLL = 0.2
"""Between looks at what others have finished, s."""
UNFURNISHED = 10.0
"""After so long, s, a search that somebody entered and did not furnish is furnished by others."""
FEW = 8
"""Where so many times more trials are free than were made since, nobody looks what others do."""
_READY = "ready"


@dataclass(frozen=True, eq=False)
class Trials:
    """The trials of one search in a database that is open; see :func:`opened`.

    Attributes:
        url: of the database; "" for memory.
        storage: the database.
        study: Optuna's own, in it.
        total: how many trials are to be complete.
        watch: the same study as Optuna watches over lost processes; None in memory.
        marked: whether trials are told apart by marks; one without is nobody's.
    """

    url: str
    storage: Any
    study: "optuna.Study"
    total: int
    watch: "optuna.Study | None"
    marked: bool

    def complete(self) -> "list[optuna.trial.FrozenTrial]":
        """The trials that are finished and have a value, in the order of their numbers."""
        with as_database_error(self.url):
            return [t for t in self.known() if t.state.name == "COMPLETE"]

    def known(self) -> "list[optuna.trial.FrozenTrial]":
        """All trials, in the order of their numbers."""
        return self.study.get_trials(deepcopy=False)

    def work(self, evaluate: Evaluate, *, to_the_end: bool = True) -> int:
        """Make trials beside whoever else does, and return how many.

        Args:
            evaluate: gives the value of a trial.
            to_the_end: whether to wait for those that others make.

        Raises:
            DatabaseError: where the database is lost.
        """
        made, looked = 0, -math.inf
        free, since = 0, 0
        while True:
            if time.monotonic() - looked > HEARTBEAT:
                self.look_after_the_lost()
                looked = time.monotonic()
            if since >= free // FEW:
                free, since = self.free(), 0
            if free and self._made(evaluate):
                made, since = made + 1, since + 1
                continue
            free = 0
            if not to_the_end or len(self.complete()) >= self.total:
                return made
            time.sleep(POLL)  # the last ones are being made by others

    def make_one(self, evaluate: Evaluate) -> bool:
        """Make one trial; False where there is none to be made now."""
        return self.free() > 0 and self._made(evaluate)

    def free(self) -> int:
        """How many trials nobody has begun, or somebody lost."""
        with as_database_error(self.url):
            states = [t.state.name for t in self.known() if t.state.name != "FAIL"]
        return max(self.total - len(states), 0) + states.count("WAITING")

    def _made(self, evaluate: Evaluate) -> bool:
        trial = self._asked()
        if trial is None:
            return False
        try:
            with self._alive(trial):
                value = evaluate(trial)
        except BaseException as error:
            again = self.marked or not isinstance(error, Exception)
            with contextlib.suppress(DatabaseError):  # then it is looked after as lost
                self._give_back(trial, again=again)
            raise
        self._tell(trial, float(value))
        return True

    def look_after_the_lost(self) -> None:
        """Give trials to others whose process has said nothing for long."""
        import optuna

        if self.watch is None:
            return
        with as_database_error(self.url):
            for trial_id in self._unheard():
                self.storage.record_heartbeat(trial_id)
            with quiet():
                optuna.storages.fail_stale_trials(self.watch)

    def add(self, marks: Mapping[str, Any]) -> None:
        """Let somebody make one more trial, which is marked."""
        with as_database_error(self.url):
            _queue(self.study, marks)

    def _asked(self) -> "optuna.Trial | None":
        """A trial of the total; None where others have asked for the last at the same moment."""
        with as_database_error(self.url):
            trial = self.study.ask()
            counts = trial.number < self.total or self._lower(trial.number) < self.total
        if counts and (trial.user_attrs or not self.marked):
            return trial
        self._give_back(trial, again=False)
        return None

    def _lower(self, number: int) -> int:
        """How many trials of lower numbers count."""
        return sum(t.state.name != "FAIL" for t in self.known() if t.number < number)

    def _tell(self, trial: "optuna.Trial", value: float) -> None:
        """Store a value; one that comes after the trial was given to another process is left.

        Optuna's own ``tell`` reads the trial three times for what samplers with constraints do
        after it: a third of the time that a trial takes the database.
        """
        import optuna

        late = optuna.exceptions.UpdateFinishedTrialError
        states, failed = optuna.trial.TrialState, math.isnan(value)
        state, values = states.FAIL if failed else states.COMPLETE, None if failed else [value]
        with as_database_error(self.url), contextlib.suppress(late):
            self.storage.set_trial_state_values(trial._trial_id, state, values)

    def _give_back(self, trial: "optuna.Trial", *, again: bool) -> None:
        """End a trial without a value; again: another one at the same point is to be made."""
        import optuna

        state, late = optuna.trial.TrialState.FAIL, optuna.exceptions.UpdateFinishedTrialError
        with as_database_error(self.url), contextlib.suppress(late):
            given_back = self.study.tell(trial, state=state, skip_if_finished=True)
            if again:
                with quiet():
                    optuna.storages.RetryHeartbeatStaleTrialCallback()(self.study, given_back)

    def _unheard(self) -> list[int]:
        """Trials whose process has not said anything: lost before, Optuna would overlook it."""
        from sqlalchemy import text

        query = text(
            "select t.trial_id from trials t join studies s on s.study_id = t.study_id "
            "left join trial_heartbeats h on h.trial_id = t.trial_id "
            "where s.study_name = :name and t.state = 'RUNNING' and h.trial_id is null"
        )
        with self.storage.engine.connect() as connection:
            return [row[0] for row in connection.execute(query, {"name": self.study.study_name})]

    @contextmanager
    def _alive(self, trial: "optuna.Trial") -> Iterator[None]:
        """Say from a thread that a trial is worked on; Optuna does so in ``optimize`` alone.

        Short ones say nothing: who looks after the lost gives them time.
        """
        if self.watch is None:
            yield
            return
        say = partial(self.storage.record_heartbeat, trial._trial_id)
        over = Event()
        thread = Thread(target=self._say, args=(say, over), daemon=True)
        thread.start()
        try:
            yield
        finally:
            over.set()
            thread.join()

    def _say(self, say: Callable[[], None], over: Event) -> None:
        while not over.wait(HEARTBEAT):
            # Where the database is lost, the trial's end will tell.
            with contextlib.suppress(DatabaseError), as_database_error(self.url):
                say()
                self.storage.remove_session()


@contextmanager
def opened(
    url: str,
    name: str,
    total: int,
    sampler: "optuna.samplers.BaseSampler",
    facts: Mapping[str, Any],
    *,
    first: Mapping[str, float] | None = None,
    marks: Sequence[Mapping[str, Any]] = (),
) -> Iterator[Trials]:
    """The trials of a search, which is entered into the database where it is not there yet.

    Args:
        url: of the database; "" for memory.
        name: what is searched: equal for equal searches alone.
        total: how many trials are to be complete.
        sampler: draws the points.
        facts: what people who look into the database should know.
        first: the point of the first trial.
        marks: of trials that are told apart: one trial for each.

    Raises:
        DatabaseError: where the database cannot be used.
    """
    import optuna

    with ExitStack() as stack:
        storage = open_storage(url)
        stack.callback(close, storage)
        with as_database_error(url):
            study = _entered(storage, name, sampler)
            if _READY not in study.user_attrs:
                _furnish(study, facts, first, marks)
        watch = None
        if isinstance(storage, optuna.storages.RDBStorage):
            over_it = watched(url)
            stack.callback(close, over_it)
            with as_database_error(url):
                watch = optuna.load_study(study_name=name, storage=over_it)
        yield Trials(url, storage, study, total, watch, bool(marks))


def _entered(
    storage: "optuna.storages.BaseStorage",
    name: str,
    sampler: "optuna.samplers.BaseSampler",
) -> "optuna.Study":
    """The study of a name; one that another process has just made is furnished by that process."""
    import optuna

    try:
        return optuna.create_study(
            storage=storage, study_name=name, sampler=sampler, direction="minimize"
        )
    except optuna.exceptions.DuplicatedStudyError:
        study = optuna.load_study(study_name=name, storage=storage, sampler=sampler)
        until = time.monotonic() + UNFURNISHED
        while _READY not in study.user_attrs and time.monotonic() < until:
            time.sleep(POLL / 4)
        return study


def _furnish(
    study: "optuna.Study",
    facts: Mapping[str, Any],
    first: Mapping[str, float] | None,
    marks: Sequence[Mapping[str, Any]],
) -> None:
    if first is not None:
        study.enqueue_trial(dict(first), skip_if_exists=True)
    there = [trial.user_attrs for trial in study.get_trials(deepcopy=False)]
    for each in marks:
        if dict(each) not in there:
            _queue(study, each)
    for fact, value in facts.items():
        study.set_user_attr(fact, value)
    study.set_user_attr(_READY, True)


def _queue(study: "optuna.Study", marks: Mapping[str, Any]) -> None:
    import optuna

    waiting = optuna.trial.TrialState.WAITING
    study.add_trial(optuna.trial.create_trial(state=waiting, user_attrs=dict(marks)))
