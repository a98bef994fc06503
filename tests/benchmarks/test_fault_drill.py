"""The drill counts what is in the database."""

from benchmarks.fault_drill import Drill, judged


def test_a_drill_that_is_not_disturbed(tmp_path, capsys):
    drill = Drill(f"sqlite:///{tmp_path / 'd.db'}", 5, 1, 0.0, 0.0)
    drill.work()
    assert judged(drill, 0, 1.0)
    assert "5 complete (0 made again), 0 lost, 0 counted twice, 0 left" in capsys.readouterr().out


def test_a_drill_tells_what_is_missing(tmp_path, capsys):
    drill = Drill(f"sqlite:///{tmp_path / 'd.db'}", 5, 1, 0.0, 0.0)
    with drill.search() as trials:
        trials.make_one(drill.evaluate)
        trials.study.ask()
    assert not judged(drill, 1, 1.0)
    assert "1 complete (0 made again), 4 lost, 0 counted twice, 1 left" in capsys.readouterr().out
