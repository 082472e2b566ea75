"""Use that a type checker refuses, each line for the reason that it ignores, and not in vain."""

import jointplay as jp

mechanism = jp.catalog.chunmei2002(clearance=2.9e-4)
jp.simulat(mechanism)  # type: ignore[attr-defined]
jp.simulate(mechanism, turns="many")  # type: ignore[arg-type]
jp.simulate(mechanism, tuns=3)  # type: ignore[call-arg]
jp.lyapunov()  # type: ignore[call-arg]
jp.Link(name="crank", length="long")  # type: ignore[arg-type]
jp.Joint(name="O", bearing=jp.Pin(link="ground"))  # type: ignore[call-arg]
mechanism.replace(1)  # type: ignore[call-arg]
jp.open(3)  # type: ignore[arg-type]
