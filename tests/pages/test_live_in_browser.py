"""Pages that compute, in a real browser, with a solver of a motion that is known in closed form."""

import math
import re
import shlex
from time import sleep

import numpy as np
import pytest
import xarray as xr

import jointplay as jp
from jointplay.study.file import load
from jointplay_page import live
from tests.figures.support.synthetic_assessment import assessment
from tests.pages.browsing import canvas, click, complaints, drag, opened, text, until
from tests.pages.live_samples import fake, linkage
from tests.pages.samples import diagram

pytestmark = pytest.mark.timeout(240)
SAID = "document.getElementById('point-said').textContent"
MOTIONS = "return (jointplay.point.motions() || []).map((m) => [m.time, ...m.values].map((v) => [...v]))"
SETTLED = "return document.getElementById('live-verdict').dataset.turns >= "


@pytest.fixture(scope="module")
def with_fake():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(live, "solver", fake)
        yield


@pytest.fixture(scope="module")
def page(tmp_path_factory, with_fake):
    (path,) = jp.report(linkage(), tmp_path_factory.mktemp("live") / "linkage.html")
    return path


def give(browser, key, value):
    """Type a number beside a slider."""
    browser.execute_script(
        "const field = document.getElementById(`live-${arguments[0]}-exact`);"
        "field.value = arguments[1]; field.dispatchEvent(new Event('change'))",
        key,
        value,
    )


def said(browser, words, turns=4000):
    """The verdict, when it says something and so many turns have been followed."""
    until(browser, f"return document.getElementById('live-verdict').textContent.includes('{words}')")
    until(browser, f"{SETTLED}{turns}")
    return text(browser, "live-verdict")


def exponent(verdict):
    """The exponent of a verdict, and its error."""
    found = re.search(r"exponent ([+−][\d.]+) ± ([\d.]+)", verdict)
    return float(found[1].replace("−", "-")), float(found[2])


@pytest.mark.nightly
def test_a_motion_is_followed_drawn_and_judged_by_the_stated_rules(chromium, page):
    opened(chromium, page)
    verdict = said(chromium, "The motion repeats every turn")
    s = 1 - 1 / 2.8  # the fixed point
    hits = f"joint B loses contact once a turn and hits at {29 * s:.3g} mm/s"
    most = f"joint B carries up to {200 * s:.3g} N, {2 * s:.3g} times as much as with ideal joints"
    assert verdict.startswith(f"Rattles: {hits}; {most}. ")
    assert exponent(verdict)[0] == pytest.approx(math.log(0.8), abs=1e-4)
    for name in ("linkage", "orbit", "force", "section"):
        assert canvas(chromium, f"live-{name}") > 0
    assert complaints(chromium) == []
    assert page.stat().st_size < 1.5e6


@pytest.mark.nightly
def test_periods_and_chaos_are_told_apart(chromium, page):
    opened(chromium, page, "#live=gear_ratio:3.2")
    said(chromium, "The motion repeats every 2 turns")
    give(chromium, "gear_ratio", 4)
    value, error = exponent(said(chromium, "The motion is chaotic"))
    assert abs(value - math.log(2)) < 3 * error < 0.05
    assert text(chromium, "live-points") == "3950 section points"
    assert complaints(chromium) == []


@pytest.mark.nightly
def test_sliders_work_by_keys_and_stand_in_the_address(chromium, page):
    opened(chromium, page)
    until(chromium, f"{SETTLED}100")
    slider = chromium.find_element("id", "live-clearance.B")
    assert slider.get_attribute("aria-valuetext") == "290 µm"
    slider.send_keys("\ue014")  # right: a hundredth of the range, 10 µm to 1 mm
    until(chromium, "return location.hash.includes('clearance.B')")
    wanted = 2.9e-4 * 100**0.01
    address = chromium.current_url
    opened(chromium, page, address[address.index("#") :])
    until(chromium, f"{SETTLED}100")
    shown = chromium.find_element("id", "live-clearance.B-exact").get_attribute("value")
    assert float(shown) == pytest.approx(1e6 * wanted, rel=1e-5)
    chromium.find_element("id", "live-reset").click()
    until(chromium, "return !location.hash.includes('clearance.B')")
    assert complaints(chromium) == []


@pytest.mark.long
def test_what_is_refused_is_told_and_not_taken(chromium, page):
    opened(chromium, page)
    until(chromium, f"{SETTLED}100")
    give(chromium, "gear_ratio", 9)
    until(chromium, "return document.getElementById('live-gear_ratio-refused').textContent")
    assert "from 2.5 to 4 is accepted" in text(chromium, "live-gear_ratio-refused")
    assert chromium.find_element("id", "live-gear_ratio-exact").get_attribute("value") == "2.8"
    assert "gear_ratio" not in text(chromium, "live-command")


@pytest.mark.long
def test_what_cannot_be_moved_or_not_further_says_why(chromium, page):
    opened(chromium, page)
    until(chromium, f"{SETTLED}100")
    why = "where the motion begins is not known at other lengths"
    assert f"length of link crank, 50 mm, cannot be moved: {why}." in text(chromium, "live-more")
    slider = chromium.find_element("id", "live-gear_ratio")
    refused = "No more: beyond this, the mechanism's own checks refuse it."
    for key, value, words in (("\ue010", "4", refused), ("\ue011", "2.5", "")):  # the ends of the range
        slider.send_keys(key)
        until(chromium, f"return document.getElementById('live-gear_ratio-exact').value === '{value}'")
        assert text(chromium, "live-gear_ratio-end") == words
        assert text(chromium, "live-gear_ratio-refused") == ""


@pytest.mark.long
def test_numerical_trouble_is_said_and_mended_by_other_values(chromium, page):
    opened(chromium, page, "#live=damping.B:800")
    assert said(chromium, "Stopped", 0) == "Stopped: not converged."
    give(chromium, "damping.B", 100)
    said(chromium, "The motion repeats")
    assert complaints(chromium) == []


@pytest.mark.long
def test_the_study_and_command_give_the_mechanism_that_is_shown(chromium, page, tmp_path):
    opened(chromium, page, "#live=clearance.B:0.0001 damping.B:250")
    until(chromium, f"{SETTLED}100")
    program, verb, file, *words = shlex.split(text(chromium, "live-command"))
    assert [program, verb, words[0]] == ["jointplay", "run", "--set"]
    (tmp_path / file).write_text(text(chromium, "live-study"), encoding="utf-8")
    given = load(tmp_path / file, words[1:]).record.mechanism
    wanted = {"joints.B.clearance": 1e-4, "joints.B.contact.damping": 250.0}
    assert given == linkage().replace(**wanted)


@pytest.mark.nightly
def test_a_diagram_is_computed_clicked_in_and_refined(chromium, page):
    from selenium.webdriver.common.action_chains import ActionChains

    opened(chromium, page)
    until(chromium, f"{SETTLED}100")
    chromium.execute_script(
        "const key = document.getElementById('scan-key'); key.value = 'gear_ratio';"
        "key.dispatchEvent(new Event('change')); document.getElementById('scan-run').click()"
    )
    done = "return document.getElementById('scan-said').textContent.startsWith('120 of 120')"
    until(chromium, done)
    assert chromium.find_element("id", "scan-stop").get_attribute("disabled")
    drawn = chromium.find_element("id", "scan-canvas")
    chromium.execute_script("arguments[0].scrollIntoView({block: 'center'})", drawn)
    ActionChains(chromium).move_to_element(drawn).click().perform()  # 52 px of its left are the axis
    until(chromium, "return document.getElementById('live-gear_ratio-exact').value !== '2.8'")
    half = (drawn.size["width"] / 2 - 52) / (drawn.size["width"] - 66)
    shown = float(chromium.find_element("id", "live-gear_ratio-exact").get_attribute("value"))
    assert shown == pytest.approx(2.5 + 1.5 * half, abs=0.005)
    ActionChains(chromium).move_to_element(drawn).click_and_hold().move_by_offset(100, 0).release().perform()
    until(chromium, "return document.getElementById('scan-from').value > 3")
    until(chromium, done)
    ends = [
        float(chromium.find_element("id", f"scan-{end}").get_attribute("value")) for end in ("from", "to")
    ]
    assert ends == pytest.approx([shown, shown + 150 / (drawn.size["width"] - 66)], abs=0.01)
    assert "scan=120+100+gear_ratio" in chromium.current_url
    assert complaints(chromium) == []


@pytest.mark.long
def test_force_and_impact_speed_are_drawn_over_the_slider(chromium, page):
    """Contact begins at 100 s times the clearance: gently below it, hard above."""
    opened(chromium, page, "#scan=16+300+clearance.B+0.00001+0.001")
    until(chromium, "return document.getElementById('scan-said').textContent.startsWith('16 of 16')")
    s = 1 - 1 / 2.8

    def ground(clearance):
        """The colour of the ground at a clearance, close to the upper edge."""
        return chromium.execute_script(
            "const it = document.getElementById('scan-speed');"
            "const at = [54 + arguments[0] * (it.clientWidth - 68), 17];"
            "const [x, y] = at.map((each) => each * devicePixelRatio);"
            "return String(it.getContext('2d').getImageData(x, y, 1, 1).data)",
            math.log(clearance / 1e-5) / math.log(100),
        )

    grounds = [ground(each / (100 * s)) for each in (0.002, 0.005, 0.015, 0.06)]
    assert grounds[0] == grounds[1] != grounds[2] == grounds[3]  # touches, rattles
    assert canvas(chromium, "scan-force") > 0
    assert complaints(chromium) == []


@pytest.mark.nightly
def test_the_verdict_of_an_assessment_s_page_moves_with_the_slider(chromium, with_fake, tmp_path):
    path, _ = jp.report(assessment(), tmp_path / "assessed.html", mechanism=linkage())
    opened(chromium, path)
    until(chromium, f"{SETTLED}100")
    place = "return document.getElementById('{}').getBoundingClientRect().top"
    first, then = (chromium.execute_script(place.format(name)) for name in ("live", "picture0"))
    assert first < then
    assert text(chromium, "live-verdict").startswith(
        "Rattles: joint B loses contact once a turn and hits at "
    )
    give(chromium, "clearance.B", 20)
    until(chromium, "return document.getElementById('live-verdict').dataset.grade === 'touches'")
    assert "What it hangs on" in text(chromium, "numbers")
    assert complaints(chromium) == []


@pytest.mark.nightly
def test_a_map_shows_the_periods_over_two_sliders(chromium, page):
    opened(chromium, page, "#scan=16+300+gear_ratio+2.6+3.6+damping.B+0+1000")
    until(chromium, "return document.getElementById('scan-said').textContent.startsWith('256 of 256')")
    assert "128 ended early (not converged)" in text(chromium, "scan-said")

    def colour(gear_ratio, damping):
        return chromium.execute_script(
            "const it = document.getElementById('scan-canvas');"
            "const [wide, high] = [it.clientWidth - 66, it.clientHeight - 48];"
            "const at = [52 + arguments[0] * wide, 14 + arguments[1] * high];"
            "const pen = it.getContext('2d');"
            "const dot = pen.getImageData(...at.map((each) => each * devicePixelRatio), 1, 1);"
            "return Array.from(dot.data).slice(0, 3)",
            gear_ratio - 2.6,
            1 - damping / 1000,
        )

    assert colour(2.67, 200) == [0, 114, 178]  # repeats every turn
    assert colour(3.2, 200) == [86, 180, 233]  # every two
    assert colour(3.533, 200) == [0x5B, 0x0F, 0x4F]  # every four
    assert colour(3.2, 800) == [0, 0, 0]
    assert complaints(chromium) == []


@pytest.mark.nightly
def test_a_diagram_is_the_same_on_any_number_of_processors(chromium, page):
    """The motion of this range is chaotic: other stretches would have other points."""
    pictures = set()
    for count in (1, 3):
        opened(chromium, page)
        until(chromium, f"{SETTLED}100")
        chromium.execute_script(
            "Object.defineProperty(navigator, 'hardwareConcurrency', { value: arguments[0] });"
            "location.hash = 'live=gear_ratio:3.9'; document.getElementById('live-play').click();"
            "document.getElementById('scan-key').value = 'gear_ratio';"
            "document.getElementById('scan-key').dispatchEvent(new Event('change'));"
            "document.getElementById('scan-from').value = 3.7; document.getElementById('scan-to').value = 4;"
            "document.getElementById('scan-run').click()",
            count,
        )
        until(chromium, "return document.getElementById('scan-said').textContent.startsWith('120 of 120')")
        sleep(0.5)
        pictures.add(canvas(chromium, "scan-canvas"))
    assert len(pictures) == 1
    assert pictures.pop() > 0


@pytest.mark.nightly
def test_a_diagram_can_be_stopped(chromium, page):
    opened(chromium, page, "#scan=1000 5000 gear_ratio 2.5 4")
    until(chromium, "return !document.getElementById('scan-stop').disabled")
    chromium.execute_script("document.getElementById('scan-stop').click()")
    before = text(chromium, "scan-said")
    assert re.fullmatch(r"Stopped after \d+ values.", before)
    sleep(0.3)
    assert text(chromium, "scan-said") == before


@pytest.mark.long
def test_play_is_slow_through_an_impact(chromium, page):
    opened(chromium, page)
    until(chromium, f"{SETTLED}100")
    chromium.execute_script(
        "document.getElementById('live-slow').checked = true;"
        "const moment = document.getElementById('live-phase');"  # the contact ends at a quarter turn
        "moment.value = 246; moment.dispatchEvent(new Event('input'));"
        "const begun = performance.now(); let last = begun; window.late = 0;"
        "const look = () => { const now = performance.now(); late = Math.max(late, now - last); last = now;"
        "if (moment.value < 255) requestAnimationFrame(look); else window.took = now - begun; };"
        "document.getElementById('live-play').click(); look();"
    )
    until(chromium, "return window.took > 0")
    assert chromium.execute_script("return took + late") > 900  # ms; a late frame skips its own
    until(chromium, "return document.getElementById('live-phase').value > 300")


@pytest.mark.long
def test_the_time_in_the_turn_has_words(chromium, page):
    opened(chromium, page)
    until(chromium, f"{SETTLED}100")
    chromium.execute_script(
        "const moment = document.getElementById('live-phase');"
        "moment.value = 250; moment.dispatchEvent(new Event('input'));"
    )
    moment = chromium.find_element("id", "live-phase")
    assert moment.get_attribute("aria-valuetext") == "25 % of a turn"


@pytest.mark.long
def test_a_phone_shows_it_without_scrolling_sideways(chromium, page):
    size = chromium.get_window_size()
    try:
        chromium.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": 380, "height": 800, "deviceScaleFactor": 2, "mobile": True},
        )
        opened(chromium, page)
        until(chromium, f"{SETTLED}100")
        wide, seen = chromium.execute_script(
            "return [document.documentElement.scrollWidth, document.documentElement.clientWidth]"
        )
        assert wide <= seen == 380
        for name in ("orbit", "force", "section"):  # below each other
            assert chromium.execute_script(f"return document.getElementById('live-{name}').clientWidth") > 320
        top, bottom, slider = chromium.execute_script(
            "document.getElementById('live-damping.B').scrollIntoView();"  # under what stays in view
            "scrollBy(0, -350);"
            "const box = (name) => document.getElementById(`live-${name}`).getBoundingClientRect();"
            "return [box('linkage').top, box('linkage').bottom, box('damping.B').top]"
        )
        assert 0 <= top < bottom < slider < 800
        assert text(chromium, "live-short") == "rattles, 129 N, 18.6 mm/s"
    finally:
        chromium.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})
        chromium.set_window_size(size["width"], size["height"])


@pytest.mark.nightly
def test_a_click_in_a_stored_diagram_leads_the_sliders_there(chromium, with_fake, tmp_path):
    path, _ = jp.report(diagram(), tmp_path / "sweep.html", mechanism=linkage())
    opened(chromium, path)
    until(chromium, f"{SETTLED}100")
    click(chromium, 123, 20)
    until(chromium, "return Math.abs(document.getElementById('live-clearance.B-exact').value - 123) < 2")
    drag(chromium, (20, 30), (200, 10))
    ends = [
        float(chromium.find_element("id", f"scan-{end}").get_attribute("value")) for end in ("from", "to")
    ]
    assert ends == pytest.approx([20, 200], rel=0.02)
    assert complaints(chromium) == []


@pytest.mark.nightly
def test_a_clicked_point_shows_force_and_path_from_its_stored_state(chromium, with_fake, tmp_path):
    stored = diagram()
    last = np.linspace(0.2, 0.6, stored["period"].size).reshape(stored["period"].shape)
    ended = xr.DataArray(last[..., None], dims=(*stored["period"].dims, "state"), coords={"state": ["s"]})
    whole, _ = jp.report(stored.assign(end_state=ended), tmp_path / "whole.html", mechanism=linkage())
    opened(chromium, whole, "#cell=3")
    until(chromium, f"return {SAID}.includes('in which the stored motion ended')")
    here = stored["clearance"].values[3]
    for motion, s in zip(
        chromium.execute_script(MOTIONS), ended.isel(clearance=3).values.ravel(), strict=True
    ):
        time, x, y, force = np.array(motion)
        assert time[[0, -1]] == pytest.approx([4 / 2880, 4.0])
        np.testing.assert_allclose(force, 100 * s * (1 + np.cos(2 * np.pi * time)), atol=1e-6)
        np.testing.assert_allclose(np.hypot(x, y), s * here, rtol=1e-9)
    seen = [canvas(chromium, name) for name in ("point-force0", "point-orbit0")]
    chromium.switch_to.active_element.send_keys("\ue012")  # left
    until(chromium, f"{MOTIONS}[0]?.[3][0] < {200 * last[3, 0] - 1}")
    assert [canvas(chromium, name) for name in ("point-force0", "point-orbit0")] != seen
    bare, _ = jp.report(stored, tmp_path / "bare.html", mechanism=linkage())
    opened(chromium, bare, "#cell=3")
    until(chromium, f"return {SAID}.includes('after 100 turns')")
    assert complaints(chromium) == []


@pytest.mark.nightly
def test_a_point_beyond_the_sliders_is_said_not_to_be_computed(chromium, with_fake, tmp_path):
    far = diagram().assign_coords(clearance=100 * diagram()["clearance"])
    path, _ = jp.report(far, tmp_path / "far.html", mechanism=linkage())
    opened(chromium, path, "#cell=3")
    until(chromium, f"return {SAID}.startsWith('The motion is not computed here. a value from')")
    other = diagram().rename(clearance="length")
    path, _ = jp.report(other, tmp_path / "other.html", mechanism=linkage())
    opened(chromium, path, "#cell=3")
    until(chromium, f"return {SAID}.endsWith('there is no slider for length.')")


@pytest.mark.nightly
def test_firefox_shows_the_same(firefox, page):
    opened(firefox, page, "#live=gear_ratio:3.2")
    assert said(firefox, "The motion repeats every 2 turns")
    assert firefox.get_log("browser") == []
    firefox.execute_script("console.error('heard')")
    until(firefox, "return true")
    assert "heard" in str(firefox.get_log("browser"))  # or silence would prove nothing


@pytest.mark.nightly
def test_memory_stays_flat_and_frames_go_on(chromium, page):
    opened(chromium, page)
    until(chromium, f"{SETTLED}4000")

    def heap():
        """Bytes that stay: the least of several collections, as each leaves what the frame under way made."""
        left = []
        for _ in range(12):
            chromium.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
            left.append(chromium.execute_cdp_cmd("Runtime.getHeapUsage", {})["usedSize"])
            sleep(0.4)
        return min(left)

    chromium.execute_script(
        "window.frames_seen = 0; const look = () => { frames_seen += 1; requestAnimationFrame(look); };"
        "look();"
        "let at = 0; setInterval(() => { const s = document.getElementById('live-gear_ratio');"
        "at = (at + 7) % 1000; s.value = at; s.dispatchEvent(new Event('input')) }, 30)"
    )
    until(chromium, "return frames_seen > 600")  # by then the browser has compiled what runs often
    before, begun = heap(), chromium.execute_script("return frames_seen")
    sleep(60)
    after, frames = heap(), chromium.execute_script("return frames_seen") - begun
    print({"before": before, "after": after, "frames_per_second": frames / 60})
    assert after < 1.1 * before + 5e5  # a frame of which a kilobyte stayed would come to more in this minute
    assert frames > 60 * 15  # 30 and more on a machine of its own
    assert complaints(chromium) == []
