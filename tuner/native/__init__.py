"""A second way to a problem's gradient: its time loop in C, compiled on this machine."""
