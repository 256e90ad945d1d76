"""Every diagnostic has a German text that says the same with the same values."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import pytest

from cnc_front._native import gcode, motion_kernel
from cnc_front.diagnostics import Diagnostic
from cnc_front.errors import UsageError
from cnc_front.german import PLACEHOLDER, TABLE, german, one_line, refusal
from cnc_front.messages import text
from tests.app.conftest import ROOT, Cli

with TABLE.open(encoding="utf-8", newline="") as file:
    ROWS = list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))


def filled(template: str) -> str:
    """The template with a different value for each placeholder."""
    values = iter(range(11, 99))
    return PLACEHOLDER.sub(lambda _: f"q{next(values)}", template)


def test_every_id_of_the_catalogue_is_translated() -> None:
    known = {row["id"] for row in ROWS}
    catalogue = gcode.catalogue()
    assert [id for id, _, _ in catalogue if id not in known] == []
    for id, message, hint in catalogue:
        found = german(Diagnostic("a.nc", 1, 1, 1, id, filled(message), hint))
        assert found.message != filled(message), id
        assert re.findall(r"q\d\d", found.message) == re.findall(r"q\d\d", filled(message)), id
        assert bool(found.hint) == bool(hint) and (found.hint != hint or not hint), id


def test_ids_of_the_machine_file_are_translated() -> None:
    source = "".join(p.read_text("utf-8") for p in (ROOT / "motion_kernel" / "src" / "machine").glob("*.rs"))
    ids = set(re.findall(r'"(MC1\d\d)"', source))
    assert ids and ids <= {row["id"] for row in ROWS}
    bad = b'name = 5\nfoo = 1\n[[axis]]\nname = "X"\nrapid = "x"\nmaxvel = -1\nkind = "round"\n[[axis]]\nname = "X"\n'
    with pytest.raises(motion_kernel.MachineError) as caught:
        motion_kernel.Machine.parse(bad, "m.toml")
    found = [Diagnostic(*row) for row in caught.value.args[0]]
    assert len({d.id for d in found}) >= 4
    for d in found:
        assert german(d).message != d.message, d
        assert german(d).hint != d.hint, d


#: What is German elsewhere: the catalogue of rw_SymPas, and what stands in cnc_front.messages.
ELSEWHERE = re.compile(r"S[PW]\d+|CF30[1-4]|CF50[1-3]")


def test_every_id_that_the_sources_name_and_every_remedy_is_translated() -> None:
    folders = ("cnc_front", "tui", "motion_kernel", "toolpaths", "gcode")
    found = (p for folder in folders for end in ("py", "rs") for p in (ROOT / folder).rglob(f"*.{end}"))
    files = [p for p in found if "tests" not in p.parts]
    text = "".join(p.read_text("utf-8") for p in files)
    ids = set(re.findall(r'"((?:CF|SU|RF|MC|ST|SP|SW|GC|GW)\d{3})"', text))
    known = {row["id"] for row in ROWS}
    assert len(ids) > 50 and {id for id in ids - known if not ELSEWHERE.fullmatch(id)} == set()
    remedies = re.findall(r'^ +\(?"((?:MC|ST|SU)\d{3})"[,:] "([^"]+)"', text, re.M)
    assert len(remedies) > 25
    for id, hint in remedies:
        row = next(row for row in ROWS if row["id"] == id)
        found = german(Diagnostic("a", 1, 1, 1, id, row["english"], hint))
        assert found.hint not in ("", hint), (id, hint)


def test_findings_of_other_files_are_german_too(cli: Cli, tmp_path: Path) -> None:
    job = tmp_path / "a.nc"
    job.write_text("G90 G21 F500\nG1 X5\nM30\n")
    job.with_suffix(".stim").write_text("when Q > 5 mm: X blocked\nat 1 s: input 99 on\ndance\n")
    said = cli("run", "--lang", "de", job).err
    assert "es gibt keine Achse Q" in said and "99 liegt außerhalb" in said and "'dance', erwartet wird" in said
    assert "expected" not in said and "hint" not in said and said.count("Hinweis: ") == 3
    job.with_suffix(".mcap").write_text("no recording")
    said = cli("report", "--lang", "de", job.with_suffix(".mcap"), tmp_path / "out").err
    assert "als Aufzeichnung nicht lesbar" in said and "Hinweis: eine Datei angeben, die run --record" in said
    said = cli("check", "--lang", "de", tmp_path / "none.nc").err
    assert "Datei ist nicht lesbar: Datei oder Verzeichnis nicht gefunden" in said


def test_refusals_that_operators_meet_are_german(cli: Cli, tmp_path: Path) -> None:
    source = "".join((ROOT / file).read_text("utf-8") for file in ("cnc_front/outputs.py", "cnc_front/sim_load.py"))
    said = re.findall(r'UsageError\(f"([^"]+)"\)', source)
    assert len(said) > 8
    for template in said:
        message = filled(template)
        found = refusal(UsageError(message), "de")
        assert found != message and re.findall(r"q\d\d", found) == re.findall(r"q\d\d", message), template
        assert refusal(UsageError(message), "en") == message
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "a.nc").write_text("G90 G21 F500\nG1 X5\nM30\n")
    ran = cli("run", "--lang", "de", tmp_path / "a.nc", "--report", tmp_path)
    assert ran.code == 2 and "liegen Dateien, die kein Bericht von uns sind" in ran.err


def test_there_is_no_line_0() -> None:
    values = {"name": "mpe", "axis": "X", "t_s": 1.0}
    assert text("alarm", "en", line=0, **values) == "alarm mpe X at 1.000 s"
    assert text("alarm", "de", line=7, **values) == "Störung mpe X bei 1.000 s, Zeile 7"


def test_no_row_is_for_nothing() -> None:
    ids = {id for id, _, _ in gcode.catalogue()}
    assert all(row["english"] or row["id"] in ids for row in ROWS)
    for row in ROWS:
        english = row["english"]
        if english:
            assert sorted(PLACEHOLDER.findall(english)) == sorted(PLACEHOLDER.findall(row["german"])), row


def test_values_with_remarks_and_unknown_messages() -> None:
    far = "axis X: machine position 700 outside -600..600 (arc extreme)"
    assert german(Diagnostic("a", 1, 1, 1, "GC413", far)).message.endswith("-600..600 (äußerster Punkt des Bogens)")
    assert german(Diagnostic("a", 1, 1, 1, "XX1", "what is this", "a hint")).message == "what is this"
    assert one_line("12:3: GW908: duplicate N10", "de") == "12:3: GW908: N10 doppelt"
    assert one_line("12:3: GW908: duplicate N10", "en") == "12:3: GW908: duplicate N10"
    assert one_line("no finding", "de") == "no finding"


def test_the_command_line_speaks_german(cli: Cli, tmp_path: Path) -> None:
    path = tmp_path / "bad.nc"
    path.write_text("G1 X700\nM30\n", encoding="utf-8")
    ran = cli("check", "--lang", "de", path)
    assert "GC501: kein Vorschub programmiert" in ran.err and "Hinweis: F ergänzen" in ran.err
    english = cli("check", path).err
    assert "GC501: no feed programmed" in english
    assert re.findall(r":\d+:\d+: G\w\d+", ran.err) == re.findall(r":\d+:\d+: G\w\d+", english)
