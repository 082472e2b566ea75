"""The method: an implicit high-order step, events, the event-driven flow; over a structure's functions."""

pointer = None  # gives the address of a function that numba has compiled; set by compiler, which has made it
kept = None  # gives a compiled function its cache on the disk; set by codegen, since no file is known here
