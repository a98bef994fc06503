"""What speaks for a solution: gradient, curvature, multipliers, agreement, single precision."""
