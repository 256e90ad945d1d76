"""A kernel broken on purpose is noticed: the same property tests that pass on the kernel fail on each broken one.

The Rust sources are copied beside the build and patched there, all breaks in one build; the environment variable
BROKEN names the one that acts. The product itself knows nothing of this.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

from tests.house.test_sizes import ROOT, tracked

SUITE = ("chains", "optimum")
# name: (file of motion_kernel/src, what stands there, what stands there when broken, a test that must notice)
BREAKS = {
    "sign of phi": (
        "path.rs",
        "let angle = phi.to_radians();",
        "let angle = -phi.to_radians();",
        "set_points_lie_on_the_path_at_any_override",
    ),
    "off-by-one sample": (
        "cycle.rs",
        "if t < end_t {",
        "if t + self.ta < end_t {",
        "path_dynamics_are_kept",
    ),
    "missing carry-over": (
        "cycle.rs",
        "rest = t - end_t;",
        "rest = 0.0;",
        "split_lines_are_the_lines",
    ),
    "wrong junction": (
        "motion.rs",
        "let end = path::point(geometry.length, geometry.curvature);",
        "let end = path::point(0.0, geometry.curvature);",
        "no_junction_steps_by_more_than_mdvel",
    ),
    "override on one axis only": (
        "pcap.rs",
        "axis.trajectory.take(self.registers.trovr, step);",
        "if Some(a) == axes.iter().next() { axis.trajectory.take(self.registers.trovr, step); }",
        "set_points_lie_on_the_path_at_any_override",
    ),
}
SWITCH = """
/// Whether this is the break to act.
pub fn broken(name: &str) -> bool {
    static NAME: std::sync::LazyLock<Option<String>> = std::sync::LazyLock::new(|| std::env::var("BROKEN").ok());
    NAME.as_deref() == Some(name)
}
"""

QUICK = {
    "PROPTEST_MAX_SHRINK_ITERS": "0",
    "PROPTEST_DISABLE_FAILURE_PERSISTENCE": "1",
    "PROPTEST_RNG_SEED": "1",
}


def switched(statement: str, name: str, broken: str) -> str:
    """Both versions of a statement, the broken one when the switch says so."""
    if statement.startswith("let "):
        target, value = statement.removeprefix("let ").rstrip(";").split(" = ", 1)
        other = broken.split(" = ", 1)[1].rstrip(";")
        return f'let {target} = if crate::broken("{name}") {{ {other} }} else {{ {value} }};'
    if statement.startswith("if "):
        return f'if crate::broken("{name}") && ({broken[3:-2]}) || !crate::broken("{name}") && ({statement[3:-2]}) {{'
    return f'if crate::broken("{name}") {{ {broken} }} else {{ {statement} }}'


def sources(copy: Path) -> None:
    """The workspace with every break in it."""
    shutil.rmtree(copy, ignore_errors=True)
    for file in tracked("Cargo.toml", "Cargo.lock", "*/Cargo.toml", "*.rs", "examples/machines/*"):
        target = copy / file.relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(file, target)
    for name, (file, statement, broken, _) in BREAKS.items():
        path = copy / "motion_kernel" / "src" / file
        text = path.read_text("utf-8")
        assert statement in text, f"{file} changed: say in BREAKS what stands there now for {statement!r}"
        path.write_text(text.replace(statement, switched(statement, name, broken)), "utf-8")
    library = copy / "motion_kernel" / "src" / "lib.rs"
    library.write_text(library.read_text("utf-8") + SWITCH, "utf-8")


def built() -> list[Path]:
    """The test programs of the broken workspace. They have a target folder of their own: cargo names what it builds by
    the place inside the workspace, so broken libraries would take the place of whole ones."""
    folder = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "sabotage"
    source, target = folder / "source", folder / "build"
    sources(source)
    environment = os.environ | {"CARGO_TARGET_DIR": str(target)}
    only = [part for test in SUITE for part in ("--test", test)]
    command = [
        "cargo",
        "test",
        "-p",
        "motion_kernel",
        "--locked",
        "--no-run",
        "--message-format=json-render-diagnostics",
    ]
    build = subprocess.run([*command, *only], cwd=source, env=environment, capture_output=True, text=True, check=False)
    assert build.returncode == 0, build.stderr[-3000:]
    messages = map(json.loads, build.stdout.splitlines())
    return [Path(m["executable"]) for m in messages if m.get("executable")]


def failures(suite: list[Path], broken: str) -> set[str]:
    """The tests that fail on a kernel with that break."""
    environment = os.environ | {"BROKEN": broken} | QUICK
    failed: set[str] = set()
    for program in suite:
        run = subprocess.run([program], env=environment, capture_output=True, text=True, check=False, timeout=300)
        failed.update(re.findall(r"^test (\S+) \.\.\. FAILED$", run.stdout, re.MULTILINE))
    return failed


def test_the_suite_notices_every_break() -> None:
    suite = built()
    assert len(suite) == len(SUITE)
    assert failures(suite, "none") == set()
    noticed = {name: failures(suite, name) for name in BREAKS}
    assert {name: BREAKS[name][-1] in tests for name, tests in noticed.items()} == dict.fromkeys(BREAKS, True), noticed
