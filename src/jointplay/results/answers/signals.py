"""Answers of signals: 0-1 test, spectrum, correlation dimension."""

import math

import numpy as np
from xarray import DataArray, Dataset

from jointplay.display import codes
from jointplay.display.number_text import MINUS, plain, with_error
from jointplay.display.units import measure


def chaos_test_verdict(dataset: Dataset) -> DataArray:
    """Return the test's verdict on each run."""
    return codes.words(dataset["verdict"])


def chaos_test(dataset: Dataset) -> str:
    """Return K with its quartiles, and the test's verdict."""
    low, middle, high = (
        float(dataset["chaos_indicator_quartile"].sel(quartile=q)) for q in (0.25, 0.5, 0.75)
    )
    if math.isnan(middle):
        return "K of the 0-1 test: not known"
    verdict = str(chaos_test_verdict(dataset).item())
    quartiles = f"quartiles {low:.3f} to {high:.3f}"
    line = f"0-1 test: {verdict}, " + f"K = {middle:.3f} ({quartiles})".translate(MINUS)
    if verdict == "chaotic":
        line += "\nit has no error bar: an exponent decides (kind = 'lyapunov')"
    return line


def spectrum(dataset: Dataset) -> str:
    """Return where the spectrum is highest, and the size of the signal."""
    density, frequency = dataset["power_spectral_density"].values, dataset["frequency"].values
    beyond = np.isfinite(density) & (frequency > 0)
    if not beyond.any():
        return "spectrum: not known"
    at = int(np.flatnonzero(beyond)[np.argmax(density[beyond])])
    place = measure(float(frequency[at]), "Hz")
    if "order" in dataset:
        place += f", order {plain(float(dataset['order'][at]), 4)}"
    variance, squared = float(dataset["variance"]), str(dataset["variance"].attrs.get("units", "1"))
    name = str(dataset["variance"].attrs.get("long_name", "signal")).removeprefix("variance of ")
    size = measure(math.sqrt(variance), squared[:-1] if squared.endswith("2") else "1")
    return f"{name}: highest density at {place}; standard deviation {size}"


def dimension(dataset: Dataset) -> str:
    """Return the correlation dimension with its error."""
    value = float(dataset["correlation_dimension"])
    if math.isnan(value):
        return "correlation dimension: not known, too few pairs of points lie within the range of distances"
    points = f"of {int(dataset['n_points'])} section points"
    if value == 0:
        return f"correlation dimension 0 {points}: they lie in few places, as those of a periodic motion"
    error = float(dataset["correlation_dimension_standard_error"])
    return f"correlation dimension {with_error(value, error)} {points}; the motion's own is one more"
