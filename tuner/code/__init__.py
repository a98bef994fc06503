"""A filter as a graph of scalars, from which C and CasADi expressions are generated."""
