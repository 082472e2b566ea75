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


def canvas(browser, name):
    """The colours that a canvas shows, beside what is empty."""
    return browser.execute_script(
        "const it = document.getElementById(arguments[0]);"
        "const dots = it.getContext('2d').getImageData(0, 0, it.width, it.height).data;"
        "let sum = 0; for (const each of dots) sum = (31 * sum + each) % 1000003; return sum",
        name,
    )


def place(browser, x, y):
    """Where data coordinates of the first panel are in the window, the picture being scrolled there."""
    return browser.execute_script(
        """const { scales, svgs } = jointplay.charts;
        svgs[0].scrollIntoView({block: 'center'});
        const point = new DOMPoint(scales[0][0][0](arguments[0]), scales[0][1][0](arguments[1]));
        const { x, y } = point.matrixTransform(svgs[0].getScreenCTM());
        return [Math.round(x), Math.round(y)]""",
        x,
        y,
    )


def click(browser, x, y):
    """Click in the first panel at data coordinates, as with a mouse."""
    from selenium.webdriver.common.action_chains import ActionChains

    action = ActionChains(browser)
    action.w3c_actions.pointer_action.move_to_location(*place(browser, x, y))
    action.w3c_actions.pointer_action.click()
    action.perform()


def drag(browser, begin, end):
    """Drag from one place in data coordinates of the first panel to another, as with a mouse."""
    from selenium.webdriver.common.action_chains import ActionChains

    action = ActionChains(browser, duration=20)
    pointer = action.w3c_actions.pointer_action
    pointer.move_to_location(*place(browser, *begin)).pointer_down()
    pointer.move_to_location(*place(browser, *end)).pointer_up()
    action.perform()
