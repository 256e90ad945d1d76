(tiles by G92 and the present position)
G21 G90
F300
o100 sub
G1 X1 Y1
G1 X2 Y0
G0 X0 Y0
o100 endsub
o100 call
G0 X10
G92 X[#5420-10]
o100 call
#2500=[#5221+1]
G92.1
G0 X#2500
M2
