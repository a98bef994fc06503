"""What a type checker has to refuse: every line that ends in `# refused: CODE`, and no other.

None of these functions is ever called. See test_types.py.
"""

import tuner
from filters import Channel, GyroscopeFilter, Param
from objectives import ChannelRmse, StepResponse, Welch
from tuner import Data, Gradient, NelderMead, Positive, Problem, Solution, Space, read_record


def names() -> None:
    from tuner import Problm  # refused: attr-defined
    from tuner import GyroscopeFilter as Filter  # refused: attr-defined
    from tuner import StepResponse as Step  # refused: attr-defined
    from tuner import tanaka  # refused: attr-defined
    from filters import Nose  # refused: attr-defined
    from objectives import StepRespons  # refused: attr-defined
    from tuner.solvers import NelderMeed  # refused: attr-defined
    import tuner.solver  # refused: import-not-found

    print(tuner.Problm)  # refused: attr-defined
    print(tuner.Problem, tuner.grid)


def arguments(problem: Problem) -> None:
    Positive(int=1.0, low=0.1, high=10.0)  # refused: call-arg
    Positive(init="1.0", low=0.1, high=10.0)  # refused: arg-type
    Positive(init=1.0, low=0.1, high=10.0, unit=1.0)  # refused: arg-type
    Space.of(R=1.0)  # refused: arg-type
    GyroscopeFilter(0.01, shpe=(2,))  # refused: call-arg
    StepResponse(0.01)  # refused: call-arg
    NelderMead(seed=0, start=3)  # refused: call-arg
    Gradient("l-bfgs", seed=0)  # refused: arg-type
    ChannelRmse("z", "nummer")  # refused: arg-type
    Param("s", "time constant")  # refused: call-arg
    Channel("m", "height", axis=("x",))  # refused: call-arg
    read_record("rest.csv", mapping=[])  # refused: call-arg
    Data(1.0)  # refused: call-arg
    Problem("p", Space.of(), filter=None, bild=abs)  # refused: call-arg
    NelderMead(seed=0)(problem.space)  # refused: arg-type
    StepResponse(0.01, Welch.matlab(2001))


def attributes(solution: Solution) -> None:
    print(solution.parametrs)  # refused: attr-defined
    print(solution.parameters["Q"].vaule)  # refused: attr-defined
    print(solution.certificate.flat_direction)  # refused: attr-defined
    print(Welch.matlb(2001))  # refused: attr-defined
    print(solution.parameters[0])  # refused: index
    print(solution.status.value, solution.parameters["Q"].value)


def untyped(solution):
    print(Positive(init=1.0, low=0.1, hihg=10.0))  # refused: call-arg
    return solution.anything
