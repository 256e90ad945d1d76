"""The controller of an application: all PCAP commands (chapter 4.4) on the emulator.

Positions in mm or degrees, velocities per second, accelerations per second², times in s unless said otherwise;
interpolation commands in PU and TU of `ctru` (mm and s after boot). Axes are given by name or index. Emulated time
moves only in `advance`. A command that reads returns the value; one that writes returns the code of the manual where
there is one. `docs/pcap.md` lists all of them.
"""

from __future__ import annotations

from motion_kernel.axis_values import Parameters, Positions
from motion_kernel.debug import Debugging
from motion_kernel.homing import Homing
from motion_kernel.motion import SpooledMotion
from motion_kernel.resources import ResourceAccess
from motion_kernel.status import CardRegisters, Status
from motion_kernel.system import System
from motion_kernel.system_values import SystemValues
from motion_kernel.tasks import Tasks


class Mcu(
    SpooledMotion,
    Homing,
    Positions,
    Parameters,
    SystemValues,
    Status,
    CardRegisters,
    Tasks,
    Debugging,
    ResourceAccess,
    System,
):
    """Controllers after boot: loops open, MODEREG and TROVRST 0. One card for each machine; commands go to the one that
    `cardselect` chose, at first card 0. Not safe across threads."""

    # ---- the application's side of a G-code run

    def prepare_gcode(self) -> None:
        """MODEREG, TROVRST, closed loops and references as at the start of a part program (design D19)."""
        self._mcu.prepare_gcode()

    def hold(self) -> None:
        """Operator's feed hold along the path (design D5)."""
        self._mcu.hold()

    def resume(self) -> None:
        """Goes on after a hold."""
        self._mcu.resume()
