"""Published mechanisms whose answers are published too: what is computed beside what was printed."""
