"""The problem: what is tuned, within which limits, judged by what."""
