"""What a page that computes costs, in headless Chromium: opening, frames, a rectangle of a diagram, memory.

Best of several tries, since other work on the machine only slows them; beside them what does not depend on
it: CPU time. `python -m tests.benchmarks.suite.pages [MINUTES]`.
"""

import os
import shutil
import sys
import tempfile
import time
from contextlib import contextmanager, suppress
from pathlib import Path

import jointplay as jp
from tests.pages.browsing import opened, until
from tests.pages.conftest import FLAGS

TRIES, SECONDS, MINUTES = 3, 6, 10
VALUES, TURNS, KEPT = 100, 200, 64
OPENED = """
const seen = new MutationObserver(() => {
  const found = document.getElementById('live');
  if (found && found.dataset.ready && !window.openedAfter) window.openedAfter = performance.now();
});
seen.observe(document, { attributes: true, subtree: true, childList: true });
"""
DRAGGED = """
const slider = document.getElementById('live-clearance.B'), until = performance.now() + 1000 * arguments[0];
const done = arguments[1];
let frames = 0;
const frame = (now) => {
  slider.value = 500 + 200 * Math.sin(now / 700);
  slider.dispatchEvent(new Event('input'));
  frames += 1;
  if (now < until) requestAnimationFrame(frame); else done(frames);
};
requestAnimationFrame(frame);
"""
RECTANGLE = """
document.getElementById('scan-count').value = arguments[0];
document.getElementById('scan-transient').value = arguments[1];
document.getElementById('scan-run').click();
"""


@contextmanager
def browser():
    """A headless Chromium with a measured page's observer."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        for flag in (*FLAGS.split(), f"--user-data-dir={profile}", "--js-flags=--expose-gc"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        service = webdriver.ChromeService(shutil.which("chromedriver"))
        made = webdriver.Chrome(options=options, service=service)
        made.set_script_timeout(120)
        made.execute_cdp_cmd("Page.addScriptToEvaluateOnNewDocument", {"source": OPENED})
        try:
            yield made
        finally:
            made.quit()


def of_processes(made):
    """CPU seconds that a browser's processes have used, and the memory that they have for themselves, MB."""
    fields, members = {}, {made.service.process.pid}
    for path in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError):  # it has ended
            fields[int(path.parent.name)] = path.read_text().rpartition(")")[2].split()
    while grown := {k for k, each in fields.items() if int(each[1]) in members} - members:
        members |= grown
    ticks = sum(int(fields[k][11]) + int(fields[k][12]) for k in members)
    pages = [Path(f"/proc/{k}/statm").read_text().split() for k in members]
    private = sum(int(each[1]) - int(each[2]) for each in pages)
    return ticks / os.sysconf("SC_CLK_TCK"), private * os.sysconf("SC_PAGE_SIZE") / 1e6


def opening(made, page):
    """Seconds from the navigation until the sliders can be moved."""
    opened(made, page)
    return until(made, "return window.openedAfter") / 1e3


def frames(made):
    """Frames a second while a slider moves, and the CPU time of all that one takes, ms."""
    before, _ = of_processes(made)
    count = made.execute_async_script(DRAGGED, SECONDS)
    return count / SECONDS, 1e3 * (of_processes(made)[0] - before) / count


def rectangle(made):
    """Seconds that a diagram over the clearance takes, and CPU seconds of all processes."""
    before, _ = of_processes(made)
    made.execute_script(RECTANGLE, VALUES, TURNS - KEPT)
    text = "document.getElementById('scan-said').textContent"
    until(made, f"return {text}.startsWith('{VALUES} of {VALUES}')", 300)
    said = made.execute_script(f"return {text}")
    return float(said.split(",")[1].split()[0]), of_processes(made)[0] - before


def memory(made):
    """Heap of the page's own thread after a collection, and all that the processes have, MB."""
    heap = made.execute_script("gc(); return performance.memory.usedJSHeapSize") / 1e6
    return heap, of_processes(made)[1]


def measured(minutes=MINUTES):
    """All of it, by name."""
    mechanism = jp.catalog.chunmei2002(clearance=2.9e-4, gear_ratio=3.0)
    with tempfile.TemporaryDirectory() as folder, browser() as made:
        began = time.process_time()
        (page,) = jp.report(mechanism, Path(folder) / "page.html")
        rows = {"making": [time.process_time() - began], "size": [page.stat().st_size / 1e6]}
        rows["opening"] = [min(opening(made, page) for _ in range(TRIES))]
        tries = [frames(made) for _ in range(TRIES)]
        rows["frames"] = [max(rate for rate, _ in tries), min(each for _, each in tries)]
        tries = [rectangle(made) for _ in range(TRIES)]
        rows["rectangle"] = [min(each[k] for each in tries) for k in (0, 1)]
        opened(made, page)
        time.sleep(60)  # what is followed ahead has ended, and its compiled code is there
        before = memory(made)
        time.sleep(60 * minutes)
        rows["heap"], rows["memory"] = map(list, zip(before, memory(made), strict=True))
    return rows


if __name__ == "__main__":
    for name, values in measured(*map(float, sys.argv[1:])).items():
        print(name, *(f"{each:.3g}" for each in values))
