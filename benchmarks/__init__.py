"""Speed of the filters and of their tuning, compared with a C limit and other libraries."""
