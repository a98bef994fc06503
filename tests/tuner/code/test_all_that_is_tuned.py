"""Filters of the catalogue, models from text files and users' own classes: all come out as C."""

import tomllib

import numpy as np
import pytest

from filters.declared import assembled, parameter_facts
from tests.tuner.code.compiled import compile_in, needed, ran
from tests.tuner.export_cases import tuned
from tuner.catalogue import find, names
from tuner.code.document import files
from tuner.code.form import form
from tuner.model import model_filter, template
from tuner.model.template import KINDS
from tuner.problem.random_inputs import random_inputs
from tuner.problem.steady_form import steady_form_of

CLASSES = {name: lambda name=name: find("tuner.filters", name) for name in names("tuner.filters")}
CLASSES |= {kind: lambda kind=kind: model_filter(tomllib.loads(template(kind))) for kind in KINDS}


@pytest.mark.parametrize("name", CLASSES)
def test_it_does_what_it_should(tmp_path, name, request):
    """Of filters in the battery, whose steps test_battery_in_c.py searches, the first steps."""
    needed("gcc")
    if name not in KINDS:
        request.getfixturevalue("first_steps")
    cls = CLASSES[name]()
    filter = cls(dt=0.02)
    typical = {key: np.asarray(fact.typical, float) for key, fact in parameter_facts(cls).items()}
    params = assembled(cls, typical)
    stem = name.replace("-", "_")
    forms = [form(stem, filter, params, random_inputs(filter))]
    for trial in steady_form_of(filter, params).values():
        forms.append(form(f"{stem}_steady", *trial))
    text = files(tuned(name=stem), f"{stem}.h", forms)
    for end, part in ((".h", text.header), (".c", text.source), ("_selftest.c", text.selftest)):
        (tmp_path / f"{stem}{end}").write_text(part)
    compile_in(
        tmp_path, "gcc", "-DSELFTEST_MAIN", f"{stem}.c", f"{stem}_selftest.c", "-o", "a", "-lm"
    )
    assert ran(tmp_path, "./a").returncode == 0
