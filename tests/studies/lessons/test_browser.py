"""The lessons in a real browser: controls move numbers, nobody else is asked, memory and answers stay bounded.

SIMFIELD_SCREENSHOTS names a folder for the pictures that somebody should look at.
"""

import contextlib
import http.client
import os
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import urlsplit

import psutil
import pytest

from studies.lessons.lesson import LESSONS
from studies.lessons.serving.server import SESSION_SECONDS
from tests.chromium import ARGUMENTS, CHROMIUM, IN_A_BROWSER, sync_api

pytest.importorskip("marimo", reason="the lessons need the extra `teach`")

pytestmark = IN_A_BROWSER
PATIENCE_MS = 60_000
ANSWER_SECONDS = 3.0
"""median of the moves, a bound for a loaded machine; 0.3 s is usual"""
RELOADS, MOVES = 50, 200
GROWTH_MB = 40.0
"""of the server over 50 visits after 10 visits: single ones leave nothing that can be seen"""

MOVES_OF = {
    "redundancy": lambda page: page.get_by_role("slider").first.press("ArrowRight"),
    "second_zero": lambda page: page.get_by_role("slider").press("End"),
    "which_model": lambda page: page.get_by_label("additional parameters").select_option("brown14"),
    "interval": lambda page: page.get_by_role("button", name="measure anew").click(),
    "gross_error": lambda page: page.get_by_role("slider").press("End"),
    "own_block": lambda page: page.get_by_role("slider").first.press("ArrowRight"),
}
"""one move in every lesson"""


@contextlib.contextmanager
def teaching(folder):
    """(address with the token, process) of a running `simfield teach`, which is ended afterwards."""
    command = [sys.executable, "-c", "from studies.commands.program import main; main()", "teach", "--no-browser"]
    errors = (folder / "stderr").open("w+", encoding="utf-8")
    with errors, subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True) as process:
        try:
            line = process.stdout.readline()
            assert line.startswith("open http://127.0.0.1:"), Path(errors.name).read_text(encoding="utf-8")
            yield line.removeprefix("open ").strip(), process
        finally:
            process.kill()


@pytest.fixture(scope="module")
def server(tmp_path_factory):
    with teaching(tmp_path_factory.mktemp("server")) as running:
        yield running


@pytest.fixture(scope="module")
def browser():
    with sync_api.sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=CHROMIUM, args=list(ARGUMENTS))
        yield started
        started.close()


@pytest.fixture
def page(browser, server):
    """A page of a visitor who has opened the address; nothing went wrong in it, nobody else was asked."""
    context = browser.new_context(viewport={"width": 1200, "height": 1100})
    page = context.new_page()
    page.set_default_timeout(PATIENCE_MS)
    asked, wrong = [], []
    context.on("request", lambda request: asked.append(request.url))
    page.on("websocket", lambda socket: asked.append(socket.url))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("console", lambda message: wrong.append(message.text) if message.type == "error" else None)
    page.goto(server[0])
    yield page
    context.close()
    own = urlsplit(server[0]).netloc
    assert [url for url in asked if urlsplit(url).netloc not in (own, "")] == []
    assert wrong == []


def open_lesson(page, server, lesson_id):
    page.goto(f"http://{urlsplit(server[0]).netloc}/{lesson_id}/")
    page.wait_for_selector("[data-number]")
    page.wait_for_selector("img[alt]")


def numbers(page):
    return page.locator("[data-number]").all_inner_texts()


def wait_for_other_numbers(page, old):
    page.wait_for_function(
        "old => { const now = [...document.querySelectorAll('[data-number]')].map(e => e.innerText);"
        " return now.length > 0 && now.join() != old.join(); }",
        arg=old,
    )


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda lesson: lesson.id)
def test_a_lesson_is_opened_and_its_control_moves_numbers(page, server, lesson, tmp_path):
    page.get_by_role("link", name=lesson.question).click()
    page.wait_for_selector("img[alt]")
    assert page.get_by_role("heading", level=1).inner_text() == lesson.question
    old, picture = numbers(page), page.locator("img[alt]").get_attribute("src")
    MOVES_OF[lesson.id](page)
    wait_for_other_numbers(page, old)
    page.wait_for_function("old => document.querySelector('img[alt]').getAttribute('src') != old", arg=picture)
    page.get_by_text("The formulas", exact=True).click()
    page.wait_for_selector(".katex")
    folder = Path(os.environ.get("SIMFIELD_SCREENSHOTS", tmp_path))
    page.screenshot(path=folder / f"{lesson.id}.png")
    assert (folder / f"{lesson.id}.png").stat().st_size > 20_000


def test_a_problem_is_explained_and_can_be_left_again(page, server):
    open_lesson(page, server, "own_block")
    page.get_by_label("control").select_option("none")
    page.wait_for_selector("[data-problem]")
    assert "no control" in page.locator("[data-problem]").inner_text()
    page.wait_for_selector("[data-number]", state="detached")
    page.get_by_label("control").select_option("all around")
    page.wait_for_selector("[data-number]")
    assert page.locator("[data-problem]").count() == 0


def test_nothing_is_remembered_for_the_next_visitor(page, server, browser):
    open_lesson(page, server, "gross_error")
    first = numbers(page)
    page.get_by_role("slider").press("End")
    wait_for_other_numbers(page, first)
    other = browser.new_page()
    try:
        other.goto(server[0])
        open_lesson(other, server, "gross_error")
        assert numbers(other) == first
    finally:
        other.close()
    page.reload()
    page.wait_for_selector("img[alt]")
    assert numbers(page) == first


def test_a_storm_of_moves_is_answered_and_ends(page, server):
    open_lesson(page, server, "gross_error")
    slider = page.get_by_role("slider")
    seconds = []
    for _ in range(10):
        old = numbers(page)
        start = time.perf_counter()
        slider.press("ArrowRight")
        wait_for_other_numbers(page, old)
        seconds.append(time.perf_counter() - start)
    print(f"median answer {statistics.median(seconds):.2f} s, longest {max(seconds):.2f} s")
    assert statistics.median(seconds) < ANSWER_SECONDS
    for number in range(MOVES):
        slider.press("ArrowRight" if number % 40 < 20 else "ArrowLeft")
    slider.press("Home")
    start = time.perf_counter()
    page.wait_for_function("() => document.body.innerText.replaceAll('\u00a0', ' ').includes('you planted 0 µm')")
    # moves that wait are taken together, so the last one does not stand behind 200
    assert time.perf_counter() - start < 2.0 * ANSWER_SECONDS


def test_memory_is_bounded_over_many_visits(page, server):
    process = psutil.Process(server[1].pid)
    open_lesson(page, server, "redundancy")

    def visit(times):
        for _ in range(times):
            page.reload(wait_until="commit")
            page.wait_for_selector("img[alt]")
        time.sleep(SESSION_SECONDS + 2.0)
        return process.memory_info().rss / 1e6, process.num_threads()

    (before, threads), (after, threads_after) = visit(10), visit(RELOADS)
    print(f"server {before:.0f} MB after 10 visits, {after:.0f} MB after {RELOADS} more; {threads_after} threads")
    assert after - before < GROWTH_MB
    # a thread a visitor: those who have left have taken theirs along
    assert threads_after <= threads + 4


@pytest.mark.parametrize(
    ("path", "headers", "wanted"),
    [
        ("/", {}, 403),
        ("/interval/", {}, 403),
        ("/interval/assets/", {}, 403),
        ("/?token=wrong", {}, 403),
        ("/?token={token}", {"Host": "evil.example"}, 421),
        ("/", {"Host": "evil.example", "Cookie": "simfield-{port}={token}"}, 421),
        ("/", {"Origin": "http://evil.example", "Cookie": "simfield-{port}={token}"}, 403),
        ("/?token={token}", {}, 303),
        ("/", {"Cookie": "simfield-{port}={token}"}, 200),
        ("/interval/", {"Cookie": "simfield-{port}={token}"}, 200),
    ],
)
def test_who_is_let_in(server, path, headers, wanted):
    address = urlsplit(server[0])
    known = {"token": address.query.removeprefix("token="), "port": address.port}
    connection = http.client.HTTPConnection(address.hostname, address.port, timeout=30)
    try:
        connection.request("GET", path.format(**known), headers={k: v.format(**known) for k, v in headers.items()})
        assert connection.getresponse().status == wanted
    finally:
        connection.close()


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_it_ends_while_pages_are_open(browser, tmp_path, number, code):
    with teaching(tmp_path) as (address, process):
        visitor = browser.new_page()
        visitor.set_default_timeout(PATIENCE_MS)
        try:
            visitor.goto(address)
            open_lesson(visitor, (address, process), "interval")
            visitor.reload()
            visitor.wait_for_selector("img[alt]")
            process.send_signal(number)
            assert process.wait(timeout=30) == code
        finally:
            visitor.close()


def test_only_this_machine_can_reach_it(server):
    listening = psutil.Process(server[1].pid).net_connections(kind="inet")
    assert {c.laddr.ip for c in listening if c.status == psutil.CONN_LISTEN} == {"127.0.0.1"}
