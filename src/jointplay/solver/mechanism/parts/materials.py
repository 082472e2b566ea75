"""Materials of links, pins and bushes: elasticity, density and friction, each with its spread and its source.

Values are usual ones at room temperature. A spread is that of grades sold under one name, of moisture in
plastics, of running-in; it is no error of a measurement. Friction is sliding friction on a steel pin, dry or
greased; of what no source gives, `sources` says "estimate". Restitution is that of a blow at some 0.1 m/s.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any

from pydantic import BeforeValidator, Field

from jointplay.display.errors import InputError, unknown
from jointplay.solver.mechanism.base import Name, Number, Positive, Record, accepts, measured

_RATIO = "a number above -1, up to 0.5"
_Ratio = Annotated[Number, Field(gt=-1, le=0.5)]
Spread = tuple[float, float, float]  # usual, low, high
_METAL, _PLASTIC = (0.8, 0.5, 0.95), (0.6, 0.4, 0.8)


class Material(Record):
    """A material: one of the table by its name, or numbers of your own.

    Parameters
    ----------
    name : str
        Name.
    modulus : float
        Young's modulus E, Pa.
    poisson_ratio : float
        Poisson's ratio ν.
    density : float
        ρ, kg/m³.
    """

    name: Name = "own"
    modulus: Positive = measured("Young's modulus", "Pa")
    poisson_ratio: _Ratio = measured("Poisson's ratio", "1", 0.3, accepts=_RATIO)
    density: Positive = measured("density", "kg/m³")

    @property
    def known(self) -> Known:
        """Spread, friction and restitution by the table; of a material of your own, estimates."""
        return TABLE.get(self.name, _OWN)

    @property
    def moduli(self) -> Spread:
        """Young's modulus, usual, low and high, Pa: the table's spread about this material's."""
        usual, low, high = self.known.modulus
        return self.modulus, self.modulus * low / usual, self.modulus * high / usual


@dataclass(frozen=True, kw_only=True)
class Known:
    """Properties of a material of the table: usual value, low and high.

    Parameters
    ----------
    modulus : tuple of float, shape (3,)
        Young's modulus, Pa.
    poisson_ratio, density : float
        Poisson's ratio; density, kg/m³.
    dry, greased : tuple of float, shape (3,)
        Coefficient of sliding friction of a bush of it on a steel pin.
    restitution : tuple of float, shape (3,)
        Coefficient of restitution of a pin in a bush of it.
    sources : str
        Where elasticity and density, then friction, come from.
    """

    modulus: Spread
    poisson_ratio: float
    density: float
    dry: Spread
    greased: Spread
    sources: str
    restitution: Spread = _METAL


def _of(
    E: Spread, nu: float, density: float, dry: Spread, greased: Spread, sources: str, **more: Any
) -> Known:
    moduli = tuple(1e9 * each for each in E)
    return Known(
        modulus=moduli, poisson_ratio=nu, density=density, dry=dry, greased=greased, sources=sources, **more
    )


_MARKS = "friction: Marks' Standard Handbook for Mechanical Engineers, sliding friction"
_MAKERS = "friction: makers' data of bushes"
_SOFT: dict[str, Any] = {"restitution": _PLASTIC}
TABLE = {
    "steel": _of(
        (210, 200, 212), 0.3, 7850, (0.42, 0.15, 0.6), (0.1, 0.03, 0.2), f"EN 1993-1-1, 3.2.6; {_MARKS}"
    ),
    "stainless steel": _of(
        (200, 190, 210), 0.3, 7900, (0.5, 0.3, 0.8), (0.15, 0.1, 0.25), "EN 1993-1-4; friction: estimate"
    ),
    "cast iron": _of(
        (110, 103, 118), 0.26, 7200, (0.23, 0.15, 0.4), (0.13, 0.07, 0.2), f"EN 1561, EN-GJL-250; {_MARKS}"
    ),
    "bronze": _of(
        (100, 90, 115), 0.34, 8900, (0.25, 0.1, 0.35), (0.12, 0.06, 0.17),
        f"Copper Development Association, C93200; {_MARKS}",
    ),
    "sintered bronze": _of(
        (40, 25, 60), 0.3, 6600, (0.12, 0.05, 0.2), (0.08, 0.04, 0.13),
        f"ISO 5755, modulus as density to the 3.4 (German, Powder Metallurgy Science); {_MAKERS} with oil",
    ),
    "brass": _of(
        (97, 92, 110), 0.34, 8500, (0.4, 0.3, 0.5), (0.15, 0.1, 0.2),
        f"Copper Development Association, C36000; {_MARKS}",
    ),
    "aluminium": _of(
        (70, 68, 73), 0.33, 2700, (0.47, 0.3, 0.6), (0.17, 0.1, 0.3), f"EN 1999-1-1, 3.2.5; {_MARKS}"
    ),
    "titanium": _of(
        (114, 105, 120), 0.34, 4430, (0.4, 0.3, 0.6), (0.2, 0.1, 0.3),
        "ASM Handbook, volume 2, Ti-6Al-4V; friction: estimate",
    ),
    "POM": _of(
        (2.8, 2.4, 3.2), 0.37, 1410, (0.2, 0.1, 0.3), (0.1, 0.05, 0.15),
        "makers' data; friction: CRC Materials Science and Engineering Handbook, table 399", **_SOFT,
    ),
    "PA66": _of(
        (1.8, 1.2, 3.3), 0.4, 1140, (0.3, 0.15, 0.45), (0.12, 0.08, 0.2),
        f"makers' data, moist to dry; {_MAKERS}", **_SOFT,
    ),
    "PEEK": _of(
        (4.0, 3.5, 4.3), 0.38, 1300, (0.35, 0.2, 0.45), (0.1, 0.06, 0.15), f"makers' data; {_MAKERS}", **_SOFT
    ),
    "PTFE-lined": _of(
        (5, 1, 30), 0.4, 7000, (0.12, 0.02, 0.25), (0.06, 0.02, 0.12),
        f"estimate, of a thin layer on sintered bronze on steel; {_MAKERS}", **_SOFT,
    ),
}  # fmt: skip
_OWN = _of((1, 0.9, 1.1), 0.3, 1, (0.3, 0.1, 0.6), (0.12, 0.05, 0.25), "friction: estimate")


def _by_name(given: Any) -> Any:
    """A material of the table for its name."""
    if not isinstance(given, str):
        return given
    if given not in TABLE:
        known = [*TABLE, "a table of modulus (Pa), poisson_ratio and density (kg/m³)"]
        raise InputError([unknown("", given, given, known, "material")])
    own = TABLE[given]
    return Material(name=given, modulus=own.modulus[0], poisson_ratio=own.poisson_ratio, density=own.density)


class MaterialSchema:
    """Marks a field so that its JSON schema takes the name of a material, or a table."""

    def __get_pydantic_json_schema__(self, _: Any, handler: Any) -> Mapping[str, Any]:
        return {"anyOf": [{"enum": [*TABLE]}, handler(Material.__pydantic_core_schema__)]}


_ACCEPTS = f"a material, {', '.join(TABLE)}, or a table of modulus (Pa), poisson_ratio and density (kg/m³)"
AnyMaterial = Annotated[Material, BeforeValidator(_by_name), MaterialSchema(), accepts(_ACCEPTS)]
