"""Growth of small differences: Lyapunov exponents, and a second way to them."""
