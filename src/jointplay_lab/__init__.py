"""The laboratory: the paper's reproduction, and the program's own examination. No other room needs it."""
