"""The figure of tolerances: what lies on what."""

from jointplay import figures
from tests.figures.test_pictures import sampled


def test_the_legend_of_shares_lies_beside_their_bars():
    """Every share is whole: no corner of the panel is free."""
    full = sampled()
    for name in ("first_order", "total"):
        full[name][:] = 1.0
    figure = figures.draw(full, {"kind": "tolerances"})
    figure.draw_without_rendering()
    ax = figure.axes[1]
    legend = ax.get_legend().get_window_extent()
    assert not any(legend.overlaps(bar.get_window_extent()) for bar in ax.patches)
    assert not legend.overlaps(ax._left_title.get_window_extent())
    assert figure.bbox.contains(legend.x1, legend.y1)


def test_without_shares_there_is_no_panel_of_them():
    """All samples have the same outcome."""
    same = sampled()
    same["total"][:] = float("nan")
    figure = figures.draw(same, {"kind": "tolerances"})
    assert len(figure.axes) == 2
    assert not any(text.get_text() for ax in figure.axes for text in ax.texts)
