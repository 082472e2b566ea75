"""Results that earlier versions wrote are opened, answered, drawn and known as their studies' own.

`versions/X/*.nc` was written by version X, once, and is never made anew: it is what users have.
"""

import re
import tomllib
from pathlib import Path

import pytest

import jointplay as jp
from jointplay import cli
from jointplay.study.file import validate
from jointplay.study.result_state import result_state

SAID = {  # numbers of the answer that each version printed when it wrote the file
    "0.1.0/bifurcation.nc": ["3", "5", "1", "2", "3.5", "4"],
    "0.1.0/response.nc": ["102", "4", "89.2"],
}
HERE = Path(__file__).with_name("versions")


@pytest.fixture(params=SAID)
def stored(request):
    return HERE / request.param


def test_every_stored_result_is_tried():
    assert sorted(path.relative_to(HERE).as_posix() for path in HERE.rglob("*.nc")) == sorted(SAID)


def test_an_older_result_gives_the_answer_that_was_printed(stored):
    dataset = jp.open(stored)
    assert dataset.attrs["source"] == f"jointplay {stored.parent.name}"
    numbers = re.findall(r"\d+(?:\.\d+)?", " ".join(jp.summary(dataset).lines))
    assert numbers == SAID[stored.relative_to(HERE).as_posix()]


def test_an_older_result_is_drawn_and_exported(stored, tmp_path, capsys):
    for verb, name in (("figure", "picture.pdf"), ("export", "table.csv"), ("cite", None)):
        out = ["--out", str(tmp_path / name)] if name else []
        assert cli.main([verb, str(stored), *out]) == 0, capsys.readouterr().err
        assert name is None or (tmp_path / name).stat().st_size > 500


def test_the_study_in_an_older_result_is_still_a_study_and_the_result_its_own(stored):
    record = validate({"name": stored.stem} | tomllib.loads(jp.open(stored).attrs["study_toml"]))
    assert result_state(record, stored) == "done"
