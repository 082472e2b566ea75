"""What laws of friction claim and what they give: rows of docs/friction-laws.md."""

from __future__ import annotations

import numpy as np

from tests.support.belt import LAWS, ratio

SPEEDS = np.concatenate([[0.0], np.geomspace(1e-6, 1.0, 200_000)])


def rows() -> list[str]:
    """Lines of the table, of claims that are not met: law, claim, deviation in units of what is claimed."""
    found = []

    def claim(name, text, value, claimed):
        off = value / claimed - 1
        if abs(off) >= 1e-15:
            found.append(f"| `{name}` | {text} | {off:+.1e} of it |")

    for name in ("coulomb", "tanh", "ramp", "ambrosio", "threlfall", "andersson", "brown_mcphee", "stribeck"):
        claim(name, "sliding at 1 m/s meets f", ratio(LAWS[name], 1.0), 0.3)
    for name in ("andersson", "brown_mcphee", "stribeck"):
        claim(name, "the largest μ is f_s", ratio(LAWS[name], SPEEDS).max(), 0.5)
    claim("brown_mcphee", "μ at v_0 is f_s", ratio(LAWS["brown_mcphee"], 0.02), 0.5)
    return found


if __name__ == "__main__":
    print("\n".join(rows()))
