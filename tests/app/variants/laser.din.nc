; LightBurn 1.4.00
; GRBL device profile, absolute coords
; Bounds: X10 Y10 to X50 Y40
G00 G17 G40 G21 G54
G90
M4
; Cut @ 1500 mm/min, 50% power
M8
G0 X10Y40
; Layer C00
G1 X10Y10S500F1500
G1X50
G1Y40
G1X10
M9
G1S0
M5
G90
; return to user-defined finish pos
G0 X0Y0
M2
