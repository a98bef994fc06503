"""Data: recordings and their units, made-up ones, and what their noise is."""
