"""The page: nothing leaves it, nothing gets into it, and the answer comes first."""

import base64
import hashlib
import re
from html.parser import HTMLParser

import pytest

from tests.tuner.report import made
from tuner.report.document import report_of
from tuner.report.markdown import markdown
from tuner.report.page import page
from tuner.report.write import KEPT, PAGE, page_again, read_kept
from tuner.run.result import SingleRecord

VOID = {"meta", "wbr", "link", "img", "br", "path", "rect", "hr", "input"}


class Seen(HTMLParser):
    """Tags, attributes, headings and texts of a page; whether its tags close."""

    def __init__(self):
        super().__init__()
        self.tags, self.attributes, self.texts, self.open = [], [], [], []

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += [(tag, name, value) for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.texts.append(data)


def seen(data):
    parser = Seen()
    parser.feed(data.decode())
    parser.close()
    assert not parser.open
    return parser


def page_of(result, kept, folder):
    return page(report_of(result, kept, folder))


@pytest.fixture
def data(tmp_path):
    return page_of(made.result(), made.kept(), tmp_path)


def test_nothing_is_fetched(data):
    found = seen(data)
    assert not {"link", "img", "iframe", "object", "base", "form"} & set(found.tags)
    assert {v[0] for _, name, v in found.attributes if name == "href"} == {"#"}
    assert not [name for _, name, _ in found.attributes if name in ("src", "srcset", "action")]
    assert b"http" not in data.replace(b"http-equiv", b"")
    assert b"url(" not in data
    assert b"@import" not in data


def test_no_other_script_runs(data):
    (policy,) = [v for t, n, v in seen(data).attributes if t == "meta" and n == "content"][:1]
    (script,) = re.findall(r"<script>(.*?)</script>", data.decode(), re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert policy.startswith("default-src 'none'; ")
    assert f"script-src 'sha256-{digest}'" in policy


def test_hostile_names_are_text(tmp_path):
    bad = made.HOSTILE
    result = made.result(
        fit=made.fit(unit=bad, filter=bad, in_doubt=[bad]),
        solutions=[made.solution(flat=[bad])],
        single_precision=[
            SingleRecord(
                problem=bad,
                form=bad,
                output=bad,
                largest=1.0,
                share=2.0,
                sample=3,
                rms=4.0,
                warning=bad,
            )
        ],
    )
    found = seen(page_of(result, made.kept(bad, notes=[bad], title=bad), tmp_path / "a b"))
    clean = seen(page_of(made.result(), made.kept(), tmp_path))
    assert found.tags.count("script") == clean.tags.count("script") == 1
    assert "img" not in found.tags
    assert not [name for _, name, _ in found.attributes if name.startswith("on")]
    assert any("{{7*7}}" in text for text in found.texts)
    assert {name for _, name, _ in found.attributes} == {n for _, n, _ in clean.attributes}


def test_the_answer_comes_first(data):
    text = data.decode()
    places = [text.index(f'<section id="{key}"') for key in ("answer", "signal", "data", "again")]
    assert places == sorted(places)
    first = text[places[0] : places[1]]
    for words in ("Use it", "0.146", "Pa²/s", "0.0700 to 0.300", "below 7", "tuned on the rest"):
        assert words in first, words
    assert "m²" in first  # of a meaning


def test_headings_tables_and_pictures_are_told(data):
    found = seen(data)
    assert found.tags.count("h1") == 1
    labels = [v for _, name, v in found.attributes if name == "aria-label"]
    assert any(
        words.startswith("Chart of level, Pa² over time, s from 0 to 2999.") for words in labels
    )
    assert any(words.startswith("Map of nats over q and R.") for words in labels)
    assert [v for t, name, v in found.attributes if (t, name) == ("html", "lang")] == ["en"]
    ids = [v for _, name, v in found.attributes if name == "id"]
    assert len(ids) == len(set(ids))
    named = {v[1:] for _, name, v in found.attributes if name == "href"}
    assert named <= set(ids)


def test_small_and_without_a_place_on_this_machine(data, tmp_path):
    assert len(data) < 400_000
    assert str(tmp_path).encode() not in data


def test_a_study_is_held_against_its_paper(tmp_path):
    text = page_of(made.study(), made.kept(), tmp_path).decode()
    assert "Reproduced in part" in text
    assert "2 of 4 numbers and claims are met; 1 differs and 1 cannot be identified." in text
    assert "A. Author, 2004" in text
    assert "S 30.3 deg²" in text
    for cell in ("claim holds", "differs", "not identifiable", "2.01°"):
        assert f">{cell}<" in text


def test_again_from_its_folder(tmp_path, data):
    (tmp_path / "result.json").write_text(made.result().to_json())
    (tmp_path / KEPT).write_bytes(made.kept().to_json())
    for path in (tmp_path, tmp_path / "result.json"):
        assert page_again(path) == data


def test_of_a_run_that_kept_nothing(tmp_path):
    (tmp_path / "result.json").write_text(made.result().to_json())
    assert b"Use it" in page_again(tmp_path)


def test_what_is_not_kept_by_a_run_is_refused(tmp_path):
    (tmp_path / KEPT).write_text('{"schema": "tuner.report/1", "titel": "x"}')
    with pytest.raises(ValueError, match=r"^report.json is not what a run writes: titel: "):
        read_kept(tmp_path)


def test_markdown_holds_the_same_words(tmp_path):
    bad = made.HOSTILE
    text = markdown(report_of(made.result(), made.kept(bad), tmp_path)).decode()
    assert text.startswith("# Level on log.csv\n")
    assert "| q | **0.146 Pa²/s** | 0.0700 to 0.300 (95 %) |  |" in text
    assert f"(picture in {PAGE})" in text
    drawn = markdown(report_of(made.result(), made.kept(), tmp_path), {"runs"}).decode()
    assert "](figures/runs.png)\n" in drawn
    assert not re.search(r"(?<!\\)<", text)
    heads = [line for line in text.splitlines() if line.startswith("|---")]
    assert len(heads) > 4
