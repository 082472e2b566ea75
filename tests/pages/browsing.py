"""What tests of pages in a browser share: opening one, waiting for what it shows, its complaints."""

from time import monotonic, sleep


def opened(browser, path, fragment=""):
    """Open a page and wait until its charts are drawn."""
    browser.get("about:blank")  # or a changed fragment alone would load nothing
    browser.get(path.as_uri() + fragment)
    return until(browser, "return document.documentElement.dataset.ready")


def until(browser, script, seconds=60):
    """What a script returns, as soon as that is something."""
    end = monotonic() + seconds
    while monotonic() < end:
        if found := browser.execute_script(script):
            return found
        sleep(0.05)
    raise AssertionError(f"never: {script}\n{browser.get_log('browser')}")


def complaints(browser):
    """Console messages beside greetings; those on how graphics are drawn are the machine's."""
    logged = browser.get_log("browser")
    return [each for each in logged if each["level"] != "INFO" and each["source"] != "rendering"]


def text(browser, element):
    """The text of an element, seen or not."""
    return browser.execute_script(f"return document.getElementById('{element}').textContent")
