"""A study that validates, an analysis that computes nothing, and a figure of nothing."""

import pytest
from matplotlib.figure import Figure

from jointplay import figures
from tests.support.study_samples import TEXT, result, stand_in


@pytest.fixture
def study(tmp_path):
    """Path of a study file that validates."""
    path = tmp_path / "small.toml"
    path.write_text(TEXT)
    return path


@pytest.fixture
def calls(monkeypatch):
    """Stand-ins for analyses and figures; the list of what they were called with."""
    seen = []

    def analysis(mechanism, progress=None, **keywords):
        seen.append((mechanism, keywords))
        if progress:
            progress(0.5)
        return result()

    def draw(dataset, options):
        seen.append(options)
        figure = Figure()
        figure.subplots().plot(dataset["normal_force"])
        return figure

    stand_in(monkeypatch, "response", analysis)
    stand_in(monkeypatch, "section", analysis)
    monkeypatch.setattr(figures, "draw", draw)
    return seen
