"""How much there is to read, held: no measure of the sources grows unless its bound here is moved on purpose.

Code lines are those without blanks, comments and docstrings. A file with one reader is imported by one other;
a repeated place is a run of six code lines, imports apart, that stands word for word in another place too.
"""

import ast
import io
import re
import tokenize
from collections import Counter, defaultdict
from functools import cache
from itertools import combinations
from pathlib import Path

import numpy as np

from tests.test_docstrings import FILES
from tests.test_layout import MODULES, imported, statements

NO_CODE = (
    tokenize.COMMENT,
    tokenize.NL,
    tokenize.NEWLINE,
    tokenize.INDENT,
    tokenize.DEDENT,
    tokenize.ENDMARKER,
)
RUN = 6  # lines that are repeated
NEAR = 250  # lines that a page's numbers may be off
BOUNDS = {
    "code lines of the suite": 43_216,
    "code lines of its analyses": 14_985,
    "code lines of all three packages": 48_497,
    "files of the suite": 315,
    "files with one reader": 58,
    "entries at the top of the suite": 10,
    "files side by side in a room": 20,
    "repeated places": 3,
}


@cache
def lines_of_code(text):
    """Numbers of the lines that hold code."""
    rows = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in NO_CODE:
            rows.update(range(token.start[0], token.end[0] + 1))
    for node in statements(text):
        if (
            isinstance(node, ast.Expr)
            and isinstance(node.value, ast.Constant)
            and isinstance(node.value.value, str)
        ):
            rows.difference_update(range(node.lineno, node.end_lineno + 1))
    return sorted(rows)


def without_imports(text):
    """The code lines of a file, imports apart, each without its indent."""
    left = set(lines_of_code(text))
    for node in statements(text):
        if isinstance(node, ast.Import | ast.ImportFrom):
            left.difference_update(range(node.lineno, node.end_lineno + 1))
    lines = text.splitlines()
    return [lines[row - 1].strip() for row in sorted(left)]


def repeated(texts):
    """Pairs of places that share runs of lines, each pair of files and distance once."""
    places = defaultdict(list)
    for name, text in texts.items():
        lines = without_imports(text)
        for begin in range(len(lines) - RUN + 1):
            run = tuple(lines[begin : begin + RUN])
            if sum(len(line) > 1 for line in run) == RUN:  # brackets alone say nothing
                places[run].append((name, begin))
    found = set()
    for each in places.values():
        found |= {(one, other, at - begin) for (one, begin), (other, at) in combinations(each, 2)}
    return found


def readers():
    """Files that import a file, for each of the packages."""
    found = defaultdict(set)
    for module, name in MODULES.items():
        for other in {*imported(module, name)} - {name}:
            found[other].add(name)
    return found


@cache
def measured():
    texts = {name: path.read_text(encoding="utf-8") for name, path in FILES.items()}
    code = {name: len(lines_of_code(text)) for name, text in texts.items()}
    suite = [name for name in FILES if name.split(".")[0] == "jointplay"]
    top = Path(FILES["jointplay.__init__"]).parent
    rooms = Counter(path.parent for path in FILES.values())
    known = readers()
    single = [name for name in FILES if not name.endswith("__init__") and len(known[name]) == 1]
    return {
        "code lines of the suite": sum(code[name] for name in suite),
        "code lines of its analyses": sum(
            code[name] for name in suite if name.startswith("jointplay.analysis.")
        ),
        "code lines of all three packages": sum(code.values()),
        "files of the suite": len(suite),
        "files with one reader": len(single),
        "entries at the top of the suite": sum(
            entry.name not in ("__pycache__", "py.typed", "__init__.pyi") for entry in top.iterdir()
        ),
        "files side by side in a room": max(rooms.values()),
        "repeated places": len(repeated(texts)),
    }


def test_there_is_no_more_to_read_than_was_agreed():
    measures = measured()
    beyond = {name: found for name, found in measures.items() if found > BOUNDS[name]}
    for name, found in measures.items():
        print(f"{name}: {found} (at most {BOUNDS[name]})")
    assert beyond == {}


def test_the_page_for_developers_says_how_much_it_is():
    page = (Path(__file__).parents[1] / "docs" / "developers.md").read_text(encoding="utf-8")
    (told,) = re.findall(r": (\d+ \d+) lines.*?, (\d+ \d+) of them.*?and (\d+ \d+) in all", page, re.S)
    found = [
        measured()[f"code lines of {what}"] for what in ("the suite", "its analyses", "all three packages")
    ]
    assert np.abs(np.subtract([int(each.replace(" ", "")) for each in told], found)).max() <= NEAR


def test_what_is_counted_is_code():
    text = '"""Head.\n\nMore."""\n\nimport os\n\n\ndef f():  # so\n    """It."""\n    # why\n    return os\n'
    assert lines_of_code(text) == [5, 8, 11]
    assert without_imports(text) == ["def f():  # so", "return os"]
    block = "".join(f"    {letter}{letter} = {letter}({k})\n" for k, letter in enumerate("abcdefg"))
    assert len(repeated({"one": f"def f():\n{block}", "other": f"if True:\n{block}"})) == 1
    assert not repeated({"one": f"def f():\n{block}", "other": block.replace("d(", "e(").replace("    ", "")})
