"""The solver as JavaScript: kernels and equations translated from their Python, and a driver for pages."""
