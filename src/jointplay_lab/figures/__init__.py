"""Figures of the laboratory's results, published as an entry point of the group `jointplay.figures`."""

from importlib import import_module
from pkgutil import iter_modules

for _each in iter_modules(__path__, f"{__name__}."):  # a figure adds itself
    import_module(_each.name)
