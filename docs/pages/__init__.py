"""Pages of the documentation that are written from the code: `write` puts them into a folder."""

from __future__ import annotations

from pathlib import Path

from pages import api, figures, gallery, keys, kinds, laws, materials, notebooks, values


def pages() -> dict[str, str]:
    """The text of every generated page by its file name."""
    own = {"keys.md": keys.page(), "catalog.md": keys.catalog_page(), "gallery.md": gallery.page()}
    own |= {"laws.md": laws.page(), "materials.md": materials.page(), "values.md": values.page()}
    return own | kinds.pages() | {"figures.md": figures.page()} | notebooks.pages() | api.pages()


def write(folder: Path) -> None:
    """Write the pages, leave those that stay the same, remove those that are no more."""
    folder.mkdir(exist_ok=True)
    texts = pages()
    for path in folder.iterdir():
        if path.name not in texts:
            path.unlink()
    for name, text in texts.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
