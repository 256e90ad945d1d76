"""The keymap file: other keys, errors with file and line, and that hold cannot be unbound."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from textual.pilot import Pilot

from cnc_front.cli import run_command_line
from cnc_front.errors import UsageError
from tests.tui.stage import Stage, play
from tests.tui.test_debugger import marked, played, shown
from tui.debug_keys import ALL_KEYS, main_keys
from tui.debugger import Debugger
from tui.keymap import changed, place, read_keymap, table_text
from tui.keys import KEYS
from tui.words import Words


def test_other_keys_count_in_bindings_help_and_key_line(tmp_path: Path) -> None:
    file = tmp_path / "keymap"
    file.write_text("# mine\n\nstart = f9, k   # not r\nrun:current = l\nstep = ctrl+k\n")
    keys = read_keymap(str(file))

    async def script(stage: Stage) -> None:
        await stage.load()
        await stage.press("r")
        assert "start" not in stage.engine.calls
        assert " f9 k Start " in (await stage.frame()).splitlines()[-1]
        await stage.press("k")
        assert stage.engine.calls[-1] == "start"
        await stage.press("space", "ctrl+k", "down", "l")
        assert stage.engine.calls[-2:] == ["hold", "step"] and stage.app.program.chosen == 0
        await stage.press("1")
        assert "f9 k          cycle start" in await stage.frame()

    play(script, keys=main_keys(keys))


def test_hold_cannot_be_unbound() -> None:
    keys = changed(KEYS, ["hold = f12", "escape = f11"], "k")
    table = {key.action: key.keys for key in keys}
    assert table["hold"] == "space,f12" and table["escape"] == "escape,f11"

    async def script(stage: Stage) -> None:
        for key in ("space", "f12", "escape", "f11"):
            stage.engine.calls.clear()
            await stage.press(key)
            assert stage.engine.calls == ["hold"], key

    play(script, keys=main_keys(keys))


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("start", "'start' is not ACTION = KEY, KEY"),
        ("launch = x", "unknown action 'launch'"),
        ("start = ", "no key"),
        ("start = hyper+x", "'hyper+x' is no key"),
        ("start = returnn", "'returnn' is no key"),
        ("start = space", "space belongs to hold already"),
        ("start = escape", "escape belongs to escape already"),
        ("start = t", "t belongs to step already"),
        ("run:view = r", "r belongs to start already"),
        ("start = r\nstart = k", "start stands in line 2 already"),
    ],
)
def test_errors_name_file_and_line(line: str, says: str) -> None:
    with pytest.raises(UsageError) as error:
        changed(KEYS, ["# comment", *line.split("\n")], "my.keys")
    assert str(error.value).startswith(f"my.keys:{2 + line.count(chr(10))}: ") and says in str(error.value)


def test_one_key_may_mean_something_else_on_another_page() -> None:
    keys = changed(KEYS, ["run:view = e"], "k")
    assert next(key.keys for key in keys if key.action == "view") == "e"


@pytest.mark.parametrize("language", ["en", "de"])
def test_the_printed_table_changes_nothing(language: str) -> None:
    text = table_text(ALL_KEYS, Words(language))
    assert [key.keys for key in changed(ALL_KEYS, text.splitlines(), "k")] == [key.keys for key in ALL_KEYS]


def test_where_it_is_looked_for(tmp_path: Path) -> None:
    assert place("a", {"CNC_FRONT_KEYMAP": "b"}) == "a" and place(None, {"CNC_FRONT_KEYMAP": "b"}) == "b"
    assert place(None, {"XDG_CONFIG_HOME": str(tmp_path)}) is None
    (tmp_path / "cnc-front").mkdir()
    (tmp_path / "cnc-front" / "keymap").write_text("")
    assert place(None, {"XDG_CONFIG_HOME": str(tmp_path)}) == str(tmp_path / "cnc-front" / "keymap")


def test_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["tui", "--keys", "--keymap", str(tmp_path / "k")]
    (tmp_path / "k").write_text("start = k\n")
    assert run_command_line(arguments) == 0 and "start                    = k" in capsys.readouterr().out
    (tmp_path / "k").write_text("\n\nhold=x\n")
    assert run_command_line(arguments) == 2 and f"{tmp_path / 'k'}:3: " in capsys.readouterr().err
    (tmp_path / "k").unlink()
    assert run_command_line(arguments) == 2


def test_the_screen_of_sympas_jobs_has_the_keys_of_the_file(tmp_path: Path) -> None:
    lines = [
        "start = f9",
        "step = k",
        "hold = f12",
        "ask_quit = ctrl+k",
        "debug:step('over') = O, f4",
        "debug:current = t",
    ]

    async def play(pilot: Pilot[None], app: Debugger) -> None:
        assert " f9 Go on  k Step  O over " in shown(app, "keys")
        await pilot.press("t", "r", "T")
        assert app.session.run.machine_time_s == 0.0 and not app.session.works, "their keys of before do nothing"
        await pilot.press("k", "k")
        assert "mean := Half(sum);" in marked(app)[0]
        await pilot.press("O")
        assert "writeln" in marked(app)[0]
        for key in ("space", "f12", "escape"):
            await pilot.press("f9", key)
            assert app.session.held and "f9 goes on" in shown(app, "keys"), key
        await pilot.press("f1")
        text = shown(app, "source")
        assert " O f4        step over routines" in text and " space f12   hold" in text and "^K" in text
        await pilot.press("ctrl+q")
        assert app.is_running
        await pilot.press("ctrl+k")
        assert not app.is_running

    played(tmp_path, play, keys=changed(ALL_KEYS, lines, "k"))


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("debug:view = space", "space belongs to hold already"),
        ("debug:assign = escape", "escape belongs to escape already"),
        ("start = T", "T belongs to debug:step('over') already"),
        ("debug:assign = b", "b belongs to debug:toggle_break already"),
    ],
)
def test_keys_of_sympas_jobs_do_not_clash(line: str, says: str) -> None:
    with pytest.raises(UsageError, match=re.escape(says)):
        changed(ALL_KEYS, [line], "k")
    changed(ALL_KEYS, ["debug:assign = o"], "k")  # optional stop is no key of that screen
