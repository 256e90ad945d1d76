"""The command line of `tune`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

RANGE_HELP = "factors (default 0.5:2:0.25), or values: kp=0.4:0.8:0.1:abs"


def add(
    commands: Any, parents: Sequence[Any], seconds: Callable[[str], float], millimetres: Callable[[str], float]
) -> None:
    """Adds the command to the parser of cnc_front.cli."""
    tune = commands.add_parser("tune", parents=parents, help="sweep machine parameters, show the trade-off")
    tune.add_argument("job", metavar="JOB")
    tune.add_argument("--vary", metavar="NAME,NAME", required=True, help="numbers of the machine file: mdvel,kp,lag_s")
    tune.add_argument("--for", dest="goal", choices=("time", "deviation"), default="time", help="what is best")
    tune.add_argument("--range", metavar="NAME=A:B:STEP", action="append", default=[], help=RANGE_HELP)
    tune.add_argument("--axes", metavar="X,Y", help="axes that are varied (default: all)")
    tune.add_argument("--override", metavar="SCHEDULE", default="1", help="as for run")
    tune.add_argument("--tolerance", metavar="MM", type=millimetres, help="limit of the contour deviation")
    tune.add_argument("--max-time", metavar="S", type=seconds, default=86400.0, help="machine and wall time of a run")
    tune.add_argument("--out", metavar="DIR", help="report.html with the curve, tune.json")
    tune.add_argument("--json", action="store_true", help="the result as one JSON object")
