"""The signature of every command: its arguments and options; the work is done elsewhere."""
