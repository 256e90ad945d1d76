"""The command line: options, help, exit codes. What a command does stands in cnc_front.commands."""

from __future__ import annotations

import argparse
import io
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from typing import Any

from cnc_front import VERSION, history_arguments, tune_arguments
from cnc_front.batch import arguments as batch_arguments
from cnc_front.errors import CompileError, Exit, UsageError
from cnc_front.examples import examples_text
from cnc_front.geometry import arguments as geometry_arguments

EXIT_CODES = """exit codes: 0 done; 1 a check failed; 2 bad input; 3 stopped by fault or time limit; 130 interrupted
"""


class Parser(argparse.ArgumentParser):
    """Help begins with examples; wrong usage is one line and exit code 2. Options are written out in full."""

    def __init__(self, **options: Any) -> None:
        super().__init__(allow_abbrev=False, **options)

    def format_help(self) -> str:
        return examples_text(self.prog.partition(" ")[2]) + super().format_help()

    def error(self, message: str) -> None:  # type: ignore[override]  # argparse says NoReturn; so does the raise
        raise UsageError(f"{message} (see {self.prog} --help)")


def _positive(highest: float, what: str) -> Callable[[str], float]:
    """A reader of numbers above 0 and below `highest`; what is none is called no `what`."""

    def read(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = -1.0
        if not 0 < value < highest:
            raise argparse.ArgumentTypeError(f"'{text}' is no {what}")
        return value

    return read


def _port(text: str) -> int:
    if not (text.isascii() and text.isdigit() and int(text) < 65536):
        raise argparse.ArgumentTypeError(f"'{text}' is no port (0 to 65535)")
    return int(text)


def _speed(text: str) -> float:
    return 0.0 if text == "max" else _positive(1001.0, "simulation speed (1 to 1000, or max)")(text)


_seconds = _positive(1e9, "positive number of seconds")
_millimetres = _positive(1e6, "positive length in mm")


def _level(text: str) -> int:
    if text not in {str(n) for n in range(1, 10)}:
        raise argparse.ArgumentTypeError(f"block delete level '{text}' is not 1 to 9")
    return int(text)


def _block(text: str) -> str:
    digits = text[1:] if text[:1] in "Nn" else text
    if not (digits.isascii() and digits.isdigit() and len(digits) <= 8):
        raise argparse.ArgumentTypeError(f"'{text}' is neither a line (57) nor a block number (N120)")
    return text.upper()


def _add_run(commands: Any, parents: Sequence[Any]) -> None:
    run = commands.add_parser("run", parents=parents, help="dry-run a job and judge it")
    run.add_argument("job", metavar="JOB")
    run.add_argument("--override", metavar="SCHEDULE", default="1", help="0.5 or 0:1.0,2.5:0.5 (seconds:factor)")
    run.add_argument("--override-sweep", metavar="A:B:STEP", help="a table of runs at factors, e.g. 0.1:1.5:0.1")
    run.add_argument("--record", metavar="F.mcap", help="write a recording")
    run.add_argument("--scan", metavar="NAMES", help="resources to record every sample: dp.X,cp.X.3.0 (with --record)")
    run.add_argument("--report", metavar="DIR", help="write a report")
    run.add_argument("--samples", action="store_true", help="samples.parquet beside the report (extra `samples`)")
    run.add_argument("--tolerance", metavar="MM", type=_millimetres, help="limit of the contour deviation")
    run.add_argument("--max-time", metavar="S", type=_seconds, default=86400.0, help="bound on machine and wall time")
    run.add_argument("--stimulus", metavar="FILE", help="inputs and faults (default: .stim beside the job)")
    run.add_argument("--task", metavar="N=JOB", action="append", default=[], help="a rw_SymPas job for another task")
    run.add_argument("--time-optimal", action="store_true", help="the least time that the axis limits allow (toppra)")
    run.add_argument("--json", action="store_true", help="the result as one JSON object")


def build_parser() -> Parser:
    """All commands and options of design 3.1."""
    common = Parser(add_help=False)
    common.add_argument("--lang", choices=("en", "de"), help="language of messages (default: LANG)")
    common.add_argument("--no-color", action="store_true", help="no colours (NO_COLOR does the same)")
    common.add_argument("-q", "--quiet", action="store_true", help="no progress and no warnings on stderr")
    common.add_argument("-v", "--verbose", action="store_true", help="every warning, and what the result rests on")
    common.add_argument("--no-input", action="store_true", help="never asks (only tui reads its input)")
    compiling = Parser(add_help=False, parents=[common])
    compiling.add_argument("--machine", metavar="FILE", help="machine file (default: machine.toml beside the job)")
    compiling.add_argument("--profile", choices=("din", "fanuc", "linuxcnc", "lathe"), help="dialect of the program")
    compiling.add_argument("--language", choices=("din66025", "sympas", "autocode"), help="language of the job")
    compiling.add_argument("--optional-stop", action="store_true", help="M01 stops")
    compiling.add_argument("--skip", metavar="N", type=_level, action="append", default=[], help="skip blocks /N")

    keeping = Parser(add_help=False)
    keeping.add_argument("--history", metavar="FILE", help="history of runs (default: CNC_FRONT_HISTORY; off: none)")
    part = Parser(add_help=False)
    part.add_argument("--from", dest="start", metavar="N", type=_block, help="begin at line 57 or block N120")
    part.add_argument("--to", dest="stop", metavar="N", type=_block, help="end behind that line or block")

    parser = Parser(
        prog="cnc-front",
        description="Dry-run part programs on an emulated APCI-8001/8008; see how true the machine stays to the path.",
        epilog=EXIT_CODES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"cnc-front {VERSION}")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, parser_class=Parser)
    geometry = geometry_arguments.parent(Parser(add_help=False))
    _add_run(commands, [compiling, part, keeping, geometry])
    check = commands.add_parser("check", parents=[compiling, part], help="compile only")
    check.add_argument("jobs", metavar="JOB", nargs="+")
    check.add_argument("--strict", action="store_true", help="warn of what runs but smells")
    translate = commands.add_parser("translate", parents=[compiling, part], help="list the spooled commands")
    translate.add_argument("job", metavar="JOB")
    translate.add_argument("--json", action="store_true", help="JSON Lines")
    translate.add_argument("--autocode", action="store_true", help="instructions of a rw_SymPas job or autocode file")
    translate.add_argument("--output", metavar="F.cnc", help="write the autocode file of a rw_SymPas job")
    report = commands.add_parser("report", parents=[common, geometry], help="report from a recording")
    report.add_argument("recording", metavar="RECORDING.mcap")
    report.add_argument("folder", metavar="DIR")
    report.add_argument("--samples", action="store_true", help="samples.parquet too (extra `samples`)")
    machine = commands.add_parser("machine", parents=[common], help="check or show a machine file")
    machine.add_argument("action", choices=("check", "show"))
    machine.add_argument("file", metavar="FILE", nargs="?")
    _add_tui(commands, [compiling, keeping])
    history_arguments.add(commands, common, keeping)
    tune_arguments.add(commands, [compiling], _seconds, _millimetres)
    batch_arguments.add(commands, common, _seconds, _millimetres)
    return parser


def _add_tui(commands: Any, parents: list[Parser]) -> None:
    tui = commands.add_parser("tui", parents=parents, help="operator's terminal")
    tui.add_argument("job", metavar="JOB", nargs="?")
    tui.add_argument("--task", metavar="N=JOB", action="append", default=[], help="a rw_SymPas job for another task")
    tui.add_argument("--plain", action="store_true", help="line mode: events as lines, commands as words")
    tui.add_argument("--record", metavar="FOLDER", help="record each program that runs, with what the operator does")
    tui.add_argument("--speed", metavar="X", type=_speed, default=1.0, help="simulation speed, or max (default 1)")
    tui.add_argument("--glyphs", choices=("quadrant", "braille", "half", "ascii"), help="characters of the path plot")
    tui.add_argument("--theme", choices=("dark", "light", "ansi", "mono"), help="colours")
    tui.add_argument("--keymap", metavar="FILE", help="other keys (default: CNC_FRONT_KEYMAP)")
    tui.add_argument("--keys", action="store_true", help="print all keys, as a keymap file")
    tui.add_argument("--view", metavar="PORT", type=_port, help="mirror the screen at localhost, read-only (0: any)")
    tui.add_argument("--no-mouse", action="store_true", help="leave the mouse to the terminal, for copying")


def run_command_line(arguments: Sequence[str]) -> int:
    """Runs one command. Whatever happens becomes text on stderr and an exit code here, and only here."""
    _prepare_streams()
    options = argparse.Namespace()
    try:
        options = build_parser().parse_args(arguments)
        return int(_command(options.command)(options))
    except UsageError as error:
        from cnc_front.german import refusal
        from cnc_front.messages import language_from

        # wrong usage may lie before the language was read
        language = language_from(getattr(options, "lang", None))
        print(f"cnc-front: {refusal(error, language)}", file=sys.stderr)
        return Exit.BAD_INPUT
    except CompileError as error:
        from cnc_front.german import in_language
        from cnc_front.messages import language_from

        for diagnostic in error.diagnostics:
            print(in_language(diagnostic, language_from(options.lang)), file=sys.stderr)
        return Exit.BAD_INPUT
    except KeyboardInterrupt:
        print("cnc-front: interrupted", file=sys.stderr)
        return Exit.INTERRUPTED
    except OSError as error:
        print(f"cnc-front: {error.filename or 'output'}: {error.strerror or error}", file=sys.stderr)
        return Exit.STOPPED
    except SystemExit:
        raise  # --help and --version
    except BaseException as error:  # a panic of the compiled module is no Exception
        print(f"cnc-front: internal error ({type(error).__name__}: {error}); please report it", file=sys.stderr)
        if os.environ.get("CNC_FRONT_DEBUG"):
            traceback.print_exc()
        return Exit.STOPPED


def _prepare_streams() -> None:
    """A closed stream is as good as /dev/null; what its encoding lacks is escaped, not refused."""
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))  # noqa: SIM115, PTH123  open to the end
        elif isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _command(name: str) -> Callable[[argparse.Namespace], int]:
    from cnc_front import commands

    return commands.COMMANDS[name]
