"""A filter as a graph of scalars, and what is made of it: C, and expressions of CasADi."""
