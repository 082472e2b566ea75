"""One number, one word and one sentence for each code, and kernels take the same numbers."""

import re
from pathlib import Path

import pytest

import jointplay
from jointplay.solver.method import codes, control, memory, modes

RENAMED = {"RESTING": codes.Mode.REST, "ENTRY": codes.Event.CONTACT}


@pytest.mark.parametrize("code", codes.Code.__subclasses__())
def test_codes_count_from_zero_and_words_are_found_by_number(code):
    assert code.numbers() == tuple(range(len(code)))
    assert all(code.words()[member] == member.word for member in code)
    assert {type(number) for number in code.numbers()} == {int}


@pytest.mark.parametrize(
    ("module", "code", "names"),
    [
        (modes, codes.Mode, "FREE RELEASED SLIP_POSITIVE SLIP_NEGATIVE STICK CONTACT RESTING"),
        (modes, codes.Event, "ENTRY SEPARATION REOPENING SLIP_REVERSAL STICK_ONSET SLIP_ONSET IMPACT REST"),
        (control, codes.Status, "OK DIVERGED STEP_LIMIT CHATTER NOT_CONVERGED"),
    ],
)
def test_kernels_take_the_codes_as_plain_integers(module, code, names):
    for name in names.split():
        number = getattr(module, name)
        assert type(number) is int
        assert number == (RENAMED.get(name) if name in RENAMED else code[name])


def test_log_rows_are_tagged_by_their_codes():
    for row in codes.Row:
        assert getattr(memory, f"{row.name}_ROW") == row


def test_every_status_but_ok_says_what_to_try():
    for each in codes.Status:
        assert re.fullmatch("[a-z].{9,}[a-z]", each.meaning)
        assert each is codes.Status.OK or re.fullmatch("[a-z].{9,}[a-z]", each.remedy)


def test_no_other_file_lists_them():
    lists = r"(slip_positive\W+slip_negative|stick_onset\W+slip_onset|step_limit\W+chatter)[\"']"
    files = Path(jointplay.__file__).parent.rglob("*.py")
    assert [path for path in files if re.search(lists, path.read_text(encoding="utf-8"))] == []
