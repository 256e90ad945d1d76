"""Reports: the page shows the figures of the JSON, a recording gives the same ones, a job cannot break the page."""

from __future__ import annotations

import csv
import json
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from cnc_front.recording import open_recording
from cnc_front.report.data import gaps
from tests.app.conftest import ROOT, Cli

BRACKET = ROOT / "examples/jobs/bracket.nc"
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


class Page(HTMLParser):
    """Texts by id, script data, and everything that would be loaded from elsewhere."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.texts: dict[str, str] = {}
        self.links: list[str] = []
        self.tags: list[str] = []
        self._open: str | None = None
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.tags.append(tag)
        self._open = values.get("id") or None
        self.links += [str(values[name]) for name in ("src", "href") if name in values]

    def handle_endtag(self, tag: str) -> None:
        self._open = None

    def handle_data(self, data: str) -> None:
        if self._open:
            self.texts[self._open] = self.texts.get(self._open, "") + data


@pytest.fixture(scope="module")
def reported(cli: Cli, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict]:
    """Folder with `run.mcap`, the report `run` of the run and `again` of its recording; and the object of the run."""
    folder = tmp_path_factory.mktemp("report")
    ran = cli("run", BRACKET, "--record", folder / "run.mcap", "--report", folder / "run", "--json")
    assert ran.code == 0
    assert cli("report", folder / "run.mcap", folder / "again").code == 0
    return folder, ran.object


def figures(folder: Path) -> dict:
    """report.json without what differs from run to run."""
    value = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    assert value["schema"] == "cnc-front/report/1"
    value.pop("run")
    return value


def test_a_recording_gives_the_same_report(reported: tuple[Path, dict]) -> None:
    folder, _ = reported
    assert figures(folder / "run") == figures(folder / "again")
    assert (folder / "run/blocks.csv").read_bytes() == (folder / "again/blocks.csv").read_bytes()


def test_a_recording_with_everything_asked_for_gives_the_same_report(cli: Cli, tmp_path: Path) -> None:
    asked = ("--time-optimal", "--override", "0:1,2:0.6,5:1.2", "--tolerance", "0.02", "--lang", "de")
    ran = cli("run", BRACKET, *asked, "--record", tmp_path / "run.mcap", "--report", tmp_path / "run", "--json")
    assert ran.object["time_optimal_s"] < ran.object["machine_time_s"]
    assert cli("report", tmp_path / "run.mcap", tmp_path / "again", "--lang", "de").code == 0
    mine = figures(tmp_path / "run")
    assert mine == figures(tmp_path / "again")
    assert mine["time_optimal"]["sections"] and mine["limits"] and mine["result"]["time_optimal_s"] > 0
    for name in ("blocks.csv", "png/path-xy.png"):
        assert (tmp_path / "run" / name).read_bytes() == (tmp_path / "again" / name).read_bytes()
    pages = [(tmp_path / name / "report.html").read_text(encoding="utf-8") for name in ("run", "again")]
    assert Page(pages[0]).texts["data"] == Page(pages[1]).texts["data"], "what is drawn is the same, too"


def test_the_page_shows_what_limited_the_feed(reported: tuple[Path, dict]) -> None:
    folder, run = reported
    page = Page((folder / "run/report.html").read_text(encoding="utf-8"))
    limits = json.loads(page.texts["data"])["limits"]
    samples = dict(zip(limits["names"], map(sum, limits["counts"]), strict=True))
    assert sum(samples.values()) == run["samples"], "every sample has one cause"
    rows = figures(folder / "run")["limits"]
    assert [row["limit"] for row in rows] == limits["names"]
    assert [row["samples"] for row in rows] == list(samples.values())
    assert {row["limit"]: row["seconds"] for row in rows} == run["feed"]["limits"]
    assert sum(row["share_pct"] for row in rows) == pytest.approx(100)
    with (folder / "run/blocks.csv").open(encoding="utf-8", newline="") as file:
        blocks = list(csv.DictReader(file))
    assert {row["limit"] for row in blocks} - {""} <= set(limits["names"])
    long = max((row for row in blocks if row["rapid"] == "False"), key=lambda row: float(row["time_s"]))
    assert long["limit"] == "feed" and float(long["limit_pct"]) > 50


def test_the_page_shows_the_figures_of_the_run(reported: tuple[Path, dict]) -> None:
    folder, run = reported
    page = Page((folder / "run/report.html").read_text(encoding="utf-8"))
    assert float(page.texts["fig-actual"]) == pytest.approx(run["deviation"]["actual"]["max_mm"] * 1e3, abs=0.05)
    assert float(page.texts["fig-time"]) == pytest.approx(run["machine_time_s"], abs=0.005)
    assert float(page.texts["fig-feed"]) == pytest.approx(run["feed"]["programmed_reached_pct"], abs=0.05)
    inside = json.loads(page.texts["figures"])["result"]
    assert inside["deviation"] == run["deviation"] and inside["verdict"]["word"] == "PASS"
    data = json.loads(page.texts["data"])
    highest = max(v for v in data["length"]["actualUm"][1] if v is not None)
    assert highest == pytest.approx(run["deviation"]["actual"]["max_mm"] * 1e3, rel=1e-5), "no peak is lost"


def test_the_page_stands_alone(reported: tuple[Path, dict]) -> None:
    folder, _ = reported
    html = (folder / "run/report.html").read_text(encoding="utf-8")
    assert Page(html).links == []
    assert not re.search(r"https?://|@import|url\(", html)
    assert len(html) < 2 << 20
    assert sorted(p.name for p in (folder / "run/png").iterdir()) == [
        *(f"circle-{n}.png" for n in (1, 2)),
        "path-xy-magnified.png",
        "path-xy.png",
        "path-xz.png",
        "path-yz.png",
    ]


def test_blocks_add_up(reported: tuple[Path, dict]) -> None:
    folder, run = reported
    with (folder / "run/blocks.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert sum(float(r["length_mm"]) for r in rows) == pytest.approx(run["path_length_mm"], rel=1e-4)
    assert max(float(r["max_um"]) for r in rows if r["max_um"]) == pytest.approx(
        run["deviation"]["actual"]["max_mm"] * 1e3, rel=1e-4
    )
    worst = max((r for r in rows if r["max_um"]), key=lambda r: float(r["max_um"]))
    assert int(worst["line"]) == run["deviation"]["actual"]["worst"]["line"]


def test_findings_name_the_worst_blocks_and_their_places(reported: tuple[Path, dict]) -> None:
    folder, run = reported
    found = figures(folder / "run")["findings"]
    assert len(found) == 5
    assert [f["max_um"] for f in found] == sorted((f["max_um"] for f in found), reverse=True)
    worst, actual = found[0], run["deviation"]["actual"]
    assert worst["line"] == actual["worst"]["line"]
    assert worst["text"] == BRACKET.read_text().splitlines()[worst["line"] - 1].strip()
    assert worst["max_um"] == pytest.approx(actual["max_mm"] * 1e3, rel=1e-5)
    for axis, place in actual["worst"]["position"].items():
        assert worst["position"][axis] == pytest.approx(place, abs=1.0), "to a vertex of the plotted path"
    page = Page((folder / "run/report.html").read_text(encoding="utf-8"))
    vertex = json.loads(page.texts["data"])["path"]["lines"][worst["vertex"]]
    assert vertex == worst["line"]


def test_nothing_is_drawn_where_blocks_were_left_out() -> None:
    points, begin = np.zeros((6, 3)), np.array([0.0, 10.0, 10.0, 30.0, 40.0])
    s_mm = np.array([0.0, 5.0, 10.0, 40.0, 50.0, 60.0])  # the blocks from 10 to 40 mm were left out
    report = SimpleNamespace(polyline={"points": points, "s_mm": s_mm}, blocks={"s0_mm": begin})
    assert gaps(report).tolist() == [False, False, False, True, False, False]  # type: ignore[arg-type]


def test_statistics_agree_with_the_samples(reported: tuple[Path, dict]) -> None:
    folder, run = reported
    report = figures(folder / "run")
    deviation = [c["deviation_mm"] for c in open_recording(str(folder / "run.mcap")).columns()]
    um = np.concatenate(deviation).astype(np.float64) * 1e3
    actual = report["statistics"]["actual"]
    assert actual["max_mm"] * 1e3 == pytest.approx(um.max(), rel=1e-6)
    assert actual["mean_mm"] * 1e3 == pytest.approx(um.mean(), rel=1e-4)
    assert actual["rms_mm"] * 1e3 == pytest.approx(np.sqrt((um**2).mean()), rel=1e-4)
    for key, percent in {"p95_mm": 95, "p99_mm": 99, "p997_mm": 99.7}.items():
        assert actual[key] * 1e3 == pytest.approx(np.percentile(um, percent), rel=2e-2), key
    times = [report["statistics"][key] for key in ("feed_s", "rapid_s", "standstill_s")]
    assert sum(times) == pytest.approx(run["machine_time_s"], rel=1e-6)
    assert sum(report["histogram"]) == len(um) == run["samples"]


def test_the_limit_and_where_it_comes_from(cli: Cli, tmp_path: Path) -> None:
    ran = cli("run", BRACKET, "--tolerance", "0.005", "--record", tmp_path / "r.mcap", "--report", tmp_path / "r")
    assert ran.code == 1
    assert cli("report", tmp_path / "r.mcap", tmp_path / "again").code == 0
    report = figures(tmp_path / "r")
    assert report == figures(tmp_path / "again")
    assert report["result"]["verdict"]["tolerance_from"] == "option"
    deviation = [c["deviation_mm"] for c in open_recording(str(tmp_path / "r.mcap")).columns()]
    share = 100 * np.mean(np.concatenate(deviation) > 0.005)
    assert report["statistics"]["over_limit_pct"] == pytest.approx(share, rel=1e-6) and share > 0
    html = (tmp_path / "r/report.html").read_text(encoding="utf-8")
    assert "limit 5 µm (--tolerance)" in html and '<header class="fail">' in html
    with (tmp_path / "r/blocks.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {r["verdict"] for r in rows} == {"pass", "fail"}
    assert all((r["verdict"] == "fail") == (float(r["max_um"]) > 5) for r in rows if r["max_um"])


def test_the_text_of_a_job_cannot_break_the_page(cli: Cli, job: Callable[..., Path], tmp_path: Path) -> None:
    hostile = "G1 X10 F600 (</script><script>alert(1)</script><img src=x onerror=alert(2)> & \u2028)\nM30\n"
    ran = cli("run", job(hostile, "a<b>&.nc"), "--report", tmp_path / "report")
    assert ran.code == 0
    html = (tmp_path / "report/report.html").read_text(encoding="utf-8")
    page = Page(html)
    assert page.tags.count("script") == 3 and "img" not in page.tags
    assert "alert(1)" in json.loads(page.texts["data"])["blocks"][0]["text"]


def test_a_cut_recording_gives_a_report_that_says_so(reported: tuple[Path, dict], tmp_path: Path, cli: Cli) -> None:
    whole = (reported[0] / "run.mcap").read_bytes()
    (tmp_path / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    assert cli("report", tmp_path / "cut.mcap", tmp_path / "report").code == 0
    value = figures(tmp_path / "report")
    assert value["note"] and value["result"]["status"] == "stopped"
    assert value["result"]["verdict"]["word"] == "FAIL"
    assert 0 < value["result"]["machine_time_s"] < reported[1]["machine_time_s"]


def test_the_page_speaks_german(cli: Cli, job: Callable[..., Path], tmp_path: Path) -> None:
    assert cli("run", job("G1 X10 F600\nM30\n"), "--report", tmp_path / "r", "--lang", "de").code == 0
    html = (tmp_path / "r/report.html").read_text(encoding="utf-8")
    assert '<html lang="de">' in html and "Bahnabweichung" in html and "Schleppfehler" in html


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_its_script_runs_in_a_browser_without_complaint(reported: tuple[Path, dict]) -> None:
    assert CHROMIUM is not None
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--virtual-time-budget=3000"]
    page = (reported[0] / "run/report.html").as_uri()
    done = subprocess.run([CHROMIUM, *options, "--dump-dom", page], capture_output=True, text=True, timeout=120)
    assert not [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    assert done.stdout.count("<tr") > 100, "the table of blocks was filled"
    shown = Page(done.stdout).texts
    assert float(shown["fig-actual"]) == pytest.approx(reported[1]["deviation"]["actual"]["max_mm"] * 1e3, abs=0.05)
    assert done.stdout.count('<canvas class="axis"') == 3, "one chart of the following error an axis"


#: Uses the page as a reader does: visits the worst place, sweeps every chart, zooms, sorts, filters, prints.
USE = """<script>
document.querySelector("#findings tr[data-vertex]").click();
document.body.dataset.visited = document.getElementById("path-hover").textContent;
for (const canvas of document.querySelectorAll("canvas")) {
  const box = canvas.getBoundingClientRect();
  const at = (type, x, buttons) => canvas.dispatchEvent(
    new PointerEvent(type, { clientX: box.left + x, clientY: box.top + 50, buttons, bubbles: true }));
  at("pointermove", 200, 0); at("pointerdown", 200, 1); at("pointermove", 300, 1);
  at("pointerup", 300, 0);
  canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -200, bubbles: true, cancelable: true }));
  at("pointerleave", 0, 0); canvas.dispatchEvent(new MouseEvent("dblclick"));
}
for (const button of document.querySelectorAll("#views button")) button.click();
for (const box of document.querySelectorAll("input[type=checkbox]")) box.click();
const field = document.getElementById("filter");
document.querySelectorAll("#blocks th button")[2].click();
document.body.dataset.first = document.querySelector("#blocks tbody td").textContent;
field.value = "g3"; field.dispatchEvent(new Event("input"));
document.body.dataset.arcs = document.querySelectorAll("#blocks tbody tr").length;
window.dispatchEvent(new Event("beforeprint")); window.dispatchEvent(new Event("afterprint"));
document.body.dataset.done = "yes";
</script></body>"""


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_the_page_can_be_used(reported: tuple[Path, dict], tmp_path: Path) -> None:
    assert CHROMIUM is not None
    html = (reported[0] / "run/report.html").read_text(encoding="utf-8")
    (tmp_path / "used.html").write_text(html.replace("</body>", USE), encoding="utf-8")
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--virtual-time-budget=3000"]
    page = (tmp_path / "used.html").as_uri()
    done = subprocess.run([CHROMIUM, *options, "--dump-dom", page], capture_output=True, text=True, timeout=120)
    assert not [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    body = re.search(r"<body[^>]*>", done.stdout)
    assert body and 'data-done="yes"' in body[0]
    worst = figures(reported[0] / "run")["findings"][0]
    assert f"line {worst['line']}:" in body[0] and f"{worst['max_um']:.2f} µm" in body[0], "the place is told"
    assert f'data-first="{worst["line"]}"' in body[0], "sorted by deviation, worst first"
    with (reported[0] / "run/blocks.csv").open(encoding="utf-8", newline="") as file:
        arcs = sum("g3" in r["text"].lower() for r in csv.DictReader(file))
    assert f'data-arcs="{arcs}"' in body[0] and arcs > 0


WORN = "G21 G90 G17 G64\nG1 X20 Y-30 F1500\nY0\nG3 X20 Y0 I-20 J0\nG1 Y30\nY0\nG2 X20 Y0 I-20 J0\nG1 Y-30\nM30\n"


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
def test_named_findings_and_circles_are_shown(cli: Cli, job: Callable[..., Path], tmp_path: Path) -> None:
    assert CHROMIUM is not None
    machine = tmp_path / "worn.toml"
    text = cli("machine", "show").out
    machine.write_text(text.replace("backlash = 0.0\n", "backlash = 0.01\n", 1), "utf-8")
    outputs = ("--report", tmp_path / "r", "--record", tmp_path / "r.mcap")
    ran = cli("run", job(WORN), "--machine", machine, *outputs, "--json")
    run = ran.object
    assert ran.code == 0 and run["verdict"]["word"] == "WARN"
    (found,) = run["findings"]
    assert (found["kind"], found["axes"]) == ("reversal_error", ["X"])
    assert found["size_mm"] == pytest.approx(0.01, rel=0.02)
    assert cli("report", tmp_path / "r.mcap", tmp_path / "again").code == 0
    assert figures(tmp_path / "r") == figures(tmp_path / "again")
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--virtual-time-budget=3000"]
    page = (tmp_path / "r/report.html").as_uri()
    done = subprocess.run([CHROMIUM, *options, "--dump-dom", page], capture_output=True, text=True, timeout=120)
    assert not [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    texts = Page(done.stdout).texts
    assert f"{found['size_mm'] * 1e3:.2f} um" in done.stdout.split('id="named"')[1][:300]
    assert float(texts["fig-circular"]) == pytest.approx(run["circularity"][0]["circular_mm"] * 1e3, abs=0.005)
    assert done.stdout.count('<canvas class="polar"') == 2 and done.stdout.count('<canvas class="magnitude"') == 6
    assert f"{run['axes']['X']['limit_margin']:.3f}" in done.stdout
    assert f"{run['motor_command']['X']['peak_pct']:.1f} %" in done.stdout
    assert sorted(p.name for p in (tmp_path / "r/png").iterdir())[:2] == ["circle-1.png", "circle-2.png"]


def test_samples_as_parquet(cli: Cli, job: Callable[..., Path], tmp_path: Path) -> None:
    import pyarrow.parquet as parquet

    program = job("G1 X10 Y5 F600\nG2 X10 Y5 I3\nM30\n")
    ran = cli("run", program, "--report", tmp_path / "r", "--record", tmp_path / "r.mcap", "--samples", "--json")
    assert ran.code == 0 and cli("report", tmp_path / "r.mcap", tmp_path / "again", "--samples").code == 0
    table = parquet.read_table(tmp_path / "r/samples.parquet")
    assert table.equals(parquet.read_table(tmp_path / "again/samples.parquet"))
    run = ran.object
    assert table.num_rows == run["samples"]
    columns = {name: table[name].to_numpy() for name in table.column_names}
    assert columns["t_s"][-1] == pytest.approx(run["machine_time_s"])
    assert columns["deviation_mm"].max() == pytest.approx(run["deviation"]["actual"]["max_mm"], rel=1e-6)
    assert np.abs(columns["dp_X"] - columns["rp_X"]).max() == pytest.approx(run["following_error"]["X"]["max"])
    assert set(columns["line"]) <= {0, 1, 2}
    seconds = {str(name): np.count_nonzero(columns["limit"] == name) * 1.28e-3 for name in set(columns["limit"])}
    assert seconds == pytest.approx(run["feed"]["limits"])
    assert cli("run", program, "--samples").code == 2


def test_samples_without_pyarrow_say_how_to_get_it(job: Callable[..., Path], tmp_path: Path) -> None:
    code = "import sys; sys.modules['pyarrow'] = None; from cnc_front.__main__ import main; main()"
    arguments = ["run", str(job("G1 X1 F600\nM30\n")), "--report", str(tmp_path / "r"), "--samples"]
    ran = subprocess.run(
        [sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False, timeout=60
    )
    assert (ran.returncode, ran.stdout) == (2, "") and "pip install 'cnc-front[samples]'" in ran.stderr
    assert not (tmp_path / "r").exists()
