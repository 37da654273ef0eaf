"""The shipped reports in a real browser: on a phone nothing is wider than the page, and no letter is too small."""

from pathlib import Path

import pytest

from tests.chromium import ARGUMENTS, CHROMIUM, IN_A_BROWSER, sync_api

pytestmark = IN_A_BROWSER
REPORTS = sorted((Path(__file__).parents[3] / "results").glob("*/report.html"))
LEAST_PX = 9.0
LETTERS = """() => [...document.querySelectorAll('svg')].flatMap(svg => {
  const times = svg.getBoundingClientRect().width / svg.viewBox.baseVal.width;
  return [...svg.querySelectorAll('[transform*="scale("]')]
    .map(g => /scale\\(([\\d.]+) -/.exec(g.getAttribute('transform')))
    .filter(found => found).map(found => 100 * found[1] * times);
})"""
"""the height of each line of text in the figures, px; figures hold letters as paths, scaled from 100"""


@pytest.fixture(scope="module")
def browser():
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        yield started
        started.close()


@pytest.mark.parametrize("path", REPORTS, ids=lambda path: path.parent.name)
@pytest.mark.parametrize("width", [320, 390, 1280])
def test_everything_fits_and_can_be_read(browser, path, width):
    page = browser.new_page(viewport={"width": width, "height": 800})
    try:
        page.goto(path.as_uri())
        assert page.evaluate("document.documentElement.scrollWidth") == width
        letters = page.evaluate(LETTERS)
        assert len(letters) > 10
        assert min(letters) >= LEAST_PX
    finally:
        page.close()
