"""Evidence for a solution: gradient, curvature, multipliers, agreement, single precision."""
