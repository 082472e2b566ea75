"""Functions of one lane, applied to all eight.

    @lanewise
    def name(w, i):
        x = w[8 + i] * 2.0
        w[16 + i] = x if x > 0.0 else w[0 + i]

is called as name(w), with more arrays of rows as name(w, own). It may assign, choose (x if c else y), and
call functions. Compiled it is operations on whole rows of eight (codegen.instructions); here is what these
do.
"""

LANES = 8


def lanewise(function):
    """Apply a straight-line function of rows and lane `i` to all lanes."""

    def apply(*arrays):
        for i in range(LANES):
            function(*arrays, i)

    return apply
