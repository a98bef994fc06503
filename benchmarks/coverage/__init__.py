"""Do 95 % intervals hold the true value in 95 % of records? ``python -m benchmarks.coverage``.

Simulated records of a local level, a tracker and an extended filter, and of the first two with
coloured and with heavy-tailed noise, where robust intervals have to hold the pseudo-true value:
the one that the likelihood comes to in an endless record.
"""
