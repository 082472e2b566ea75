"""Many computations side by side: workers, and the journal of finished ones."""
