"""All studies in their short form, and the files that they leave."""

from __future__ import annotations

import csv
from html.parser import HTMLParser
from pathlib import Path
import re

from blob_tracker.__main__ import main
from blob_tracker.studies.registry import STUDIES
import pytest
from support.quick_study import folder, measured, quick_findings


class _Page(HTMLParser):
    """Gather what the page refers to, and whether its elements are closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.sources: list[str] = []
        self.anchors: list[str] = []
        self.places: list[str] = []

    def handle_starttag(self, tag: str, attributes: list[tuple[str, str | None]]) -> None:
        """Note an element."""
        values = dict(attributes)
        if tag not in ('img', 'meta'):
            self.open.append(tag)
        self.sources += [values['src'] or ''] if 'src' in values else []
        self.anchors += [values['href'] or ''] if 'href' in values else []
        self.places += [values['id'] or ''] if 'id' in values else []

    def handle_endtag(self, tag: str) -> None:
        """Close an element."""
        assert self.open.pop() == tag


@pytest.mark.parametrize('name', STUDIES)
def test_quick_run(name: str) -> None:
    """Every study runs, and has tables and figures."""
    findings = quick_findings(STUDIES[name])
    assert findings.figures
    for table in findings.tables:
        assert table.rows and {len(row) for row in table.rows} == {len(table.columns)}


def test_all_quick(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The command ends well; the tables are CSV, its page is whole and needs no other file."""
    for study in STUDIES.values():
        measured(study, *study.cases(True))
    (tmp_path / 'kept').symlink_to(folder())
    assert main(['study', 'all', '--quick', '--jobs', '1', '--out', str(tmp_path)]) == 0
    assert 'failed' not in capsys.readouterr().out
    page = _Page()
    page.feed((tmp_path / 'report_quick.html').read_text(encoding='utf-8'))
    assert page.open == []
    assert page.places == list(STUDIES)
    assert page.anchors == [f'#{name}' for name in STUDIES]
    assert page.sources and all(each.startswith('data:image/png;base64,') for each in page.sources)
    for name in STUDIES:
        tables = list((tmp_path / name).glob('*.csv'))
        assert tables and list((tmp_path / name).glob('*.png')), name
        for path in tables:
            rows = list(csv.reader(path.open(encoding='utf-8')))
            assert len(rows) > 1 and {len(row) for row in rows} == {len(rows[0])}, path
    summary = (tmp_path / 'summary_quick.md').read_text(encoding='utf-8')
    assert all(study.source in summary for study in STUDIES.values())


def test_the_page_has_a_line_for_each() -> None:
    """In the table that says what of the thesis is reproduced, how closely and by what."""
    page = (Path(__file__).parents[2] / 'docs' / 'thesis.md').read_text(encoding='utf-8')
    for study in STUDIES.values():
        line = rf'^\| {re.escape(study.source)} \| .+ \| `{study.name}` \|$'
        assert re.search(line, page, re.MULTILINE), study.name


def test_names_are_checked(capsys: pytest.CaptureFixture[str]) -> None:
    """A wrong name is wrong use, and near ones are named."""
    assert main(['study', 'table_3_33']) == 2
    assert 'did you mean table_3_3' in capsys.readouterr().err
    assert main(['study', 'ALL']) == 2
    assert 'did you mean all' in capsys.readouterr().err


def test_the_list(capsys: pytest.CaptureFixture[str]) -> None:
    """Without a name: all there are."""
    assert main(['study']) == 0
    text = capsys.readouterr().out
    assert all(name in text for name in STUDIES)


def test_a_folder_that_cannot_be(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A file where the folder should be: wrong use, with the name."""
    (tmp_path / 'file').touch()
    assert main(['study', 'table_2_1', '--out', str(tmp_path / 'file')]) == 2
    assert f'--out {tmp_path / "file"}' in capsys.readouterr().err
