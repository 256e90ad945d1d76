(to the left, where the limit switch is also the end of the way)
G21 G90 G54
G0 X0 Y0 Z0
G1 X-80 F2400
M30
