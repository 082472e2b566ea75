"""Pages that compute: what is in them without a browser, and what is said where they cannot."""

import re

import pytest

import jointplay as jp
from jointplay.cli import main
from jointplay.display.errors import refuse
from jointplay.study.file import validate
from jointplay.study.toml_text import override, parse
from jointplay_page import live
from tests.figures.linkage.test_mechanism import yoke
from tests.pages.live_samples import fake, linkage
from tests.pages.samples import diagram, turning


@pytest.mark.parametrize("mechanism", [linkage(), jp.catalog.slider_crank(), jp.catalog.duffing()], ids=repr)
def test_the_study_of_a_page_is_that_of_its_mechanism(mechanism):
    record = validate({"name": "page"} | parse(live.study(mechanism)))
    assert record.mechanism == mechanism


def test_the_study_of_a_page_takes_another_clearance_than_its_fit_has():
    """As its command sets it; numbers are as on the page then, where a contact's stay as they are."""
    parts = {"pin": "steel", "bush": "bronze", "length": "12 mm"}
    fitted = {"joints.B.fit": "H7/f7", "joints.B.radius": "7.5 mm", "joints.B.contact": parts}
    mechanism = jp.catalog.slider_crank().replace(**fitted)
    table = override(parse(live.study(mechanism)), ["mechanism.joints.B.clearance=0.00003"])
    (joint,) = validate({"name": "page"} | table).mechanism.clearance_joints
    assert joint.clearance == 3e-5
    assert joint.contact.stiffness == mechanism.joint("B").contact.stiffness


def stands_for(key, mechanism):
    """The numbers of a mechanism that a slider is for, by its name."""
    word, _, part = key.partition(".")
    if word == "length":
        pins = [(j.name, side) for j in mechanism.joints for side in ("journal", "bearing")]
        last = mechanism.link(part).length
        ends = [
            (n, s) for n, s in pins if (p := getattr(mechanism.joint(n), s)).link == part and p.at == last
        ]
        return [f"links.{part}.length", *(f"joints.{name}.{side}.at" for name, side in ends)]
    own = {word: f"links.{part}.{word}" for word in ("mass", "inertia", "inertia_centre")}
    own |= {"clearance": f"joints.{part}.clearance", "friction": f"joints.{part}.friction.coefficient"}
    own |= {word: f"joints.{part}.contact.{word}" for word in ("stiffness", "damping")}
    drive = {word: f"drive.{word}" for word in ("rated_torque", "efficiency")}
    return [own[word] if part else drive.get(key, key)]


@pytest.mark.parametrize(
    "mechanism",
    [
        jp.catalog.duffing(),
        pytest.param(linkage(), marks=pytest.mark.nightly),
        pytest.param(jp.catalog.slider_crank(), marks=pytest.mark.nightly),
    ],
    ids=repr,
)
def test_every_slider_stands_for_a_number_of_the_study(mechanism):
    found, why = live.live(mechanism, ["clearance", "speed", "damping"])
    assert why == ""
    for given in found["solver"]["parameters"]:
        value = (0.99 if given["key"].startswith("mass") else 1.01) * given["value"]
        table = override(
            parse(found["study"]), [f"{path}={value!r}" for path in found["paths"][given["key"]]]
        )
        changed = validate({"name": "page"} | table).mechanism
        assert changed == mechanism.replace(**dict.fromkeys(stands_for(given["key"], mechanism), value))
    wanted = {
        "clearance": "clearance.B",
        "speed": "speed",
        "damping": "damping.B" if found["scene"] else "damping",
    }
    assert found["varied"] == {name: key for name, key in wanted.items() if key in found["paths"]}


def test_without_scripts_picture_and_numbers_are_there(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(live, "solver", fake)
    (tmp_path / "own.toml").write_text("[mechanism]\ncatalog = 'chunmei2002'\nclearance = 2.9e-4\n")
    assert main(["report", str(tmp_path / "own.toml")]) == 0
    assert capsys.readouterr().out == f"written {tmp_path / 'own.html'}\n"
    html = (tmp_path / "own.html").read_text(encoding="utf-8")
    inside = html[html.index("<noscript>") : html.index("</noscript>")]
    assert 'src="data:image/png;base64,iVBOR' in inside
    assert "<th>clearance of B</th><td>290 µm</td>" in html
    assert re.search(r'<section id="live" hidden>', html)
    assert "Save the study as <code>chunmei2002_page.toml</code>" in html  # not over its own file


@pytest.mark.parametrize(
    ("mechanism", "title"),
    [
        (linkage(), "Four-bar linkage with clearance at joint B"),
        (
            jp.catalog.slider_crank(clearance={"B": 1e-4, "G": 1e-4}),
            "Slider-crank with clearance at joints B and G",
        ),
        (jp.catalog.watt(clearance=0.0), "Six-bar linkage with ideal joints"),
        (jp.catalog.duffing(), "Duffing"),
        (yoke(), "Scotch yoke with ideal joints"),
    ],
    ids=repr,
)
def test_a_page_opens_with_what_it_shows(mechanism, title):
    assert live.heading(mechanism) == title
    assert "computed in this page" in live.about(mechanism, computes=True)
    assert "computed in this page" not in live.about(mechanism, computes=False)


def test_the_title_of_a_study_is_that_of_its_page(unsolved, tmp_path):
    own = tmp_path / "own.toml"
    own.write_text("title = 'Wiper of a small car'\n[mechanism]\ncatalog = 'chunmei2002'\n")
    assert main(["report", str(own)]) == 0
    assert "<h1>Wiper of a small car</h1>" in (tmp_path / "own.html").read_text(encoding="utf-8")


@pytest.fixture
def unsolved(monkeypatch):
    """No mechanism has a solver."""

    def refused(mechanism, **_):
        raise refuse("x", "a law that the page knows is accepted", "contact.law")

    monkeypatch.setattr(live, "solver", refused)


@pytest.mark.parametrize(("result", "part"), [(turning, 'id="motion"'), (diagram, 'id="cell"')])
def test_a_report_whose_mechanism_has_no_solver_stays_one_and_says_so(unsolved, result, part, tmp_path):
    html = jp.report(result(), tmp_path / "report.html", mechanism=linkage())[0].read_text(encoding="utf-8")
    assert "This page does not compute: contact.law" in html
    assert 'id="picture0"' in html
    assert part in html
    assert 'id="live"' not in html


def test_a_mechanism_that_has_no_solver_gets_a_page_that_says_so(unsolved, tmp_path):
    (path,) = jp.report(linkage(), tmp_path / "plain.html")
    html = path.read_text(encoding="utf-8")
    assert "This page does not compute: contact.law" in html
    assert html.count("data:image/png") == 2  # seen, and without scripts
    assert 'id="live"' not in html
