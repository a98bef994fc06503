"""Bad input of every kind, made by a seed: what is refused has to be refused in one sentence."""
