"""Mutated study files: accepted or refused with reasons, never a traceback."""

import tomllib
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO

from hypothesis import given, settings
from hypothesis import strategies as st
from study_samples import BENT, BENT_WRITTEN_OUT, TEXT, WRITTEN_OUT

from jointplay import cli

TEXTS = st.sampled_from([TEXT, WRITTEN_OUT, BENT, BENT_WRITTEN_OUT])
ODD = """
nan;-inf;1e400;-1;0;1e-320;99999999999999999999;0xffffffffffffffffffffffffffffffffff;true;2020-01-01
'';'\\u0000';'xxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxxx'
[];[[]];[nan];[{}, 1, 'a'];{};{ a.b.c = 1 };{ kind = 'motor' };{ kind = 'contact' };{ catalog = 'lorenz' }
"""
VALUES = st.sampled_from([value for line in ODD.split("\n") for value in line.split(";") if value])


def check(path, *words):
    """`check` a file: accepted in silence or refused with words; any exception fails the test."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()) as said:
        code = cli.main(["check", str(path), *words])
    assert code in (0, 2)
    assert bool(said.getvalue()) == (code == 2)


@settings(max_examples=150, deadline=None)
@given(text=TEXTS, data=st.data())
def test_a_text_with_characters_changed(text, data, tmp_path_factory):
    start = data.draw(st.integers(0, len(text)))
    stop = data.draw(st.integers(start, min(len(text), start + 20)))
    path = tmp_path_factory.getbasetemp() / "characters.toml"
    path.write_bytes(
        (text[:start] + data.draw(st.text(max_size=8)) + text[stop:]).encode("utf-8", "surrogatepass")
    )
    check(path)


@settings(max_examples=150, deadline=None)
@given(text=TEXTS, data=st.data())
def test_a_text_with_a_value_replaced_or_a_line_gone(text, data, tmp_path_factory):
    lines = text.splitlines()
    for _ in range(data.draw(st.integers(1, 3))):
        i = data.draw(st.integers(0, len(lines) - 1))
        key, equals, _ = lines[i].partition(" = ")
        lines[i] = f"{key} = {data.draw(VALUES)}" if equals and data.draw(st.booleans()) else ""
    path = tmp_path_factory.getbasetemp() / "values.toml"
    path.write_text("\n".join(lines))
    check(path)


@settings(max_examples=100, deadline=None)
@given(value=VALUES, data=st.data())
def test_any_key_set_to_anything_on_the_command_line(value, data, tmp_path_factory):
    text = data.draw(TEXTS)
    path = tmp_path_factory.getbasetemp() / "set.toml"
    path.write_text(text)
    change = f"{data.draw(st.sampled_from(paths(tomllib.loads(text))))}={value}"
    check(path, "--set", change)


def paths(node, before=""):
    """Every key path of a parsed text, tables included."""
    if isinstance(node, dict):
        below = [
            path for key, value in node.items() for path in paths(value, f"{before}.{key}" if before else key)
        ]
    elif isinstance(node, list):
        below = [path for i, value in enumerate(node) for path in paths(value, f"{before}[{i}]")]
    else:
        below = []
    return [before, *below] if before else below
