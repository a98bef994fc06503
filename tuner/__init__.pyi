"""The public names of tuner: this is their one list, read by type checkers and by the loader.

Filters are imported from `filters`, objectives from `objectives`, and what writes a study, an
export or an observer from the modules of tuner that hold it.
"""

from objectives import Data as Data
from objectives import LinearSystem as LinearSystem
from tuner.certificate.solution import Certificate as Certificate
from tuner.certificate.solution import Solution as Solution
from tuner.certificate.solution import Status as Status
from tuner.convex import ConvexProgram as ConvexProgram
from tuner.convex import linear_program as linear_program
from tuner.data.reading import read_record as read_record
from tuner.data.reading import read_records as read_records
from tuner.data.record import Record as Record
from tuner.export import Tuned as Tuned
from tuner.identifiability.determined import Determined as Determined
from tuner.identifiability.determined import determined as determined
from tuner.identifiability.determined import with_known_start as with_known_start
from tuner.observers import fastest_decay as fastest_decay
from tuner.observers import minimum_variance as minimum_variance
from tuner.problem.constraint import Constraint as Constraint
from tuner.problem.parameters import Bounded as Bounded
from tuner.problem.parameters import Covariance as Covariance
from tuner.problem.parameters import Fixed as Fixed
from tuner.problem.parameters import Limited as Limited
from tuner.problem.parameters import Positive as Positive
from tuner.problem.problem import Problem as Problem
from tuner.problem.space import Space as Space
from tuner.problem.surface import grid as grid
from tuner.problem.surface import values as values
from tuner.problem.surface import values_and_gradients as values_and_gradients
from tuner.run.check import Check as Check
from tuner.run.check import check as check
from tuner.run.comparison import Comparison as Comparison
from tuner.run.comparison import Verdict as Verdict
from tuner.run.fitted import Fit as Fit
from tuner.run.fitted import fit as fit
from tuner.run.study import Study as Study
from tuner.run.study import find_study as find_study
from tuner.solvers import Alternating as Alternating
from tuner.solvers import Convex as Convex
from tuner.solvers import Gradient as Gradient
from tuner.solvers import Ipopt as Ipopt
from tuner.solvers import Known as Known
from tuner.solvers import NelderMead as NelderMead
from tuner.solvers import Sampler as Sampler
from tuner.solvers.pareto import Front as Front
from tuner.solvers.pareto import pareto as pareto
