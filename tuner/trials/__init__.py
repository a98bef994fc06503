"""Trials in a database that any number of processes share: Optuna's, and what it lacks."""
