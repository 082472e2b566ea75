"""Figures of Lyapunov exponents."""
