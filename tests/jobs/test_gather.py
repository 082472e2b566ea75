"""Answers of cells: names and attributes are shared and safe, values keep their bits, any order will do."""

import pickle
import random
import weakref

import numpy as np
import pytest
import xarray as xr

from jointplay.analysis.sweeps import gather
from jointplay.display.errors import InputError
from jointplay.jobs import values
from jointplay.jobs.columns import packed, thawed, unpacked
from jointplay.study.execute import journal_of
from jointplay.study.run import computed, first_work
from jointplay.study.vary_table import points
from tests.support.sweep_samples import loaded, ran

STUDY = """\
kind = "section"
name = "cells"
[mechanism]
catalog = "impact_pair"
gap = 3.0
restitution = 0.7
[vary]
gap = [1.0, 3.0, 3.05]
[analysis]
turns = 30
section = { kind = "contact" }
"""


def answer(size=3, **attrs):
    """A dataset with a number, a text and values over a labelled and over a counted dimension."""
    told = {"units": "m", "flag_values": np.arange(2, dtype=np.int8), **attrs}
    values = np.random.default_rng(size).normal(size=(size, 2))
    values[0] = -0.0, np.uint64(0x7FF8000000000123).view(np.float64)
    return xr.Dataset(
        {
            "x": (("turn", "link"), values, told),
            "n": ((), np.int16(size)),
            "word": ((), "äb"),
        },
        {"turn": ("turn", np.arange(size)), "link": ["a", "b"]},
        {"kind": "section"},
    )


def test_equal_layouts_are_one_object_also_after_a_pickle():
    one, other, longer = (gather.plain(answer(size)) for size in (3, 3, 5))
    assert one.layout is other.layout is longer.layout
    assert pickle.loads(pickle.dumps(one)).layout is one.layout
    assert len(pickle.dumps([one.layout] * 100)) < 2 * len(pickle.dumps([one.layout]))


@pytest.mark.parametrize(
    "attrs",
    [{"a": 1}, {"a": 1.0}, {"a": True}, {"a": "1"}, {"a": -0.0}, {"a": 0.0}, {"a": np.int8(1)},
     {"flag_values": np.arange(2)}, {"a": 1, "b": 1}, {"b": 1, "a": 1}],
)  # fmt: skip
def test_layouts_differ_where_attributes_differ_in_type_or_bits(attrs):
    others = [{}, {"a": 1}, {"a": 1.0}, {"a": True}, {"a": -0.0}, {"a": 0.0}, {"b": 1, "a": 1}]
    mine = gather.plain(answer(**attrs)).layout
    found = [gather.plain(answer(**other)).layout is mine for other in others]
    assert found == [_told(other) == _told(attrs) for other in others]


def _told(attrs):
    return [(key, type(value), repr(value)) for key, value in attrs.items()]


def test_a_layout_cannot_be_changed_by_a_cell_that_has_it():
    dataset = answer()
    layout = gather.plain(dataset).layout
    dataset["x"].attrs["units"] = "s"
    dataset["x"].attrs["flag_values"][0] = 9
    (field,) = (field for field in layout.fields if field.name == "x")
    assert (field.attrs["units"], field.attrs["flag_values"].tolist()) == ("m", [0, 1])
    with pytest.raises(TypeError):
        field.attrs["units"] = "s"
    with pytest.raises(ValueError, match="read-only"):
        field.attrs["flag_values"][0] = 9
    copy = thawed(field.attrs)
    copy["flag_values"][0] = 9
    assert field.attrs["flag_values"][0] == 0


def test_packed_answers_come_back_bit_for_bit():
    lost = {"status": 3, "trouble": "no"}
    given = [{"status": 0, "dataset": gather.plain(answer(size))} for size in (3, 5, 3, 4, 5)]
    given[2:2] = [lost, {"status": 0, "points": [1, 2], "dataset": "of another kind"}]
    found = unpacked(*values.read(values.written(packed(given))))
    for one, other in zip(given, found, strict=True):
        assert one.keys() == other.keys()
        if "dataset" not in one or isinstance(one["dataset"], str):
            assert one == other
            continue
        assert one["dataset"].layout is other["dataset"].layout
        for before, after in zip(one["dataset"].values, other["dataset"].values, strict=True):
            assert isinstance(after, np.ndarray)
            assert (before.dtype, before.shape) == (after.dtype, after.shape)
            assert before.tobytes() == after.tobytes()


def test_the_whole_does_not_depend_on_the_order_of_the_answers(tmp_path):
    study = loaded(STUDY)
    whole = ran(study, tmp_path)
    assert len(set(whole["n_turn"].values.tolist())) > 1
    work, journal = first_work(study.record), journal_of(tmp_path, "cells")
    answers = list(journal.answers(cell.key for cell in work.jobs))
    for seed in range(4):
        random.Random(seed).shuffle(answers)
        found = computed(study.record, lambda _: lambda: answers)
        assert found.assign_attrs(whole.attrs).identical(whole)
        assert list(found.variables) == list(whole.variables)
        found["time"].attrs["units"] = "mine"
        found["cell_status"].attrs["flag_values"][0] = 9
    with pytest.raises(OSError, match="1 cells"):
        computed(study.record, lambda _: lambda: answers[1:])


def test_answers_are_not_held_while_they_are_put_together():
    record, arrays, alive = loaded(STUDY, "vary.gap={start=1.0, stop=3.0, num=60}").record, [], []
    keys = [key for job in first_work(record).jobs for key in job.keys]

    def read():
        for key in keys:
            made = gather.plain(answer())
            arrays.append(weakref.ref(made.values[0]))
            alive.append(sum(each() is not None for each in arrays))
            yield key, {"status": 0, "dataset": made}

    gather.dataset("section", points(record.mechanism, record.vary), keys, read)
    assert len(alive) == 120
    assert max(alive) <= 2


def test_a_number_beside_the_dimensions_is_the_wholes_only_where_all_cells_have_it():
    record = loaded(STUDY).record
    keys = [key for job in first_work(record).jobs for key in job.keys]
    told = [answer().assign_coords(own=float(i), shared=1.0) for i in range(len(keys))]

    def read():
        return (
            (key, {"status": 0, "dataset": gather.plain(one)}) for key, one in zip(keys, told, strict=True)
        )

    whole = gather.dataset("section", points(record.mechanism, record.vary), keys, read)
    assert whole["cell_own"].values.tolist() == [0.0, 1.0, 2.0]
    assert whole["shared"].values.tolist() == 1.0


def test_columns_that_are_not_a_layouts_values_are_refused():
    rest, ((places, layout, columns),) = packed([{"status": 0, "dataset": gather.plain(answer())}] * 2)
    longer = [np.concatenate([each, each], axis=1) if each.ndim == 2 else each for each in columns]
    for bad in (columns[:-1], [each[:1] for each in columns], [each[..., None] for each in columns], longer):
        with pytest.raises(ValueError, match=r"no values of|zip"):
            unpacked(rest, [(places, layout, bad)])
    assert unpacked(rest, [(places, layout, columns)])


def test_a_cell_that_is_named_by_a_text_cannot_be_taken_by_a_number():
    swept = xr.Dataset({"status": ("law", [0, 0])}, {"law": ["hertz", "johnson"]}, {"swept": "law"})
    with pytest.raises(InputError, match="a number for each of law, of those in the result, is accepted"):
        gather.cell(swept, law=1.0)
