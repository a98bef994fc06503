"""A second implementation of a problem's gradient: its time loop in C, compiled locally."""
