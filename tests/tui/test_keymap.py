"""The keymap file: other keys, errors with file and line, and that hold cannot be unbound."""

from __future__ import annotations

from pathlib import Path

import pytest

from cnc_front.cli import run_command_line
from cnc_front.errors import UsageError
from tests.tui.stage import Stage, play
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

    play(script, keys=keys)


def test_hold_cannot_be_unbound() -> None:
    keys = changed(KEYS, ["hold = f12", "escape = f11"], "k")
    table = {key.action: key.keys for key in keys}
    assert table["hold"] == "space,f12" and table["escape"] == "escape,f11"

    async def script(stage: Stage) -> None:
        for key in ("space", "f12", "escape", "f11"):
            stage.engine.calls.clear()
            await stage.press(key)
            assert stage.engine.calls == ["hold"], key

    play(script, keys=keys)


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
    text = table_text(KEYS, Words(language))
    assert [key.keys for key in changed(KEYS, text.splitlines(), "k")] == [key.keys for key in KEYS]


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
