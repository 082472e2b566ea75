"""All that the program says to people: texts of its code, and answers and descriptions made of them."""

import ast
import re
import warnings
from pathlib import Path

import jointplay as jp
from jointplay.display.errors import InputError
from jointplay.kinds import KINDS
from jointplay.study.file import load
from jointplay.study.new import new

ROOT = Path(__file__).parents[2]
PACKAGES = ("jointplay", "jointplay_lab", "jointplay_page")
SILENT = (  # what these write is code, and nobody reads it as a sentence
    "jointplay/solver/codegen/instructions.py",
    "jointplay/solver/codegen/lanes",
    "jointplay/solver/codegen/prebuilt.py",
    "jointplay/solver/codegen/sparse.py",
    "jointplay/solver/codegen/variants.py",
    "jointplay/solver/method/lanes/lane_instructions.py",
    "jointplay_page/script/translate.py",
    "jointplay_page/script/solver.py",
)
PLACE = re.compile(r"(outside |axes |offset )?(upper|lower|center|fraction|points)( left| right| center)?")
WORDS = re.compile(r"[^\W\d_]{2,}[,;:]? [\w{(`'\"-]|\} [a-z]{2,}")
SCRIPT = re.compile(r"""(["'`])((?:\\.|(?!\1)[^\n\\])*)\1""")


def texts(code: str) -> list[str]:
    """Texts of some source of more than one word, in their order; docstrings are for programmers."""
    tree, found = ast.parse(code), []
    alone = (node.value for node in ast.walk(tree) if isinstance(node, ast.Expr))
    apart = {id(value) for value in alone if isinstance(value, ast.Constant)}

    def visit(node):
        if id(node) in apart:
            return
        if (said := _said(node)) is None:
            for child in ast.iter_child_nodes(node):
                visit(child)
            return
        found.append(said)
        for part in ast.walk(node):
            if isinstance(part, ast.FormattedValue):
                visit(part.value)

    visit(tree)
    return [said for said in found if WORDS.search(said) and not PLACE.fullmatch(said)]


def _said(node: ast.AST) -> str | None:
    """What a text says, with the expressions in it in braces."""
    if isinstance(node, ast.Constant):
        return node.value if isinstance(node.value, str) else None
    if isinstance(node, ast.JoinedStr):
        parts = (_said(part) if isinstance(part, ast.Constant) else _blank(part) for part in node.values)
        return "".join(map(str, parts))
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add):
        left, right = _said(node.left), _said(node.right)
        return None if left is None or right is None else left + right
    return None


def _blank(part: ast.AST) -> str:
    return f"{{{ast.unparse(part.value)}}}" if isinstance(part, ast.FormattedValue) else ""


def of_the_code() -> dict[str, list[str]]:
    """Texts by the file in which they stand; of pages, what stands between and in their marks."""
    found = {}
    for path in sorted(path for name in PACKAGES for path in (ROOT / "src" / name).rglob("*.py")):
        name = path.relative_to(ROOT / "src").as_posix()
        if not name.startswith(SILENT):
            found[name] = texts(path.read_text(encoding="utf-8"))
    for path in sorted((ROOT / "src" / "jointplay_page").glob("*.html")):
        shown = re.sub(r"<(style|script).*?</\1>", "", path.read_text(encoding="utf-8"), flags=re.S)
        labels = re.findall(r'(?:aria-label|title|alt|placeholder)="([^"]*)"', shown)
        found[path.name] = [text.strip() for text in [*re.split(r"<[^>]*>", shown), *labels] if text.strip()]
    for path in sorted((ROOT / "src" / "jointplay_page").glob("*.js")):
        code = re.sub(r"^\s*(//|\*|/\*).*$", "", path.read_text(encoding="utf-8"), flags=re.M)
        found[path.name] = [said for _, said in SCRIPT.findall(code) if WORDS.search(said)]
    return found


def of_answers(samples: dict) -> dict[str, list[str]]:
    """Answers in words to results made by hand, as far as these hold what an answer needs."""
    found = {}
    for name, make in samples.items():
        try:
            found[f"answer: {name}"] = list(jp.summary(make()[0]).lines)
        except InputError:
            continue
    return found


def of_studies() -> dict[str, list[str]]:
    """Descriptions of the studies that are shipped, and of studies to begin with."""
    found = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        for path in sorted((ROOT / "studies").rglob("*.toml")):
            found[f"check: {path.stem}"] = load(path).record.summary().splitlines()
    told = set[str]()
    for kind in KINDS:
        lines = [line for line in new(kind, "own").splitlines() if "#" in line and line not in told]
        told.update(lines)
        found[f"new: {kind}"] = lines
    return found


def collected(samples: dict) -> str:
    """All of it, a heading each place."""
    places = of_the_code() | of_answers(samples) | of_studies()
    blocks = (
        "\n".join([f"== {name}", *(" ".join(said.split()) for said in dict.fromkeys(lines))])
        for name, lines in places.items()
        if lines
    )
    return "\n\n".join(blocks) + "\n"
