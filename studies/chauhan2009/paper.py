"""The paper's description of its experiments."""

DT, EVERY = 0.25, 4
"""A tick, s, and ticks between measurements (section 6.1)."""
TRACKED = (4.4, 17.4, 28.2)
STEADY = (29.1, 15.7, 3.05)
DRIVEN = (14.1, 35.1, 44.6)
MAGNIFIED = 45.7
"""Pitch angles of Figs 2 to 4, 5, 6 to 8 and 9, deg."""
