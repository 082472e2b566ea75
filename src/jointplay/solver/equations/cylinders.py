"""Elastic force of a journal against its bearing, both cylinders, from their materials and radii.

Over a length L, with the radii R and R + e and 1/E* = (1 - nu_j^2)/E_j + (1 - nu_b^2)/E_b:

    Johnson (1985), Contact Mechanics            u = F/(pi E* L) (ln(4 pi E* L e/F) - 1)
    Dubowsky and Freudenstein (1971)             u = F/(pi E* L) (ln(pi E* L^3 e/(R (R + e) F)) + 1)
    Liu, Zhang and Yang (2007)                     F = (pi/2) E* L u sqrt(u/(2 (e + u)))

The first two give u over F and turn back at a deepest u_1, where F has an infinite slope: 4 e/exp(2), and
L^2 e/(R (R + e)). Both are u = F/S ln(b/F), S = pi E* L, so that up to u_1

    F = S u/lambda,      lambda exp(-lambda) = u/(u_1 exp(1)), lambda > 1      (Lambert's W, lower branch),
    stored               F u (1/2 - 1/(4 lambda)).

Valid for elastic bodies in plane strain; the first two where the contact is narrow beside R, u far below u_1;
Liu's, which fits finite elements, for contacts that conform. Johnson's is F (2 ln(4 r/a) - 1)/(pi E* L) of a
cylinder on a half-plane, a^2 = 4 F r/(pi E* L), with e in the place of r, as the literature on joints has it.
Dubowsky and Freudenstein's stands here as that literature quotes it, with a pi in S, which plane elasticity
asks for; their own paper was not seen.

At u < 0 each goes on as an odd function nearly, within a picometre of u = 0 rounded off: F dU/du of a U(u)
that is |u|, but for u < 0 stays below u_1.
"""

from math import e as NEPER
from math import log, pi

ROUND = 1e-12  # m: above the rounding of a gap, below every penetration that matters


def modulus(E_j, nu_j, E_b, nu_b):
    """E* of both materials, Pa."""
    return 1 / ((1 - nu_j**2) / E_j + (1 - nu_b**2) / E_b)


def logarithmic(m, u, S, u_1):
    """F = S u/lambda, and its stored energy; not a number beyond u_1."""
    size = m.sqrt(u**2 + ROUND**2)
    bend = 1 + (1 - m.side(u)) / 2 * size / u_1
    U = size / bend
    turns = m.lambert(U / (u_1 * NEPER))
    F = S * U / turns
    return F * u / (size * bend**2), F * U * (0.5 - 0.25 / turns)


def logarithmic_slope(depth, S, u_1):
    """Bounds of dF/du, and of F, up to a depth, or to half of u_1.

    lambda is at least 1 + sqrt(2 d) + 2 d/3, d = ln(u_1/u) (Chatzigeorgiou 2013, IEEE Commun. Lett. 17).
    """
    U = min(depth + ROUND, u_1 / 2)
    d = log(u_1 / U)
    beyond = (2 * d) ** 0.5 + 2 * d / 3
    return S / beyond, S * U / (1 + beyond)


def conforming(m, u, S, e):
    """Liu's F and its stored energy, S = pi E* L; this is a difference, rounded by 1e-16 S sqrt(e^3 u)."""
    U = m.sqrt(u**2 + ROUND**2)
    root, share = m.sqrt(U * (U + e)), m.sqrt(U / e)
    arc = m.log(share + m.sqrt(1 + U / e))
    stored = S / 8**0.5 * ((2 * U - 3 * e) * root + 3 * e**2 * arc) / 4
    return S / 2 * m.sqrt(U / (2 * (U + e))) * u, stored


def conforming_slope(depth, S, e):
    """Bounds of dF/du, and of F, up to a depth."""
    U = depth + ROUND
    share = (U / (2 * (U + e))) ** 0.5
    return S / 4 * share * (3 * e + 2 * U) / (U + e), S / 2 * share * U


def johnson(L, E, R, e):
    """S and u_1 of Johnson's law."""
    return pi * E * L, 4 * e / NEPER**2


def dubowsky_freudenstein(L, E, R, e):
    """S and u_1 of Dubowsky and Freudenstein's law."""
    return pi * E * L, L**2 * e / (R * (R + e))


def liu(L, E, R, e):
    """S and e of Liu's law."""
    return pi * E * L, e
