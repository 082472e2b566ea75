"""The picture of the rooms shows the imports that there are."""

import re
from html import unescape

from docs import house


def test_the_picture_of_the_rooms_shows_today_s_imports():
    written = re.search(r"<dc:description>(.*?)</dc:description>", house.PICTURE.read_text(encoding="utf-8"))
    assert unescape(written[1]) == house.said(house.arrows()), "python docs/house.py"


def test_rooms_stand_above_what_they_import():
    pairs = house.arrows()
    level = house.floors(pairs)
    assert all(level[one] > level[other] for one, other in pairs)
    assert {("solver/motion", "solver/method"), ("analysis", "solver/motion"), ("cli", "study")} <= pairs
    assert house.needed({("a", "b"), ("b", "c"), ("a", "c")}) == {("a", "b"), ("b", "c")}
