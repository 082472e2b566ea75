"""Generated modules: their texts lie in the cache folder, and run only as they were written."""

from __future__ import annotations

import marshal
import sys
from importlib.abc import InspectLoader, MetaPathFinder
from importlib.machinery import ModuleSpec
from importlib.util import spec_from_file_location
from types import CodeType

from .. import place


class _Written(MetaPathFinder, InspectLoader):
    """Finds and loads modules of this package; their bytecode is kept beside them."""

    def find_spec(self, fullname: str, path: object = None, target: object = None) -> ModuleSpec | None:
        package, _, name = fullname.rpartition(".")
        if package != __name__ or place.read(f"{name}.py") is None:
            return None
        return spec_from_file_location(fullname, place.folder() / f"{name}.py", loader=self)

    def get_source(self, fullname: str) -> str:
        text = place.read(f"{fullname.rpartition('.')[2]}.py")
        if text is None:
            raise ModuleNotFoundError(f"{fullname} is not in the kernel cache", name=fullname)
        return "\n" + text.decode()  # the first line of the file is its seal

    def get_code(self, fullname: str) -> CodeType:
        name = fullname.rpartition(".")[2]
        if (kept := place.read(f"{name}.pyc")) is not None:
            return marshal.loads(kept)
        code = self.source_to_code(self.get_source(fullname), str(place.folder() / f"{name}.py"))
        place.write(f"{name}.pyc", marshal.dumps(code))
        return code

    def is_package(self, fullname: str) -> bool:
        return False


sys.meta_path.insert(0, _Written())
