"""Data: recordings and their units, simulated records, and their noise."""
