"""How fast the filters and their tuning are, beside a C limit and beside other libraries."""
