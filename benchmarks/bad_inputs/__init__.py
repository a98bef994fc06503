"""Bad input of every kind, made by a seed: each refusal must be one sentence."""
