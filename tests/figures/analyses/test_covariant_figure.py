"""Picture of covariant vectors: bars of shares, and how often subspaces come near each other."""

import numpy as np
import pytest
import xarray as xr

from jointplay import figures
from jointplay.display.errors import InputError
from tests.figures.support.synthetic import STATUS, flag_words

ONE = {"units": "1", "long_name": "number"}


def vectors(shares=((0.02, 0.9, 0.08), (0.7, 0.3, 0.0), (0.1, 0.2, 0.7)), turning=True, **changes):
    """Three vectors of known shares; angles of 1, 2, … degrees, and ten times as much."""
    shares = np.array(shares)
    count, parts = shares.shape
    names = {"vector": np.arange(1, count + 1), "splitting": np.arange(1, count)}
    coords = names | {"part": np.array(["crank", "play B", "bending"][:parts]), "turn": np.arange(8)}
    tail = "_per_turn" if turning else ""
    degrees = np.outer(np.arange(1, 9), 10.0 ** np.arange(count - 1))
    data = {
        "mean_share": (("vector", "part"), shares, ONE),
        "covariant_exponent": ("vector", np.linspace(1.6, -90.0, count), {"units": "s-1"}),
        f"covariant_exponent{tail}": ("vector", np.linspace(1.6, -90.0, count), ONE),
        f"covariant_standard_error{tail}": ("vector", np.full(count, 0.02), ONE),
        "splitting_angle": (("turn", "splitting"), np.radians(degrees), {"units": "rad"}),
        "settling_residual": ("vector", np.full(count, 1e-9), {"units": "rad"}),
        "block_spread": ((), 6.0, ONE),
        "lost": ((), 0, ONE),
        "status": ((), np.int8(0), flag_words(STATUS, "outcome")),
    }
    data |= {"turn_period": ((), 0.5, {"units": "s"})} if turning else {}
    return xr.Dataset(data, coords, {"kind": "covariant"}).assign(changes)


def test_bars_are_shares():
    data = vectors()
    shares, angles = figures.draw(data).axes
    for bars, name in zip(shares.containers, data["part"].values, strict=True):
        assert [bar.get_width() for bar in bars] == pytest.approx(data["mean_share"].sel(part=name).values)
    ends = [bar.get_x() + bar.get_width() for bar in shares.containers[-1]]
    assert ends == pytest.approx([1.0, 1.0, 1.0])
    assert shares.get_yticklabels()[0].get_text() == "1:  1.600 ± 0.020"
    assert shares.get_ylim()[0] > shares.get_ylim()[1]  # the first on top
    line, _ = angles.lines
    assert line.get_xdata() == pytest.approx(np.arange(1, 9))
    assert line.get_ydata() == pytest.approx(np.arange(1, 9) / 8)


def test_fewer_vectors_and_one_alone():
    shares, angles = figures.draw(vectors(), vectors=1).axes
    assert len(shares.containers[0]) == 1
    assert len(angles.lines) == 1
    _, angles = figures.draw(vectors(shares=((0.5, 0.5),))).axes
    assert [text.get_text() for text in angles.texts] == ["One vector: no angle"]
    assert "1/s" in figures.draw(vectors(turning=False)).axes[0].get_ylabel()
    with pytest.raises(InputError, match="whole number"):
        figures.draw(vectors(), vectors=0)
