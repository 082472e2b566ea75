"""What docstrings and comments say of other files is where they say."""

import io
import re
import tokenize
from pathlib import Path

import jointplay

PLACE = Path(jointplay.__file__).parents[1]
FILES = {
    ".".join(path.relative_to(PLACE).with_suffix("").parts): path for path in PLACE.glob("jointplay*/**/*.py")
}
HOMES = ("jointplay.solver.", "jointplay.", "")  # which a reference leaves out
ROOMS = sorted(
    {name.removeprefix(home).split(".")[0] for name in FILES for home in HOMES if "." in name} - {"jointplay"}
)
REFERENCE = re.compile(
    rf"(?<![\w.`/\[])(?:jointplay\.)?((?:{'|'.join(ROOMS)})(?:\.(?!(?:js|html)\b)[A-Za-z_]\w*)+)(?![\[\w])"
)


def references(text):
    """Dotted names in comments and docstrings, where `` ``…`` `` quotes what a user writes."""
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type == tokenize.COMMENT or (token.type == tokenize.STRING and '"""' in token.string):
            yield from REFERENCE.findall(re.sub("``.*?``", "", token.string).replace("`", " "))


def exists(name):
    """Whether it is a file or folder of the package, or stands in one."""
    parts = name.split(".")
    for k in range(len(parts), 0, -1):
        for home in HOMES:
            stem = home + ".".join(parts[:k])
            file = FILES.get(stem) or FILES.get(f"{stem}.__init__")
            if file:
                return k == len(parts) or bool(
                    re.search(rf"\b{parts[k]}\b", file.read_text(encoding="utf-8"))
                )
    return False


def test_no_reference_is_dead():
    found = {file: set(references(path.read_text(encoding="utf-8"))) for file, path in FILES.items()}
    assert sum(map(len, found.values())) > 50
    dead = {file: {name for name in names if not exists(name)} for file, names in found.items()}
    assert not {file: names for file, names in dead.items() if names}
