"""Studies: published tuning results, run again and compared with what the papers say."""
