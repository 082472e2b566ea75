"""Studies: a file that says what to compute, the run, and the stored result."""
