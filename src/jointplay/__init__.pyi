"""The public names, and where they are: read by type checkers, and by the package itself on first use."""

from jointplay_lab.benchmarks.benchmark import benchmark as benchmark
from jointplay_lab.paper.claims import claims as claims
from jointplay_lab.paper.readings import readings as readings
from jointplay_lab.precision.work_precision import work_precision as work_precision
from jointplay_lab.scheme.scheme_comparison import scheme_comparison as scheme_comparison
from jointplay_lab.scheme.waveform import waveform as waveform
from jointplay_lab.stress.stress import stress as stress
from jointplay_page.report import report as report

from .analysis.assessment.assess import assess as assess
from .analysis.coexisting.attractors import attractors as attractors
from .analysis.coexisting.tipping import tipping as tipping
from .analysis.curves.curve import curve as curve
from .analysis.exponents.covariant import covariant as covariant
from .analysis.exponents.growth import growth as growth
from .analysis.exponents.lyapunov import lyapunov as lyapunov
from .analysis.gradients.gradient import gradient as gradient
from .analysis.gradients.optimise import optimise as optimise
from .analysis.orbits.continuation import continuation as continuation
from .analysis.orbits.periodic_orbit import periodic_orbit as periodic_orbit
from .analysis.poincare import poincare as poincare
from .analysis.signals.chaos_test import chaos_test as chaos_test
from .analysis.signals.dimension import dimension as dimension
from .analysis.signals.spectrum import spectrum as spectrum
from .analysis.simulate import simulate as simulate
from .analysis.states.basins import basins as basins
from .analysis.states.sensitivity import sensitivity as sensitivity
from .analysis.sweeps.bifurcation import bifurcation as bifurcation
from .analysis.sweeps.gather import cell as cell
from .analysis.tolerances.tolerances import tolerances as tolerances
from .display.errors import InputError as InputError, ModelWarning as ModelWarning
from .figures import draw as _draw
from .solver.mechanism import catalog as catalog
from .solver.mechanism.parts.contact_data import (
    contact_data as contact_data,
    contact_stiffness as contact_stiffness,
)
from .solver.mechanism.parts.fits import fit as fit
from .solver.mechanism.records import (
    Beam as Beam,
    ConstantSpeed as ConstantSpeed,
    Contact as Contact,
    ContactSection as ContactSection,
    CrankAngle as CrankAngle,
    Force as Force,
    Friction as Friction,
    Harmonic as Harmonic,
    Impact as Impact,
    Joint as Joint,
    Jump as Jump,
    Link as Link,
    Mechanism as Mechanism,
    MotorLine as MotorLine,
    Pin as Pin,
    Plane as Plane,
    PointMass as PointMass,
    PrescribedTorque as PrescribedTorque,
    Rubbing as Rubbing,
    SeparationSection as SeparationSection,
    Servo as Servo,
    SpeedCycle as SpeedCycle,
    SpeedProfile as SpeedProfile,
    Spring as Spring,
    Switch as Switch,
    System as System,
    TestSystem as TestSystem,
    Torque as Torque,
    TorsionSpring as TorsionSpring,
    Touch as Touch,
)
from .study.in_python import run as run
from .study.results.animate import animate as animate
from .study.results.export import export as export, words as words
from .study.results.store import open_result as _open
from .study.results.summary import summary as summary

__version__: str
figure = _draw
open = _open
