"""Answers of derivatives in parameters."""

import numpy as np
from xarray import Dataset

from jointplay.analysis.gradients.gradient_dataset import WHY
from jointplay.display import codes
from jointplay.display.number_text import plain

LISTED = 3  # quantities, and parameters of each, named in a line


def gradient(dataset: Dataset) -> str:
    """Return what each quantity depends on most, relatively, and whether there is a derivative."""
    verdict = str(codes.words(dataset["differentiable"]).item())
    if not np.isfinite(dataset["derivative"].values).any():
        return f"no derivative: {WHY.get(verdict, verdict)}"
    lines = [_quantity(dataset.isel(quantity=i)) for i in range(min(LISTED, dataset.sizes["quantity"]))]
    if verdict != "yes":
        lines.append(f"hardly a derivative here: {WHY.get(verdict, verdict)}")
    return "\n".join(lines)


def _quantity(one: Dataset) -> str:
    sizes = np.nan_to_num(one["relative_sensitivity"].values)
    order = np.argsort(-np.abs(sizes), kind="stable")[:LISTED]
    parts = [f"{plain(float(sizes[i]), 3)} by {one['parameter'].values[i]}" for i in order if sizes[i]]
    name, units = str(one["quantity"].item()), str(one["quantity_units"].item())
    value = f"{name} = {plain(float(one['value']), 6)}" + (f" {units}" if units != "1" else "")
    return (
        f"{value}: relative sensitivity {', '.join(parts)}" if parts else f"{value}: depends on none of them"
    )
