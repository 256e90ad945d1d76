"""The count of shown rows is itself checked: on a small made-up tree, and that each kind of false claim is noticed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.conformance.__main__ import judge_python, judge_rust, table
from tests.conformance.cargo import Binary, binaries, outcomes
from tests.conformance.catalogue import read_catalogue
from tests.conformance.claims import claims_in, claims_under

pytest_plugins = ("pytester",)

ROOT = Path(__file__).parents[2]
CATALOGUE = """id,chapter,area,name,must
a.one,1,move,One,must one
a.two,1,move,Two,"must two, too"
b.one,2,jog,Three,must three
b.remark,2,jog,Four,[note] only a remark
"""
LIB = """
fn helper() {}
// shows: a.one, a.two
// shows: b.one
#[test]
#[should_panic]
fn first() {}
proptest! {
    // shows: a.two
    #[test]
    fn second(x in 0..1) {}
}
// shows: b.one
fn no_test() {}
"""


@pytest.fixture
def crate(tmp_path: Path) -> Path:
    (tmp_path / "conformance-toy.csv").write_text(CATALOGUE, "utf-8")
    for name, text in {
        "src/lib.rs": "",
        "src/deep/mod.rs": LIB,
        "src/other.rs": "fn x() {}",
        "tests/all.rs": LIB,
    }.items():
        (tmp_path / "crate" / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / "crate" / name).write_text(text, "utf-8")
    return tmp_path


def result(crate: Path, root: str, name: str, outcome: str = "passed") -> dict[str, str]:
    return {"package": str(crate / "crate"), "root": str(crate / "crate" / root), "name": name, "outcome": outcome}


def test_claims_are_read_with_their_function(crate: Path) -> None:
    found = [(claim.line, claim.function, claim.ids) for claim in claims_in(crate / "crate/src/deep/mod.rs")]
    assert found == [(3, "first", ("a.one", "a.two", "b.one")), (9, "second", ("a.two",)), (13, "", ("b.one",))]


def test_output_of_cargo_is_understood() -> None:
    artifact = {
        "reason": "compiler-artifact",
        "manifest_path": "/w/crate/Cargo.toml",
        "executable": "/t/deps/all-01ab",
        "target": {"src_path": "/w/crate/tests/all.rs"},
    }
    known = binaries([json.dumps(artifact), '{"reason":"build-finished"}', "   Compiling crate"])
    assert known == {"all-01ab": Binary("/w/crate", "/w/crate/tests/all.rs")}
    output = [
        "     Running tests/all.rs (/t a/deps/all-01ab)\n",
        "test deep::first - should panic ... ok\n",
        "test second ... FAILED\n",
        "test third ... ignored, slow\n",
        "   Doc-tests crate\n",
        "test src/lib.rs - f (line 3) ... ok\n",
    ]
    assert [(t["name"], t["outcome"]) for t in outcomes(output, known)] == [
        ("deep::first", "passed"),
        ("second", "failed"),
        ("third", "skipped"),
    ]


def test_a_passing_test_shows_its_rows(crate: Path) -> None:
    claims = [claim for claim in claims_under(crate, ["crate"]) if claim.function]
    tests = [result(crate, "src/lib.rs", f"deep::{name}") for name in ("first", "second")]
    tests += [result(crate, "tests/all.rs", name) for name in ("first", "second")]
    shown, wrong = judge_rust(claims, tests)
    assert (shown, wrong) == ({"a.one", "a.two", "b.one"}, [])


@pytest.mark.parametrize("outcome", ["failed", "skipped"])
def test_a_test_that_does_not_pass_shows_nothing(crate: Path, outcome: str) -> None:
    claim = next(claims_in(crate / "crate/tests/all.rs"))
    shown, wrong = judge_rust([claim], [result(crate, "tests/all.rs", "first", outcome)])
    assert not shown
    assert outcome in wrong[0] and "all.rs:3" in wrong[0]


def test_a_claim_without_a_test_or_a_run_is_an_error(crate: Path) -> None:
    first, second, lost = claims_in(crate / "crate/tests/all.rs")
    elsewhere = [result(crate, "src/lib.rs", "other::first")]
    shown, wrong = judge_rust([first, second, lost], elsewhere)
    assert not shown
    assert ["0 tests named first" in wrong[0], "0 tests named second" in wrong[1], "directly above" in wrong[2]] == [
        True
    ] * 3


def test_namesakes_are_told_apart_by_module(crate: Path) -> None:
    claim = next(claims_in(crate / "crate/src/deep/mod.rs"))
    tests = [result(crate, "src/lib.rs", "other::first", "failed"), result(crate, "src/lib.rs", "deep::tests::first")]
    assert judge_rust([claim], tests) == ({"a.one", "a.two", "b.one"}, [])


def test_python_results(crate: Path) -> None:
    passed, failed = {"outcome": "passed", "shows": ["a.one"]}, {"outcome": "skipped", "shows": ["a.two"]}
    shown, wrong = judge_python(
        {"t.py::good": passed, "t.py::bad": failed, "t.py::plain": {"outcome": "failed", "shows": []}}
    )
    assert shown == {"a.one"}
    assert wrong == ["t.py::bad: skipped, but claims a.two"]


def test_notes_are_left_out_of_the_count(crate: Path) -> None:
    lines = table(read_catalogue(crate), {"a.one", "b.remark"})
    assert lines[0] == "toy: 1 of 3"
    assert [line.split() for line in lines[1:3]] == [["move", "1", "of", "2"], ["jog", "0", "of", "1"]]
    assert lines[-1] == "conformance: 1 of 3 rows shown"


def test_a_row_that_stands_twice_is_refused(crate: Path) -> None:
    (crate / "conformance-zoo.csv").write_text(CATALOGUE, "utf-8")
    with pytest.raises(ValueError, match=r"a\.one occurs twice"):
        read_catalogue(crate)


def test_plugin_writes_the_worst_outcome_and_the_rows(pytester: pytest.Pytester) -> None:
    pytester.makeini("[pytest]\nmarkers = shows(*ids): rows")
    pytester.makepyfile(
        test_toy="""
        import pytest
        @pytest.fixture
        def broken():
            yield
            assert False
        @pytest.mark.shows("a.one", "a.two")
        def test_good(): pass
        @pytest.mark.shows("b.one")
        def test_teardown_fails(broken): pass
        @pytest.mark.skip
        @pytest.mark.shows("b.one")
        def test_skipped(): pass
        """
    )
    pytester.runpytest_subprocess("-p", "tests.conformance.plugin", "-n", "2", "--results", "out.json").assert_outcomes(
        passed=2, skipped=1, errors=1
    )
    assert json.loads((pytester.path / "out.json").read_text()) == {
        "test_toy.py::test_good": {"outcome": "passed", "shows": ["a.one", "a.two"]},
        "test_toy.py::test_teardown_fails": {"outcome": "failed", "shows": ["b.one"]},
        "test_toy.py::test_skipped": {"outcome": "skipped", "shows": ["b.one"]},
    }
