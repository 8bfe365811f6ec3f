"""The page of a report in a real browser: silent, as wide as the screen, and safe."""

import base64
import shutil
import tempfile

import pytest
from selenium import webdriver
from selenium.webdriver.chrome.service import Service

from scara_iso.commands import main
from tests.reporting.test_report import HOSTILE, MODEL, WARM_UP

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(
    CHROMIUM is None or DRIVER is None, reason="chromium and chromium-driver are not installed"
)
FLAGS = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
    "--disable-background-networking", "--disable-component-update", "--disable-sync",
)  # fmt: skip
PHONE, LAPTOP, PAPER = 360, 1366, 794


@pytest.fixture(scope="module")
def browser():
    """Return a headless Chromium with an empty profile."""
    options = webdriver.ChromeOptions()
    options.binary_location = CHROMIUM
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        for flag in (*FLAGS, f"--user-data-dir={profile}"):
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        driver = webdriver.Chrome(service=Service(DRIVER), options=options)
        yield driver
        driver.quit()


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """Return the page of a plain table and that of a hostile one."""
    folder = tmp_path_factory.mktemp("pages")
    plain, wild = folder / "plain.html", folder / "wild.html"
    assert main(["report", str(WARM_UP), "--model", str(MODEL), "-o", str(plain)]) == 0
    rows = [r for r in WARM_UP.read_text().splitlines() if not r.startswith("# robot")]
    table = folder / "=<b onclick=x>[red].csv"
    lines = [f"# {k}: {v}" for k, v in {**HOSTILE, "place": "W" * 300}.items()]
    table.write_text("\n".join([*lines, *rows]) + "\n", encoding="utf-8")
    assert main(["report", str(table), "-o", str(wild)]) == 0
    return {"plain": plain, "wild": wild}


def show(browser, page, width):
    browser.execute_cdp_cmd(
        "Emulation.setDeviceMetricsOverride",
        {"width": width, "height": 800, "deviceScaleFactor": 1, "mobile": width < 500},
    )
    browser.get(page.as_uri())


@pytest.mark.slow
@pytest.mark.parametrize("width", [PHONE, PAPER, LAPTOP])
@pytest.mark.parametrize("name", ["plain", "wild"])
def test_the_page_is_silent_and_no_wider_than_the_screen(browser, pages, name, width):
    show(browser, pages[name], width)
    assert browser.get_log("browser") == []
    assert browser.execute_script("return document.documentElement.scrollWidth") <= width
    assert browser.execute_script("return document.querySelectorAll('svg').length") >= 5


def test_the_style_sheet_is_let_in_by_its_hash(browser, pages):
    show(browser, pages["plain"], LAPTOP)
    assert browser.execute_script("return document.styleSheets.length") == 1
    colour = "return getComputedStyle(document.querySelector('h2')).color"
    assert browser.execute_script(colour) == "rgb(11, 90, 143)"


def test_the_policy_refuses_what_is_not_ours(browser, pages, tmp_path):
    page = tmp_path / "spoilt.html"
    spoilt = pages["plain"].read_text(encoding="utf-8")
    page.write_text(spoilt.replace("</main>", "<script>document.title = 'in'</script></main>"))
    show(browser, page, LAPTOP)
    assert browser.title != "in"
    assert "Content Security Policy" in browser.get_log("browser")[0]["message"]


def test_text_of_the_table_becomes_no_element(browser, pages):
    show(browser, pages["wild"], LAPTOP)
    assert browser.execute_script("return document.querySelectorAll('script,img,a').length") == 0
    assert browser.execute_script("return document.querySelectorAll('style').length") == 1
    text = browser.find_element("tag name", "main").text
    for key, value in HOSTILE.items():
        if key != "temperature":
            assert value in text
    assert r"\u202eevil\u2066" in text


def test_every_picture_has_words(browser, pages):
    show(browser, pages["plain"], LAPTOP)
    script = "return [...document.querySelectorAll('svg')].map(s => s.querySelector('title+desc'))"
    assert all(browser.execute_script(script))


@pytest.mark.parametrize("size", [(8.27, 11.69), (8.5, 11)])
def test_the_page_prints(browser, pages, size):
    show(browser, pages["plain"], LAPTOP)
    width, height = size
    printed = browser.execute_cdp_cmd(
        "Page.printToPDF", {"paperWidth": width, "paperHeight": height, "printBackground": True}
    )
    assert base64.b64decode(printed["data"]).startswith(b"%PDF")
