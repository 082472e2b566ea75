"""Lambert's W on its lower branch, as source: for numbers where compiled, for arrays where not."""

LAMBERT = '''from numpy import log as ln, sqrt as root


@compiled
def lambert(x):
    """The root y of y - ln y = 1 + d, d = -1 - ln x, by Newton's method; no number where d < 0.

    The series at y = 1 starts it, at most 0.29 of the root below it for any x.
    """
    d = -1.0 - ln(x)
    y = 1.0 + root(2.0 * d) + 2.0 * d / 3.0
    for _ in range(5):
        y = y - (y - ln(y) - 1.0 - d) * y / (y - 1.0)
    return y


'''
