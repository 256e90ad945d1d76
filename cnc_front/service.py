"""What the service screen shows of the controller: registers with plain text per bit, tasks, variables, versions."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

from cnc_front import VERSION
from cnc_front._native import motion_kernel as native_kernel
from cnc_front.jobs import MachineFile

#: Common variables looked at: CI0 and CD0 up to this number.
VARIABLES = 1000
TASKS = 4
#: Gains in the order of `rdf` (4.4.65).
GAINS = ("kp", "ki", "kd", "kpl", "kfcv", "kfca")
#: CNCTS.running (4.3.2.10): the task runs; it waits for a single step.
RUNS, STEPS = 1, 2

#: German text of each bit, by the manual's name; the English one is that of the kernel's table.
GERMAN: dict[str, str] = {
    "eo": "Not-Aus: ein EO-Eingang ist aktiv",
    "dnr": "Antrieb nicht bereit: ein DR-Eingang ist inaktiv",
    "lslh": "linker Hardware-Endschalter",
    "lsrh": "rechter Hardware-Endschalter",
    "lsls": "linker Software-Endschalter überfahren",
    "lsrs": "rechter Software-Endschalter überfahren",
    "mpe": "Schleppfehler über mpe",
    "dhef": "Datenfehler",
    "cef": "Konfigurationsfehler",
    "pe": "Profilende erreicht",
    "cl": "Regelkreis geschlossen",
    "ip": "in Position",
    "ui": "ein UI-Eingang ist aktiv",
    "lpsf": "Position gelatcht",
    "referenced": "Referenzposition gesetzt",
    "refh": "ein REF-Eingang ist aktiv",
    "saf": "Spooler asynchron in seiner Gruppe",
    "errAxDef": "eine Achse ist in einem Fahrbefehl zweimal gewählt",
    "errTargetVel": "Zielgeschwindigkeit am Ende des Spoolers nicht 0",
    "errUnit": "ungültige Einheit",
    "errCenterPoint": "ungültiger Kreismittelpunkt",
    "errSpoolerOverrun": "Spooler-Überlauf",
    "ProfileToSmall": "zwei Profile hintereinander kürzer als ein Abtastschritt",
    "SplineSizeErr": "zu viele Spline-Sätze",
    "RotationFail": "Achsdrehung misslungen",
    "PciBusError": "Fehler der PCI-Brücke",
    "CheckMonitorScreen": "eine Meldung steht auf dem Monitorschirm",
    "SsfWaitRefused": "ein Wartebefehl ist übergangen, die Bewegung davor hält nicht",
    "SpoolerLoadError": "der Spooler wurde beschrieben, während ein Profil entstand",
    "VelocityZero": "Interpolation mit Geschwindigkeit 0 verworfen",
    "AccelZero": "Interpolation mit Beschleunigung 0 verworfen",
    "LimitDefError": "ungültige mcp-Grenze",
    "ZeroProfile": "Interpolation ohne Weg verworfen",
    "RadiusError": "Kreis mit Radius 0 verworfen",
    "SpoolerDeepToLess": "zu wenige Profile im Spooler für die Vorausschau",
    "IOResetHandled": "unerwarteter Reset der Ein- und Ausgänge",
    "JSatSAFdone": "Achsen angehalten, weil Spooler asynchron liefen",
}


@dataclass(frozen=True, slots=True)
class Bit:
    """An assigned bit of a register."""

    number: int
    name: str
    text: str
    on: bool


@dataclass(frozen=True, slots=True)
class ServiceAxis:
    """What the controller reports of one axis; positions in the axis' unit, memory in bytes."""

    name: str
    unit: str
    command: float
    actual: float
    following: float
    mpe: float
    velocity: float  # command, unit/s
    axst: tuple[Bit, ...]
    gains: tuple[tuple[str, float], ...]
    spooler: str  # Direct, Running ...
    entries: int
    free: int
    memory: int
    override: float  # JOVR
    inputs: int
    outputs: int

    def is_on(self, name: str) -> bool:
        """Whether a status bit is set."""
        return any(bit.name == name and bit.on for bit in self.axst)


@dataclass(frozen=True, slots=True)
class ServiceTask:
    """A CNC task: its state word and current line."""

    number: int
    running: int
    line: int
    error: int
    error_line: int


@dataclass(frozen=True, slots=True)
class Service:
    """The whole controller at one instant."""

    axes: tuple[ServiceAxis, ...]
    errorreg: tuple[Bit, ...]
    tasks: tuple[ServiceTask, ...]
    integers: tuple[tuple[int, int], ...]  # common integers that are not 0
    doubles: tuple[tuple[int, float], ...]
    samples: int
    sample_time_us: float
    trovr: float
    versions: tuple[tuple[str, str], ...]


@cache
def _table(register: str, language: str) -> tuple[tuple[int, str, str], ...]:
    rows = native_kernel.register_bits(register)
    return tuple((n, name, GERMAN.get(name, text) if language == "de" else text) for n, name, text in rows)


def _bits(register: str, names: list[str], language: str) -> tuple[Bit, ...]:
    return tuple(Bit(n, name, text, name in names) for n, name, text in _table(register, language))


def service_of(mcu: native_kernel.Mcu, file: MachineFile, language: str) -> Service:
    """Reads the controller; call it in the thread that owns it."""
    status, machine = mcu.status(), file.machine
    tasks = []
    for number in range(TASKS):
        errnum, errline, running, line, _ = mcu.rdcncts(number)
        tasks.append(ServiceTask(number, running, line, errnum, errline))
    integers = ((n, mcu.rdci(n)) for n in range(VARIABLES) if n != 100)  # rdci(100) reads a block
    doubles = ((n, mcu.rdcd(n)) for n in range(VARIABLES))
    return Service(
        tuple(_axis(mcu, a, values, file, language) for a, values in enumerate(status["axes"])),
        _bits("errorreg", status["errorreg"], language),
        tuple(tasks),
        tuple((n, value) for n, value in integers if value),
        tuple((n, value) for n, value in doubles if value),
        mcu.samples(),
        machine.sample_time_us,
        status["trovr"],
        (("cnc-front", VERSION), (machine.name, file.sha256[:12])),
    )


def _axis(mcu: native_kernel.Mcu, a: int, v: dict[str, Any], file: MachineFile, language: str) -> ServiceAxis:
    machine = file.machine
    return ServiceAxis(
        name=machine.axis_names[a],
        unit=machine.units[a],
        command=v["dp"],
        actual=v["rp"],
        following=v["dp"] - v["rp"],
        mpe=machine.mpe[a],
        velocity=v["dv"],
        axst=_bits("axst", v["axst"], language),
        gains=tuple(zip(GAINS, mcu.rdf(a), strict=True)),
        spooler=str(v["spooler"]),
        entries=int(v["mcis"]),
        free=int(v["lsm"]),
        memory=int(v["memory"]),
        override=v["jovr"],
        inputs=mcu.rddigi(a),
        outputs=int(v["digo"]),
    )
