"""Who may import whom (design section 2), in both languages, and what the fast entries must not load."""

from __future__ import annotations

import ast
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
MAY_IMPORT = {
    "motion_kernel": set(),
    "gcode": {"motion_kernel"},
    "sympas": {"motion_kernel"},
    "toolpaths": set(),
    "cnc_front": {"toolpaths", "gcode", "sympas", "motion_kernel"},
    "tui": {"cnc_front"},
}
# the compiled module belongs to no room: each face may import its own part of it
OWN_NATIVE = {room: f"cnc_front._native.{room}" for room in MAY_IMPORT}
MAY_DEPEND = {
    "motion_kernel": set(),
    "gcode": {"motion_kernel"},
    "sympas": {"motion_kernel"},
    "toolpaths": set(),
    "cnc_front/recording": set(),
    "cnc_front/native": {"motion_kernel", "gcode", "sympas", "toolpaths", "recording"},
}
CRATES = {"motion_kernel", "gcode", "sympas", "toolpaths", "recording", "cnc_front_native"}
HEAVY = {"textual", "cv2", "scipy", "numpy", "mcap", "jinja2"}


def imported(source: str) -> set[str]:
    """Absolute names of the modules that a Python text imports, at whatever depth."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and not node.level and node.module:
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


def strangers(room: str, source: str) -> set[str]:
    """The rooms that a text of `room` imports and must not."""
    native = OWN_NATIVE[room]
    names = {name for name in imported(source) if not (name == native or name.startswith(f"{native}."))}
    return {name.split(".")[0] for name in names} & MAY_IMPORT.keys() - MAY_IMPORT[room] - {room}


@pytest.mark.parametrize("room", MAY_IMPORT)
def test_python_rooms(room: str) -> None:
    for file in [*(ROOT / room).rglob("*.py"), *(ROOT / room).rglob("*.pyi")]:
        assert not strangers(room, file.read_text("utf-8")), file


def test_a_forbidden_import_is_noticed() -> None:
    assert strangers("toolpaths", "def f():\n    from motion_kernel import Mcu") == {"motion_kernel"}
    assert strangers("toolpaths", "import cnc_front._native.motion_kernel") == {"cnc_front"}
    assert strangers("tui", "import gcode, cnc_front.engine") == {"gcode"}
    assert not strangers("gcode", "from cnc_front._native.gcode import compile\nfrom motion_kernel import Machine")


def dependencies(manifest: dict[str, dict[str, object]]) -> set[str]:
    return {
        name for table in ("dependencies", "build-dependencies", "dev-dependencies") for name in manifest.get(table, {})
    }


@pytest.mark.parametrize("crate", MAY_DEPEND)
def test_rust_rooms(crate: str) -> None:
    manifest = tomllib.loads((ROOT / crate / "Cargo.toml").read_text("utf-8"))
    assert dependencies(manifest) & CRATES <= MAY_DEPEND[crate]


def test_only_the_native_crate_knows_python() -> None:
    for manifest in ROOT.glob("**/Cargo.toml"):
        if "target" not in manifest.parts and manifest != ROOT / "Cargo.toml":
            has_python = "pyo3" in dependencies(tomllib.loads(manifest.read_text("utf-8")))
            assert has_python == (manifest.parent == ROOT / "cnc_front/native"), manifest


def test_the_workspace_has_no_other_crate() -> None:
    members = tomllib.loads((ROOT / "Cargo.toml").read_text("utf-8"))["workspace"]["members"]
    assert set(members) == MAY_DEPEND.keys()


def loaded_by(code: str) -> set[str]:
    """Top-level modules that a fresh process has loaded after `code`."""
    show = "import sys; print(*{name.split('.')[0] for name in sys.modules})"
    run = subprocess.run(
        [sys.executable, "-c", f"{code}\n{show}"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return set(run.stdout.split("\n")[-2].split())


def test_the_package_itself_loads_nothing() -> None:
    assert not loaded_by("import cnc_front") & HEAVY
