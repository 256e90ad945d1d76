"""The compiled module; its submodules belong to the rooms of the same name."""

from cnc_front._native import gcode as gcode
from cnc_front._native import motion_kernel as motion_kernel
from cnc_front._native import recording as recording
from cnc_front._native import sympas as sympas
from cnc_front._native import toolpaths as toolpaths
