//! Trajectory units PU and TU and encoder counts: every conversion there is (4.3.2.3, 4.4.11).
