"""Linear systems: covariances, modes, placement and responses, without any data."""
