"""Every sentence that is printed, drawn or written to a page stands in one file, to be read as a whole.

After a change that is meant, read what has changed, as somebody who does not know the program, then run
`python -m tests.display.test_sentences`.
"""

import re
from difflib import unified_diff
from pathlib import Path

import pytest

from tests.support import sentences

KNOWN = Path(__file__).with_name("sentences.txt")
PRIVATE = (  # words of no reader's language, or that clip a sentence
    r"\btold\b(?! apart)",
    r"\bnot told\b",
    r"in the other colour",
    r"\d N of at most",
    r"\bAs it was\b",
    r"\bis at it\b",
    r"\b[Oo]ver the present\b",
)


def samples():
    from tests.figures.test_pictures import PICTURES

    return {name: make for name, make in PICTURES.items() if name != "mechanism"}


@pytest.mark.long
def test_every_sentence_is_the_one_that_was_read():
    now, known = sentences.collected(samples()), KNOWN.read_text(encoding="utf-8")
    changes = "\n".join(unified_diff(known.splitlines(), now.splitlines(), "read", "now", n=0, lineterm=""))
    assert now == known, f"read these, then run python -m tests.display.test_sentences\n{changes[:5000]}"


@pytest.mark.parametrize("word", PRIVATE)
def test_no_sentence_has_a_private_word(word):
    lines = KNOWN.read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if re.search(word, without_code(line))] == []


def without_code(line):
    """A text with nothing left in the braces of its expressions."""
    while (shorter := re.sub(r"\{[^{}]+\}", "", line)) != line:
        line = shorter
    return line


def test_texts_are_found_and_docstrings_are_not():
    code = "\n".join(
        [
            "def f(x):",
            '    """Give it some."""',
            '    raise E(f"a number above {x + 1} is " "accepted")',
            '    yield Problem("key", x, "three four")',
            '    return ["one two", "word"]',
        ]
    )
    assert sentences.texts(code) == ["a number above {x + 1} is accepted", "three four", "one two"]


if __name__ == "__main__":
    KNOWN.write_text(sentences.collected(samples()), encoding="utf-8")
