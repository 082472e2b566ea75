"""Pages that compute: what is in them without a browser, and what is said where they cannot."""

import re

import pytest

import jointplay as jp
from jointplay.cli import main
from jointplay.errors import refuse
from jointplay.pages import live
from jointplay.study.file import validate
from jointplay.study.toml_text import override, parse
from tests.pages.live_samples import fake, linkage


@pytest.mark.parametrize("mechanism", [linkage(), jp.catalog.slider_crank(), jp.catalog.duffing()], ids=repr)
def test_the_study_of_a_page_is_that_of_its_mechanism(mechanism):
    record = validate({"name": "page"} | parse(live.study(mechanism)))
    assert record.mechanism == mechanism


@pytest.mark.parametrize(
    "mechanism",
    [
        jp.catalog.duffing(),
        pytest.param(linkage(), marks=pytest.mark.long),
        pytest.param(jp.catalog.slider_crank(), marks=pytest.mark.long),
    ],
    ids=repr,
)
def test_every_slider_stands_for_a_number_of_the_study(mechanism):
    found, why = live.live(mechanism, ["clearance", "speed", "damping"])
    assert why == ""
    for given in found["solver"]["parameters"]:
        value = 1.01 * given["value"]
        table = override(parse(found["study"]), [f"{found['paths'][given['key']]}={value!r}"])
        changed = validate({"name": "page"} | table).mechanism
        word, _, joint = given["key"].partition(".")
        own = {"clearance": f"joints.{joint}.clearance", "stiffness": f"joints.{joint}.contact.stiffness"}
        own |= {"damping": f"joints.{joint}.contact.damping"} if joint else {}
        own["friction"] = f"joints.{joint}.friction.coefficient"
        assert changed == mechanism.replace(**{own.get(word, given["key"]): value})
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


def test_a_mechanism_that_has_no_solver_gets_a_page_that_says_so(monkeypatch, tmp_path):
    def unsolved(mechanism, **_):
        raise refuse("x", "a law that the page knows is accepted", "contact.law")

    monkeypatch.setattr(live, "solver", unsolved)
    (path,) = jp.report(linkage(), tmp_path / "plain.html")
    html = path.read_text(encoding="utf-8")
    assert "This page does not compute: contact.law" in html
    assert html.count("data:image/png") == 2  # seen, and without scripts
    assert 'id="live"' not in html
