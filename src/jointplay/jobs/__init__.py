"""Many computations side by side: workers, and what they have finished."""
