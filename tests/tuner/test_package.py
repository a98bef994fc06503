"""The package: light imports, its public names, its siblings."""

import ast
import subprocess
import sys
import zipfile
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import filters
import objectives
import studies
import tuner

HEAVY = {"jax", "jaxlib", "scipy", "cvxpy", "casadi", "matplotlib", "pydantic", "optuna", "numpy"}
ROOT = Path(tuner.__file__).parents[1]
STUB = Path(tuner.__file__).with_suffix(".pyi")
LOADED = "import sys; print(' '.join(sorted(set(sys.modules))))"


def python(*arguments, cwd=None):
    return subprocess.run(
        [sys.executable, *arguments], capture_output=True, text=True, check=False, cwd=cwd
    )


def loaded(code):
    ran = python("-c", f"{code}\n{LOADED}")
    assert ran.returncode == 0, ran.stderr
    return set(ran.stdout.splitlines()[-1].split())


def test_import_is_light():
    assert not loaded("import tuner") & HEAVY


def test_names_are_loaded_when_they_are_used():
    modules = loaded("import tuner; tuner.read_record; tuner.Verdict")
    assert "tuner.data.reading" in modules
    assert not modules & (HEAVY - {"numpy"})


# Typer itself checks a command's options by pydantic.
@pytest.mark.parametrize("arguments", [["--help"], [], ["run", "--help"], ["export", "--help"]])
def test_help_is_light(arguments):
    code = f"from tuner.cli import invoke\nassert invoke({arguments!r}) == 0"
    assert not loaded(code) & (HEAVY - {"pydantic"} if len(arguments) > 1 else HEAVY)


def test_the_stub_holds_nothing_but_names():
    about, *imports = ast.parse(STUB.read_text(encoding="utf-8")).body
    assert isinstance(about, ast.Expr)
    assert all(isinstance(statement, ast.ImportFrom) for statement in imports)
    # `from module import name as name` alone hands a name on, for a type checker
    given = [alias for statement in imports for alias in statement.names]
    assert all(alias.name == alias.asname for alias in given)
    assert tuner.__all__ == sorted(alias.name for alias in given)
    assert len(given) == len(set(tuner.__all__))
    assert 25 < len(given) < 45  # what a person can look through


def test_the_loader_takes_what_a_stub_may_say(tmp_path):
    stub = tmp_path / "stub.pyi"
    stub.write_text('"""Words."""\nfrom a.b import C, D as E\nfrom a import f as f\n')
    assert tuner._listed(stub) == {"C": ("a.b", "C"), "E": ("a.b", "D"), "f": ("a", "f")}
    with pytest.raises(ImportError, match=r"none\.pyi is missing, .*; install filter-tuner again$"):
        tuner._listed(tmp_path / "none.pyi")


def test_every_public_name_is_there():
    for name in tuner.__all__:
        thing = getattr(tuner, name)
        assert thing.__name__ == name
        assert name in dir(tuner)


def test_public_names_can_be_imported():
    from tuner import Bounded, Data, NelderMead, Problem, Space, find_study, read_record

    assert Data is objectives.Data
    assert Problem is tuner.problem.problem.Problem
    assert Space is tuner.problem.space.Space
    assert NelderMead is tuner.solvers.NelderMead
    assert Bounded.__module__ == "tuner.problem.parameters"
    assert find_study("kownacki2010").name == "kownacki2010"
    assert read_record.__module__ == "tuner.data.reading"


def test_unknown_names_are_attribute_errors():
    with pytest.raises(AttributeError, match="^module 'tuner' has no attribute 'Nonsense'$"):
        _ = tuner.Nonsense
    with pytest.raises(ImportError, match="cannot import name 'Nonsense'"):
        from tuner import Nonsense  # noqa: F401
    assert not hasattr(tuner, "__path_to_nowhere__")


def test_filters_and_objectives_are_in_packages_of_their_own():
    foreign = set(filters.__all__) | set(objectives.__all__) - {"Data", "LinearSystem"}
    assert not foreign & set(tuner.__all__)
    with pytest.raises(ImportError, match="cannot import name 'GyroscopeFilter'"):
        from tuner import GyroscopeFilter  # noqa: F401


def test_siblings_are_the_ones_that_were_installed():
    for package in (filters, objectives, studies):
        assert Path(package.__file__).parent == ROOT / package.__name__


@pytest.mark.parametrize("name", ["filters", "objectives", "studies"])
@pytest.mark.parametrize("package", [False, True], ids=["module", "package"])
def test_a_foreign_sibling_is_refused_with_both_paths(tmp_path, name, package):
    foreign = tmp_path / name / "__init__.py" if package else tmp_path / f"{name}.py"
    foreign.parent.mkdir(exist_ok=True)
    foreign.write_text("raise SystemExit('the foreign module was run')\n")
    # Where another process finds the package: not in this folder where it was installed as a wheel.
    own = python("-P", "-c", "import tuner; print(tuner.__file__)", cwd=tmp_path).stdout.strip()
    ran = python("-c", "import tuner", cwd=tmp_path)
    assert ran.returncode == 1
    (last,) = ran.stderr.splitlines()[-1:]
    assert last == (
        f"ImportError: tuner needs its package {name!r} in {Path(own).parents[1] / name}, "
        f"but Python finds {foreign}; rename that one, or start Python with -P"
    )


def test_the_way_out_works(tmp_path):
    (tmp_path / "filters.py").write_text("")
    assert python("-P", "-c", "import tuner", cwd=tmp_path).returncode == 0


def test_a_folder_of_that_name_without_code_does_no_harm(tmp_path):
    (tmp_path / "filters").mkdir()
    (tmp_path / "studies").mkdir()
    assert python("-c", "import tuner", cwd=tmp_path).returncode == 0


def test_the_command_line_refuses_a_foreign_sibling_as_well(tmp_path):
    (tmp_path / "filters.py").write_text("")
    ran = python("-m", "tuner.cli", "--help", cwd=tmp_path)
    assert ran.returncode == 1
    assert "tuner needs its package 'filters'" in ran.stderr


def test_all_packages_are_typed():
    for package in (filters, objectives, studies, tuner):
        assert (Path(package.__file__).parent / "py.typed").is_file()


def test_a_wheel_holds_types_and_names(tmp_path):
    pytest.importorskip("hatchling")
    source = Path(__file__).resolve().parents[2]
    build = ("-m", "hatchling", "build", "-t", "wheel", "-d", str(tmp_path))
    assert python(*build, cwd=source).returncode == 0
    (wheel,) = tmp_path.glob("*.whl")
    with zipfile.ZipFile(wheel) as packed:
        packed.extractall(tmp_path / "site")
    held = {path.relative_to(tmp_path / "site").as_posix() for path in tmp_path.rglob("site/*/*")}
    packages = ("filters", "objectives", "studies", "tuner")
    assert {*(f"{name}/py.typed" for name in packages), "tuner/__init__.pyi"} <= held
    parts = {file.name for file in (tmp_path / "site/tuner/report").iterdir()}
    assert {"page.html.jinja", "page.css", "page.js"} <= parts
    assert (tmp_path / "site/tuner/data/logs/plain.c").is_file()
    code = (
        "import sys; sys.path.insert(0, 'site'); import tuner; print(tuner.__file__, tuner.Record)"
    )
    ran = python("-P", "-c", code, cwd=tmp_path)
    assert ran.stdout.split()[0].endswith("site/tuner/__init__.py"), ran.stderr
    assert "tuner.data.record.Record" in ran.stdout


def test_imports_go_one_way():
    use = "import tuner; tuner.Problem, tuner.Sampler, tuner.grid"
    ran = python("-c", f"import objectives\n{LOADED}\n{use}\n{LOADED}")
    lower, upper = (set(line.split()) for line in ran.stdout.splitlines())
    assert "filters" in lower
    assert not lower & {"tuner", "studies"}
    assert "tuner.problem.surface" in upper
    assert "studies" not in upper


def needs(file, modules):
    """The modules of tuner that a file imports anywhere, for type checkers alone included."""
    for statement in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(statement, ast.ImportFrom) and statement.module:
            for alias in statement.names:
                within = f"{statement.module}.{alias.name}"
                yield within if within in modules else statement.module


def test_no_imports_go_in_a_circle():
    root = Path(tuner.__file__).parent
    modules = {
        ".".join(("tuner", *file.relative_to(root).with_suffix("").parts)).removesuffix(
            ".__init__"
        ): file
        for file in root.rglob("*.py")
    }
    graph = {name: {*needs(file, modules)} & {*modules} for name, file in modules.items()}
    assert "tuner.convex.reading" in graph["tuner.convex.program"]
    circle = None
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        circle = " <- ".join(error.args[1])
    assert circle is None
