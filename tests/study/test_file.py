"""Study files: what is accepted, and every way to be wrong with its key path."""

import json

import pytest
import xarray as xr

from jointplay.analysis.quantities import LINKAGE, WORDS
from jointplay.analysis.signals import chaos_test
from jointplay.display.errors import InputError
from jointplay.solver.mechanism import catalog
from jointplay.solver.mechanism.records import CrankAngle, MotorLine
from jointplay.study.file import load, validate
from jointplay.study.results import provenance
from jointplay.study.results.store import write_result
from jointplay.study.toml_text import override, parse
from tests.support.study_samples import BENT, BENT_WRITTEN_OUT, TEXT, WRITTEN_OUT
from tests.support.wrong import texts_of


def problems(text, *changes, name="x"):
    """Key and message of each problem of a study text."""
    return texts_of(validate, {"name": name} | override(parse(text), changes))


def test_a_file_without_a_kind_is_told_which_commands_take_it():
    with pytest.raises(InputError, match="assess, tolerances, figure and report take a mechanism"):
        validate({"name": "x", "mechanism": {"catalog": "chunmei2002"}})


def test_a_study_without_a_title_is_called_by_its_kind_in_words():
    table = {"name": "x", "mechanism": {"catalog": "slider_crank"}}
    found = {kind: validate(table | {"kind": kind}).heading for kind in ("assess", "chaos_test")}
    assert found == {"assess": "assessment of slider crank", "chaos_test": "chaos test of slider crank"}


def test_a_study_is_read(study):
    loaded = load(study, ["mechanism.gear_ratio=15", "title=changed"])
    record = loaded.record
    assert loaded.text == TEXT
    assert (record.kind, record.name, record.title) == ("response", "small", "changed")
    assert record.mechanism == catalog.chunmei2002(clearance=2.9e-4, gear_ratio=15.0)
    assert record.analysis.section == CrankAngle(angle=0.5)
    assert record.figure == {"kind": "overview", "joint": "B"}
    assert record.keywords() == {
        "rtol": 1e-9, "turns": 2, "transient": 1, "section": CrankAngle(angle=0.5), "steps": False,
    }  # fmt: skip


def test_of_a_file_or_a_result_of_another_kind_the_mechanism_alone_is_taken(study, tmp_path):
    loaded = load(study)
    kept = provenance.attach(xr.Dataset(), loaded.record.model_dump(mode="json"), loaded.text)
    result = write_result(kept, tmp_path / "motion.nc")
    assert load(result).record == load(study, kind="response").record == loaded.record
    for path in (study, result):
        found = load(path, kind="assess").record
        assert (found.kind, found.name) == ("assess", f"{path.stem}_assess")
        assert found.mechanism == loaded.record.mechanism
    assert load(study, ["name=mine"], kind="assess").record.name == "mine"
    study.write_text('title = "A rocker"\n[mechanism]\ncatalog = "chunmei2002"\n')
    assert load(study, kind="assess").record.heading == "A rocker"


def test_a_linkage_written_out_equals_the_catalog():
    written = validate({"name": "x"} | parse(WRITTEN_OUT)).mechanism
    listed = catalog.chunmei2002(speed=80.0)
    assert written.links == listed.links
    assert written.drive == listed.drive
    assert [joint.name for joint in written.clearance_joints] == ["B"]
    assert written.joint("B") == listed.joint("B")


USUAL = [name for name in LINKAGE if WORDS[name].of not in ("bending", "guide", "guided")]


@pytest.mark.parametrize(
    "text", [TEXT, WRITTEN_OUT, BENT, BENT_WRITTEN_OUT, TEXT.replace('joint = "B"', "turns = 1")]
)
@pytest.mark.parametrize(
    "change",
    ["analysis.initial.crank_angle=1.5", f"analysis.record={USUAL}", "integrator={}"],
)
def test_the_resolved_study_is_plain_and_gives_the_same_study(text, change):
    record = validate({"name": "x"} | override(parse(text), [change]))
    resolved = json.loads(json.dumps(record.model_dump(mode="json"), allow_nan=False))
    assert validate(resolved) == record


def test_a_test_system_may_be_studied():
    changes = ["mechanism={ catalog = 'lorenz', rho = 20 }", "figure={ kind = 'phase_portrait' }"]
    changes += ["analysis.section={ kind = 'plane', quantity = 'x', value = 1 }"]
    record = validate({"name": "x"} | override(parse(TEXT), [*changes, "analysis.initial=[1, 2, 3]"]))
    assert record.mechanism == catalog.lorenz(rho=20.0)
    assert record.keywords()["initial"] == (1.0, 2.0, 3.0)
    assert validate(record.model_dump(mode="json")) == record


def test_changes_reach_every_part_of_the_catalog_entry():
    changes = [
        "mechanism.clearance={ B = 1e-5, C = 2e-5 }",
        "mechanism.friction=0",
        "mechanism.tension=false",
    ]
    mechanism = validate({"name": "x"} | override(parse(TEXT), changes)).mechanism
    assert {joint.name: joint.clearance for joint in mechanism.clearance_joints} == {"B": 1e-5, "C": 2e-5}
    assert mechanism.joint("B").friction is None
    assert not mechanism.joint("B").contact.tension
    assert isinstance(mechanism.drive, MotorLine)


WRONG = {  # change: key of the problem, words in its message
    "kind=respons": ("kind", "did you mean 'response'", "section"),
    "nmae=a": ("nmae", "did you mean 'name'"),
    "name=../a": ("name", "letters"),
    "name=''": ("name", "letters"),
    "title=3": ("title", "text"),
    "mechanism=3": ("mechanism", "catalog"),
    "mechanism.catalog=chunmei": ("mechanism.catalog", "did you mean 'chunmei2002'"),
    "mechanism.catalog=[1]": ("mechanism.catalog", "accepted"),
    "mechanism.clearence=1e-4": ("mechanism.clearence", "did you mean 'clearance'"),
    "mechanism.clearance='1e-4'": ("mechanism.clearance", "number"),
    "mechanism.clearance=-1e-4": ("mechanism.clearance", "at least 0"),
    "mechanism.clearance=nan": ("mechanism.clearance", "got nan", "at least 0"),
    "mechanism.clearance={ X = 1e-4 }": ("mechanism.clearance.X", "accepted: O, A, B, C"),
    "mechanism.gear_ratio=true": ("mechanism.gear_ratio", "greater than 0"),
    "mechanism.gear_ratio=inf": ("mechanism.gear_ratio", "got inf", "greater than 0"),
    "mechanism.friction=-0.1": ("mechanism.friction", "at least 0"),
    "mechanism.tension=1": ("mechanism.tension", "true or false"),
    "integrator.rtol=0": ("integrator.rtol", "at least 1e-14"),
    "integrator.rtoll=1e-8": ("integrator.rtoll", "did you mean 'rtol'"),
    "integrator.max_steps=0": ("integrator.max_steps", "at least 1"),
    "analysis.samples_per_turn=2.5": ("analysis.samples_per_turn", "whole number"),
    "analysis.turns=0": ("analysis.turns", "greater than 0"),
    "analysis.turns='2'": ("analysis.turns", "number greater than 0"),
    "analysis.transient=-1": ("analysis.transient", "at least 0"),
    "analysis.duration=1.0": ("analysis.turns", "not both"),
    "analysis.duration=-1.0": ("analysis.duration", "greater than 0"),
    "analysis.record=3": ("analysis.record", "list of names"),
    "analysis.initial=3": ("analysis.initial", "crank_angle"),
    "analysis.initial.crank_angel=3": ("analysis.initial.crank_angel", "did you mean 'crank_angle'"),
    "analysis.initial=[nan]": ("analysis.initial[0]", "numbers"),
    "analysis.section.angle='a'": ("analysis.section.angle", "number"),
    "analysis.section={ kind = 'crankangle' }": ("analysis.section.kind", "did you mean 'crank_angle'"),
    "analysis.section={ angle = 1 }": ("analysis.section.kind", "which form"),
    "analysis.section={ kind = 'contact', joint = 'A' }": ("analysis.section.joint", "ideal", "accepted: B"),
    "analysis.section={ kind = 'contact', joint = 'Q' }": ("analysis.section.joint", "no such joint"),
    "figure=3": ("figure", "table"),
    "figure.kind=overvew": ("figure.kind", "did you mean 'overview'"),
    "figure.kind=[1]": ("figure.kind", "overview"),
    "figure.jiont=B": ("figure.jiont", "did you mean 'joint'"),
    "figure.turns=[3, 1]": ("figure.turns", "a number of turns, or [first, last]"),
    "figure={ kind = 'time_history', variables = ['energy'] }": ("figure.variables", "recorded variable"),
    "figure={ kind = 'time_history', events = ['touch'] }": ("figure.events", "kind of event", "reopening"),
    "figure={ kind = 'time_history', column = 'tripel' }": ("figure.column", "single, double"),
    "figure={ kind = 'time_history', axis = 3 }": ("figure.axis", "one or two of: time"),
    "analysis.record=['angel']": ("analysis.record[0]", "did you mean 'angle'"),
    "analysis.record=['normal_force']": ("analysis.record", "journal_x, journal_y, eccentricity"),
    "analysis.section={ kind = 'plane', quantity = 'mode', value = 1 }": (
        "analysis.section.quantity",
        "no such quantity",
    ),
    "integrator.rtol=1e-3": ("integrator.rtol", "at least 1e-14 and at most 0.0001"),
    "figure.joint=A": ("figure.joint", "joint with clearance", "accepted: B"),
    "figure.joint=[1]": ("figure.joint", "accepted: B"),
}


@pytest.mark.parametrize(("change", "expected"), WRONG.items())
def test_each_mistake_is_named_with_its_key_and_what_is_accepted(change, expected):
    key, *words = expected
    found = problems(TEXT, change)
    assert list(found) == [key]
    assert all(word in found[key] for word in words), found[key]


WRONG_LINKAGE = {
    "mechanism.links[0].mass=-1.0": (
        "mechanism.links[0].mass",
        "got -1.0; a mass greater than 0 kg is accepted",
    ),
    "mechanism.links[0].mass='1'": ("mechanism.links[0].mass", "number"),
    "mechanism.links[1].inertia=1e-6": ("mechanism.links[1].inertia", "mass × centre²"),
    "mechanism.links[1].name=crank": ("mechanism.links[1].name", "crank"),
    "mechanism.joints[1].bearing.link=copler": ("mechanism.joints[1].bearing.link", "did you mean 'coupler'"),
    "mechanism.joints[1].journal.at=0.5": ("mechanism.joints[1].journal.at", "0.03"),
    "mechanism.joints[2].radius=0": ("mechanism.joints[2].radius", "greater than 0"),
    "mechanism.joints[2].contact.stiffness=inf": ("mechanism.joints[2].contact.stiffness", "greater than 0"),
    "mechanism.joints[2].contact.law=kelvin": ("mechanism.joints[2].contact.law", "kelvin_voigt"),
    "mechanism.drive.link=crnk": ("mechanism.drive.link", "did you mean 'crank'"),
    "mechanism.drive.kind=moter": ("mechanism.drive.kind", "did you mean 'motor'"),
    "mechanism.drive.speed=0": ("mechanism.drive.speed", "other than 0"),
}


@pytest.mark.parametrize(("change", "expected"), WRONG_LINKAGE.items())
def test_each_mistake_in_a_linkage_is_named(change, expected):
    key, word = expected
    found = problems(WRITTEN_OUT, change)
    assert key in found, found
    assert word in found[key], found[key]


def test_links_that_cannot_close_are_refused_with_their_lengths():
    found = problems(WRITTEN_OUT, "mechanism.joints[3].bearing.point=[2.0, 0]")
    message = " ".join(found.values())
    assert "close" in message
    assert "0.181" in message


def test_every_mistake_is_told_at_once():
    changes = [
        "nmae=1", "mechanism.clearence=1", "mechanism.gear_ratio=-3", "integrator.rtol=nan",
        "analysis.turns=0", "analysis.section.kind=x", "figure.jiont=1",
    ]  # fmt: skip
    assert set(problems(TEXT, *changes)) == {
        "nmae", "mechanism.clearence", "mechanism.gear_ratio", "integrator.rtol", "analysis.turns",
        "analysis.section.kind", "figure.jiont",
    }  # fmt: skip


def test_an_unknown_kind_does_not_hide_other_mistakes():
    assert set(problems(TEXT, "kind=x", "mechanism.gear_ratio=-3", "integrator.rtl=1")) == {
        "kind", "mechanism.gear_ratio", "integrator.rtl",
    }  # fmt: skip
    assert set(problems("", name="x")) == {"kind", "mechanism"}


def test_a_linkage_that_cannot_be_computed_is_refused_before_it_is():
    changes = ["mechanism.joints[2].clearance=0", "mechanism.drive.link=coupler"]
    assert "no ideal loop determines" in problems(WRITTEN_OUT, *changes)["mechanism.drive.link"]
    lengths = {"crank": 0.1, "coupler": 0.05, "rocker": 0.1}  # with 0.2 m of ground: no full turn
    changes = [f"mechanism.links[{i}].length={length}" for i, length in enumerate(lengths.values())]
    changes += ["mechanism.joints[1].journal.at=0.1", "mechanism.joints[2].journal.at=0.05"]
    changes += ["mechanism.joints[2].bearing.at=0.1", "mechanism.links[2].inertia=1e-2"]
    changes += ["mechanism.links[0].inertia=1e-2", "analysis.initial.crank_angle=3.1"]
    assert "span from" in problems(WRITTEN_OUT, *changes)["analysis.initial.crank_angle"]


def test_a_figure_may_draw_any_two_recorded_variables():
    record = "analysis.record=['contact_angle', 'tangential_velocity']"
    pair = "x = 'contact_angle', y = 'tangential_velocity'"
    validate({"name": "x"} | override(parse(WRITTEN_OUT), [record, f"figure={{ {pair} }}"]))
    alone = "figure={ kind = 'poincare_section', x = 'contact_angle' }"
    assert "are not recorded" in problems(WRITTEN_OUT, record, alone)["figure.x"]


def test_times_of_samples_need_the_length_of_the_run():
    text = TEXT.replace("turns = 2\n", "at = [0.1, 0.2]\n")
    assert "turns, or duration" in problems(text)["analysis.turns"]


def test_ways_to_sample_exclude_each_other():
    assert set(problems(TEXT, "analysis.steps=true", "analysis.samples_per_turn=9")) == {
        "analysis.samples_per_turn"
    }
    assert (
        validate({"name": "x"} | override(parse(TEXT), ["analysis.steps=true"])).analysis.samples_per_turn
        is None
    )


def test_a_figure_must_suit_the_kind_of_study():
    assert "poincare_section" in problems(WRITTEN_OUT, "figure.kind=overview")["figure.kind"]
    text = TEXT.replace("section =", "# section =")
    assert "overview" in problems(text, "figure={ kind = 'poincare_section' }")["figure.kind"]


def test_what_the_integrator_leaves_out_is_as_usual_for_the_kind():
    kind = ["kind=chaos_test", "analysis={ quantity = 'journal_x:B', turns = 200 }", "figure={}"]
    table = {"name": "x"} | override(parse(TEXT), [*kind, "integrator={ max_steps = 7 }"])
    assert dict(validate(table).integrator) == {"rtol": chaos_test.RTOL, "max_steps": 7}
    assert validate(table | {"integrator": {"rtol": 1e-6}}).integrator.rtol == 1e-6
    assert "integrator.speed" in problems(TEXT, "integrator={ speed = 1 }")


def test_as_another_kind_a_file_is_read_without_the_tables_of_its_own():
    """A drawing's tolerances say nothing to a sweep; those of the kind that has them stay."""
    path = "studies/assess/slider_crank_tolerances.toml"
    changes = ["kind=bifurcation", "vary.speed=[200.0]", "analysis={}", "figure={}"]
    assert load(path, changes).record.kind == "bifurcation"
    assert load(path, ["kind=assess", "analysis={}", "figure={}"]).record.tolerances
    with pytest.raises(InputError, match="tolerances"):
        load(path, [*changes, "tolerances.speed.normal=[1, 2]"])  # but not one that is asked for


@pytest.mark.parametrize(
    ("change", "key", "where"),
    [
        ("mechanism.turns=3", "mechanism.turns", "in the table [analysis]"),
        ("mechanism.vary.speed=[1,2]", "mechanism.vary", "as a table of its own, [vary]"),
        ("mechanism.title=a", "mechanism.title", "before all tables"),
        ("analysis.clearance=1e-4", "analysis.clearance", "in the table [mechanism]"),
        ("analysis.rtol=1e-8", "analysis.rtol", "in the table [integrator]"),
        ("gravity=0", "gravity", "in the table [mechanism]"),
    ],
)
def test_a_key_in_the_wrong_table_is_sent_to_its_own(change, key, where):
    assert problems(TEXT, change)[key].endswith(f"; there is no such key here; it is accepted {where}")
