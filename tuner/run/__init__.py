"""From a recording or a paper to a folder of results."""
