"""Do 95 % intervals contain the true value in 95 % of records? ``python -m benchmarks.coverage``.

Simulated records of a local level, a tracker and an extended filter, and of the first two with
coloured and with heavy-tailed noise, where robust intervals must contain the pseudo-true value:
the maximum of the likelihood in an infinite record.
"""
