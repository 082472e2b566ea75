"""Names of the numbers of a structure: the symbols of its equations that are parameters, in their order."""

from .drives import DRIVES
from .friction import parameter_letters
from .laws import LAWS
from .structure import Beam, Course, Linkage, Span


def parameter_names(structure: Linkage) -> list[str]:
    """Name every number of the structure, in the order of the parameter array."""
    names = [f"H_{k}_{m}" for k, m in structure.couplings] + [f"mu_{k}" for k in structure.links]
    names += [f"m_{f}" for f in range(len(structure.floats))] + ["g"]
    names += ["up_x", "up_y"] if structure.tilted else []
    for joint in structure.joints:
        words = (*joint.sizes, "rx0", "ry0", *LAWS[joint.law].letters, *parameter_letters(joint.friction))
        names += [f"{word}_{joint.owner}" for word in words]
        names += [f"D_{joint.owner}_{k}" for k in joint.arms]
    for pin in structure.pins:
        names += [f"m_{pin.name}"] + [f"mu_{pin.name}_{k}" for k in pin.arms]
        names += [name for _, name in pin.bases if name != f"m_{pin.name}"]
    for beam in structure.beams:
        names += _beam_names(beam, structure.relaxed)
    for spring in structure.springs:
        words = ("k", "c", "rest") if spring.damped else ("k", "rest")
        names += [f"{word}_{spring.span.name}" for word in words] + _span_names(spring.span, spring.twists)
    for slide in structure.slides:
        fixed = [f"c_{slide.link}", f"s_{slide.link}"], [f"turn_c_{slide.link}", f"turn_s_{slide.link}"]
        names += [*fixed[slide.guide != "ground"], f"dc_{slide.name}", f"ds_{slide.name}"]
    for vector in (*structure.slides, *structure.closures):
        names += [f"rx0_{vector.name}", f"ry0_{vector.name}", *(f"D_{vector.name}_{k}" for k in vector.arms)]
    for closure, *others in structure.loops:
        names += ["settling"] if others else [f"{word}_{closure.name}" for word in ("side", "one", "two")]
    for load in structure.loads:
        names += _course_names(load.course)
        if load.span:
            names += [f"d{axis}_{load.span.name}" for axis in "xy"] + _span_names(load.span, nowhere=True)
    names += _course_names(structure.course) if structure.course else []
    return [*dict.fromkeys(names), *DRIVES[structure.drive].letters]


def _beam_names(beam: Beam, relaxed: bool) -> list[str]:
    words = ("S", "I", "k", "c", "start", "end", "gauge", *(("rate", "acc") if relaxed else ()))
    names = [f"{word}_{beam.link}_{i}" for word in words for i in range(beam.modes)]
    along = ("along", "lever", "axial", "axial_c", "stretch")
    names += [f"{word}_{beam.link}_{a}" for word in along for a in range(beam.axial)]
    names += [f"G_{beam.link}_{i}_{a}" for i in range(beam.modes) for a in range(beam.axial)]
    return names + [f"L_{beam.link}_{k}" for k in beam.arms]


def _course_names(course: Course) -> list[str]:
    names = [f"mean_{course.name}"] + [f"nu_{course.name}"] * course.timed
    return names + [f"{letter}_{course.name}_{n}" for n in course.orders for letter in "ab"]


def _span_names(span: Span, nowhere: bool = False) -> list[str]:
    place = [] if nowhere else [f"x0_{span.name}", f"y0_{span.name}"]
    return place + [f"D_{span.name}_{k}" for k in span.arms]
