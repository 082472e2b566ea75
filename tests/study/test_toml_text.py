"""Text of study files: reading, parsing, and changes from the command line."""

import pytest

from jointplay.display.errors import InputError
from jointplay.solver.mechanism import catalog
from jointplay.study import toml_text
from jointplay.study.models import build_mechanism


def keys(error):
    return [problem.key for problem in error.value.problems]


@pytest.mark.parametrize(
    ("change", "path", "value"),
    [
        ("a=1", ["a"], 1),
        ("t.e=2.9e-5", ["t", "e"], 2.9e-5),
        ("t.new.deep=true", ["t", "new", "deep"], True),
        ("t.name=crank", ["t", "name"], "crank"),
        ("t.name='crank'", ["t", "name"], "crank"),
        ("t.e={ B = 1e-5, C = 2e-5 }", ["t", "e"], {"B": 1e-5, "C": 2e-5}),
        ("list[1].m = 3", ["list", 1, "m"], 3),
        ('t."joints.B.clearance"=["20 um"]', ["t", "joints.B.clearance"], ["20 um"]),
        ("t.'a.b + c.d'.stop = 3", ["t", "a.b + c.d", "stop"], 3),
        ("t.v=[1, 2]", ["t", "v"], [1, 2]),
        ("t.v=a=b", ["t", "v"], "a=b"),
        ("t.v=", ["t", "v"], ""),
        ("t.v=1\nother = 2", ["t", "v"], "1\nother = 2"),
    ],
)
def test_a_change_is_read_as_toml_or_else_as_text(change, path, value):
    table = {"a": 0, "t": {"e": 0.0}, "list": [{"m": 1}, {"m": 2}]}
    changed = toml_text.override(table, [change])
    for step in path:
        changed = changed[step]
    assert changed == value
    assert table == {"a": 0, "t": {"e": 0.0}, "list": [{"m": 1}, {"m": 2}]}


@pytest.mark.parametrize(
    "change",
    [*("novalue", "=1", "a..b=1", "a.=1", "[0].m=1", "a.b=1", "list[7].m=1", "list.m=1"),
     *('t."a=1', 't."a"b=1', "t=\udcff", "t=" + chr(0xD800))],
)  # fmt: skip
def test_a_change_that_does_not_fit_is_refused(change):
    with pytest.raises(InputError) as error:
        toml_text.override({"a": 0, "list": []}, [change])
    assert keys(error) == ["--set"]


@pytest.mark.parametrize("written_out", [True, False])
def test_a_part_is_found_by_its_name_and_by_its_number(written_out):
    mechanism = catalog.chunmei2002()
    table = (
        mechanism.model_dump(mode="json", exclude_none=True) if written_out else {"catalog": "chunmei2002"}
    )
    table = {"mechanism": table}
    for path in ("joints.C.clearance", "joints[3].clearance"):
        changed = toml_text.override(table, [f"mechanism.{path}=1e-4", "mechanism.links.crank.mass=0.4"])
        found = build_mechanism(changed["mechanism"])
        assert found == mechanism.replace(**{path: 1e-4, "links.crank.mass": 0.4})
        assert [joint.clearance for joint in found.joints] == [0, 0, 2.9e-5, 1e-4]


@pytest.mark.parametrize("written_out", [True, False])
@pytest.mark.parametrize(
    ("change", "near"),
    [("joints.CC.clearance=0", "C"), ("links.cranc.mass=1", "crank"), ("joints.C.clearence=0", "clearance")],
)
def test_the_nearest_part_is_suggested(written_out, change, near):
    table = catalog.chunmei2002().model_dump(mode="json", exclude_none=True)
    table = {"mechanism": table if written_out else {"catalog": "chunmei2002"}}
    with pytest.raises(InputError, match=f"did you mean '{near}'"):
        build_mechanism(toml_text.override(table, [f"mechanism.{change}"])["mechanism"])


def test_every_wrong_change_is_named():
    with pytest.raises(InputError) as error:
        toml_text.override({}, ["a", "b=1", "c"])
    assert [problem.given for problem in error.value.problems] == ["a", "c"]


def test_a_syntax_error_names_its_line():
    with pytest.raises(InputError) as error:
        toml_text.parse("kind = 'response'\nturns == 3\n")
    assert "line 2" in str(error.value)
    assert "turns == 3" in str(error.value)


def test_an_error_at_the_end_of_the_text_shows_its_first_line():
    with pytest.raises(InputError) as error:
        toml_text.parse("kind = 'response'\nlist = [1,\n2\n")
    assert [problem.given for problem in error.value.problems] == ["kind = 'response'"]


@pytest.mark.parametrize(
    "text", ["a = " + "[" * 5000, "x = 2024-99-99", "a = 1\na = 2", "\0", "a = " + "9" * 5000]
)
def test_hostile_text_is_refused(text):
    with pytest.raises(InputError):
        toml_text.parse(text)


def test_endless_nesting_and_numbers_out_of_all_size_are_refused_with_their_place():
    deep = toml_text.parse(".".join("a" * 200) + " = 1")
    huge = toml_text.parse("[t]\nn = 0x" + "f" * 400)
    tiny = toml_text.parse("[t]\nn = [0.0, -1e-320, inf, nan]")
    assert toml_text.implausible(deep)[0].key.startswith("a.a.a")
    (problem,) = toml_text.implausible(huge)
    expected = "a number between 1e-50 and 1e50 in size is accepted"
    assert (problem.key, problem.expected) == ("t.n", expected)
    assert [problem.key for problem in toml_text.implausible(tiny)] == ["t.n[1]"]
    assert toml_text.implausible({"t": {"n": [1, 2.0, "x", True, 0, -1e-50]}}) == []


def test_what_is_no_readable_text_is_refused(tmp_path):
    latin = tmp_path / "latin.toml"
    latin.write_bytes("title = 'Kurbel für'".encode("latin-1"))
    for path in (latin, tmp_path, tmp_path / "none.toml", "nul\0byte"):
        with pytest.raises(InputError) as error:
            toml_text.read_text(path)
        assert keys(error) == ["study file"]


def test_windows_text_is_read(tmp_path):
    path = tmp_path / "windows.toml"
    path.write_bytes(b"\xef\xbb\xbfkind = 'response'\r\n")
    assert toml_text.parse(toml_text.read_text(path)) == {"kind": "response"}
