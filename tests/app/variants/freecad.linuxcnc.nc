(Exported by FreeCAD)
(Post Processor: linuxcnc_post)
(Output Time:2024-03-03 10:00:00)
(begin preamble)
G17 G54 G40 G49 G80 G90
G21
(begin operation: T1: Endmill)
(machine units: mm/min)
(T1: Endmill)
M5
M6 T1
G43 H1
M3 S1500
(finish operation: T1: Endmill)
(begin operation: Profile)
(Uncompensated Tool Path)
G0 Z15.000
G0 X-2.500 Y5.000
G0 Z3.000
G1 X-2.500 Y5.000 Z-1.000 F100.000
G2 X0.000 Y7.500 Z-1.000 I2.500 J0.000 K0.000 F200.000
G1 X10.000 Y7.500 Z-1.000
G2 X12.500 Y5.000 Z-1.000 I0.000 J-2.500 K0.000
G0 Z15.000
(finish operation: Profile)
(begin operation: Drilling)
G98
G0 Z5
G83 X5.000 Y5.000 Z-10.000 F60.000 Q2.000 R3.000
G80
G0 Z15.000
(begin postamble)
M05
G17 G54 G90 G80 G40
M6 T0
M2
