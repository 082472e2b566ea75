"""What users wait for and what a core does, as benchmarks of asv (airspeed velocity); see docs/benchmarks.md.

Seconds are of CPU time and tell also what the machine does besides. Counts of a turn do not: they are what
commits can be compared by. asv takes more for worse; revolutions and cells are meant the other way round.
"""
