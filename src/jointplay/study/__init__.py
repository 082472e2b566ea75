"""Studies: a file that describes a computation, the run, and the stored result."""
