"""Runs of the translated solver in Node."""

import json
import shutil
import subprocess

import pytest

NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="no Node here: apt-get install nodejs")
PLAIN = """
const plain = (value) => {
  if (ArrayBuffer.isView(value)) return Array.from(value, plain);
  if (Array.isArray(value)) return value.map(plain);
  if (typeof value === "number" && !Number.isFinite(value)) return String(value);
  if (value === null || typeof value !== "object") return value;
  return Object.fromEntries(Object.entries(value).map(([name, each]) => [name, plain(each)]));
};
const data = JSON.parse(require("fs").readFileSync(0, "utf8"));
"""


def ran(text, data, program, folder):
    """What a program gives back (numbers that are not finite as words) after a JavaScript text."""
    path = folder / "program.js"
    path.write_text(f"{text}\n{PLAIN}\nconsole.log(JSON.stringify(plain((() => {{ {program} }})())));\n")
    command = [NODE, "--max-old-space-size=512", str(path)]
    given = json.dumps(data, allow_nan=False)
    done = subprocess.run(command, input=given, capture_output=True, text=True, timeout=240)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)
