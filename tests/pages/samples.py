"""Results to make pages of: a linkage that turns, and sweeps with their study."""

import json

import numpy as np
import xarray as xr

from jointplay import catalog
from jointplay.solver.mechanism.loops.ideal import ideal_state
from tests.figures.analyses.test_bifurcation import sweep
from tests.figures.support.synthetic import flag_words

EVIL = '</script><script>document.title = "broken in"</script><img src=x onerror=document.title="broken in">'


def with_study(dataset, **study):
    """The dataset with the provenance of a run."""
    study = {"name": "sample", "kind": dataset.attrs["kind"]} | study
    origin = {"software": {"name": "jointplay", "version": "1"}, "environment": {"python": "3"}}
    origin |= {"kernel_digest": "d1ge57", "study": study, "study_text": f"# {EVIL}\nkind = 'bifurcation'\n"}
    return dataset.assign_attrs(provenance=json.dumps(origin), title=EVIL)


def diagram():
    """A bifurcation diagram upward and downward, with its study."""
    return with_study(sweep(), vary={"clearance": [1e-5, 9e-4]})


def turning(mechanism=None, samples=48):
    """A response of an ideal four-bar that turns evenly, the journal of B moving in its clearance."""
    mechanism = mechanism or catalog.chunmei2002(clearance=2.9e-4)
    period, names = 0.075, [link.name for link in mechanism.links]
    turns = np.arange(samples + 1) / samples
    states = [ideal_state(mechanism, 2 * np.pi * turn)[0] for turn in turns]
    angle = np.array([[state[name] for name in names] for state in states])
    place = np.zeros((samples + 1, 1))
    data = {
        "angle": (("time", "link"), angle, {"units": "rad", "long_name": "link angle"}),
        "journal_x": (("time", "joint"), place, {"units": "m", "long_name": "journal centre, x"}),
        "journal_y": (("time", "joint"), place, {"units": "m", "long_name": "journal centre, y"}),
        "normal_force": (("time", "joint"), 50 + place, {"units": "N", "long_name": "normal contact force"}),
        "clearance": ("joint", [2.9e-4], {"units": "m", "long_name": "radial clearance"}),
        "turn_period_nominal": ((), period, {"units": "s", "long_name": "nominal period"}),
        "status": ((), np.int8(0), flag_words(("ok",), "outcome")),
    }
    coords = {"time": ("time", period * turns, {"units": "s", "long_name": "time"}), "link": names}
    return xr.Dataset(data, coords | {"joint": ["B"]}, {"kind": "response"})
