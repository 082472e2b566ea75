"""References of a study: the right ones for each part, each once and stated once, as text and as BibTeX."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from jointplay.cli import main
from jointplay.kinds import KINDS
from jointplay.solver.equations.friction import FRICTIONS
from jointplay.solver.equations.laws import LAWS
from jointplay.solver.mechanism import catalog
from jointplay.study import cite
from jointplay.study.file import load, validate
from tests.support.study_samples import TEXT, WRITTEN_OUT

ROOT = Path(__file__).parents[2]
ALWAYS = {"jointplay", "hairer_wanner1996", "hairer_wanner1999", "gustafsson1994", "farouki2012"}
STICKING = {"filippov1988", "leine_nijmeijer2004"}


def cited(kind, mechanism, **analysis):
    study = {"kind": kind, "name": "a", "mechanism": mechanism, "analysis": analysis}
    return (
        set(cite.cited(validate(study | ({"vary": {"gap": [1, 2]}} if kind == "bifurcation" else {}))))
        - ALWAYS
    )


PAIR = {"catalog": "impact_pair", "gap": 3.0, "restitution": 0.8}


@pytest.mark.parametrize(
    ("kind", "mechanism", "analysis", "keys"),
    [
        (
            "section",
            {"catalog": "lorenz"},
            {"turns": 1, "section": {"kind": "plane", "quantity": "z", "value": 27}},
            {"lorenz1963"},
        ),
        (
            "response",
            PAIR,
            {"turns": 1},
            {"dubowsky_freudenstein1971", "budd_dux1994", "nordmark_piiroinen2009"},
        ),
        (
            "spectrum",
            {"catalog": "duffing"},
            {"turns": 1},
            {"holmes1979", "welch1967", "percival_walden1993"},
        ),
        ("response", {"catalog": "chunmei2002"}, {"turns": 1}, {"chunmei2002"} | STICKING),
        (
            "lyapunov",
            {"catalog": "chunmei2002"},
            {"turns": 1},
            {"chunmei2002", "benettin1980", "flyvbjerg_petersen1989", "kong2023"} | STICKING,
        ),
    ],
)
def test_a_study_cites_what_it_uses_and_nothing_else(kind, mechanism, analysis, keys):
    assert cited(kind, mechanism, **analysis) == keys


def test_exponents_of_a_diagram_rest_on_more():
    more = cited("bifurcation", PAIR, exponents=1) - cited("bifurcation", PAIR)
    assert more == {"leine_nijmeijer2004", "kong2023", "benettin1980", "flyvbjerg_petersen1989"}


def test_a_mechanism_of_ones_own_cites_no_paper_for_itself(tmp_path):
    path = tmp_path / "own.toml"
    path.write_text(WRITTEN_OUT)
    reasons = cite.cited(load(path).record)["chunmei2002"]
    assert reasons == ["geometry of joints with play", "contact law kelvin_voigt"]


def test_data_of_a_drawing_cite_where_they_come_from():
    parts = {"pin": "steel", "bush": "bronze", "length": 0.012}
    drawn = {"catalog": "slider_crank", "joints": {"B": {"fit": "H7/f7", "contact": parts}}}
    found = {"iso286_2010", "johnson1985", "dubowsky_freudenstein1971", "liu2007", "persson2007"}
    assert (
        cited("response", drawn, turns=1) - cited("response", {"catalog": "slider_crank"}, turns=1) >= found
    )


def test_everything_there_is_has_its_references_and_these_exist():
    uses, references = cite.table("uses"), cite.table("references")
    rows = [*LAWS.values(), *FRICTIONS.values(), *KINDS.values(), *catalog.NAMES.values()]
    assert [row for row in rows if row.references is None] == []
    used = {key for keys in (*uses.values(), *(row.references for row in rows)) for key in keys}
    assert used == set(references)  # each reference is for something
    assert all({"type", "author", "year"} <= set(entry) for entry in references.values())
    assert all(str(entry["year"]) in key for key, entry in references.items())


def test_what_is_not_stated_is_said(monkeypatch):
    study = {
        "kind": "response",
        "name": "a",
        "mechanism": {"catalog": "chunmei2002"},
        "analysis": {"turns": 1},
    }
    monkeypatch.setitem(LAWS, "kelvin_voigt", replace(LAWS["kelvin_voigt"], references=None))
    record = validate(study)
    assert cite.as_text(record).endswith("\nnot stated: what to cite for contact law kelvin_voigt")
    assert cite.as_bibtex(record).endswith("\n% not stated: what to cite for contact law kelvin_voigt")
    own = replace(LAWS["kelvin_voigt"], references=("A. Author, Her own law, 2026",))
    monkeypatch.setitem(LAWS, "kelvin_voigt", own)
    assert "A. Author, Her own law, 2026\n    for contact law kelvin_voigt" in cite.as_text(record)
    written = "@misc{A_Author_Her_own_law_2026,\n  note = {A. Author, Her own law, 2026},\n}"
    assert written in cite.as_bibtex(record)


def test_the_verb_prints_text_and_bibtex(tmp_path, capsys):
    path = tmp_path / "a.toml"
    path.write_text(TEXT)
    assert main(["cite", str(path)]) == 0
    said = capsys.readouterr().out
    assert (
        "E. Hairer, G. Wanner, Stiff differential equations solved by Radau methods, "
        "Journal of Computational and Applied Mathematics, 111:93-111, 1999\n    for the integrator\n"
    ) in said
    assert main(["cite", str(path), "--bibtex"]) == 0
    entries = capsys.readouterr().out.split("\n\n")
    assert len(entries) == said.count("    for ")
    assert all(
        re.fullmatch(r"@(misc|article|book)\{\w+,\n(  [a-z]+ = \{.+\},\n)+\}\n?", each) for each in entries
    )
    assert "author = {E. Hairer and G. Wanner}" in entries[1]
    assert "pages = {93--111}" in entries[2]
    with pytest.raises(SystemExit):
        main(["cite", "--help"])
    assert "example: jointplay cite studies/quickstart.toml --bibtex" in capsys.readouterr().out


def test_a_result_cites_as_its_study(capsys):
    assert main(["cite", str(ROOT / "results" / "paper" / "fig12c.nc")]) == 0
    result = capsys.readouterr().out
    assert main(["cite", str(ROOT / "studies" / "paper" / "fig12c.toml")]) == 0
    assert capsys.readouterr().out == result


def test_the_program_is_cited_as_its_file_says():
    said = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f'title: "{cite.PROGRAM["title"]}"' in said
    assert f"- name: {cite.PROGRAM['author']}" in said


def test_each_part_that_rests_on_a_reference_is_named():
    study = {
        "kind": "lyapunov",
        "name": "a",
        "mechanism": {"catalog": "chunmei2002"},
        "analysis": {"turns": 1},
    }
    reasons = cite.cited(validate(study))
    assert reasons["filippov1988"] == ["modes of contact", "friction law coulomb"]
    assert "kind lyapunov" in reasons["benettin1980"]
    assert "kind lyapunov" in reasons["flyvbjerg_petersen1989"]
