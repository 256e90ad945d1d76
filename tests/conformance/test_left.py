"""Rows that no test shows stand in left.csv with the reason, and nothing else does; every claim is a row."""

from __future__ import annotations

import csv
from pathlib import Path

from tests.conformance.catalogue import read_catalogue
from tests.conformance.pcap_page import shown_by

FOLDER = Path(__file__).parent


def test_rows_left_open_have_a_reason_and_no_test() -> None:
    with (FOLDER / "left.csv").open(encoding="utf-8", newline="") as lines:
        left = {row["id"]: row["reason"] for row in csv.DictReader(lines)}
    assert left.keys() <= read_catalogue(FOLDER).keys()
    assert all(len(reason) > 20 for reason in left.values())
    assert not left.keys() & shown_by().keys()


def test_every_claim_is_a_row() -> None:
    rows = read_catalogue(FOLDER).keys()
    assert not {row: tests for row, tests in shown_by().items() if row not in rows}
