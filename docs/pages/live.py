"""Pages that compute, for the front of the documentation: the paper's mechanism, and a slider-crank."""

from __future__ import annotations

from pathlib import Path

import jointplay as jp

MECHANISMS = {
    "four_bar": jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0),
    "slider_crank": jp.catalog.slider_crank(),
}


def write(folder: Path) -> None:
    """Write the pages into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, mechanism in MECHANISMS.items():
        jp.report(mechanism, folder / f"{name}.html")
