"""The structures of chapter 4.3.2 that PCAP commands return."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

MAXAXIS = 18  # axes that the driver supports (4.3.1)


@dataclass(slots=True)
class TSRP:
    """Parameters of one axis (4.3.2.2), in axis units (mm or degrees, s). A copy: nothing updates it but a read.

    dv, sdec, aux and lp are missing in the table of the manual and used by its commands (errata)."""

    an: int = 0
    kp: float = 0.0
    ki: float = 0.0
    kd: float = 0.0
    kpl: float = 0.0
    kfca: float = 0.0
    kfcv: float = 0.0
    jac: float = 0.0
    jvl: float = 0.0
    jtvl: float = 0.0
    jovr: float = 1.0
    hac: float = 0.0
    hvl: float = 0.0
    rp: float = 0.0
    dp: float = 0.0
    tp: float = 0.0
    sll: float = 0.0
    slr: float = 0.0
    ipw: float = 0.0
    mpe: float = 0.0
    gf: float = 0.0
    mcp: int = 0
    axst: int = 0
    lsm: int = 0
    epc: int = 0
    digi: int = 0
    digo: int = 0
    ifs: int = 0
    dv: float = 0.0
    sdec: float = 0.0
    aux: float = 0.0
    lp: float = 0.0


class Filter(NamedTuple):
    """Coefficients of the PIDF filter (4.4.64): error in counts, output in digits (32767 = 10 V)."""

    kp: float
    ki: float
    kd: float
    kpl: float
    kfca: float
    kfcv: float


class TaskStatus(NamedTuple):
    """CNCTS (4.3.2.10): error number and its line, state bits, source line being executed, free bytes of the stack."""

    errnum: int
    errline: int
    running: int
    csrcline: int
    stackfree: int


class ROSI(NamedTuple):
    """Operating system information (4.3.2.8); all 0 where the card does not answer."""

    revision: str
    number_axis: int
    sysfile_loaded: int


class Initialised(NamedTuple):
    """What the initialisation commands return: return code (0 = success), the axes, the system, the board type
    (32 = APCI-8008)."""

    status: int
    tsrp: list[TSRP]
    rosi: ROSI
    boardtype: int
