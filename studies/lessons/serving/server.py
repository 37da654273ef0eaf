"""The lessons in a browser: an index page and a marimo app for each lesson, on this machine only."""

from __future__ import annotations

import html
import os
import secrets
import socket
import threading
import webbrowser
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from importlib import import_module
from typing import TYPE_CHECKING, Any, cast

from studies.lessons.lesson import LESSONS
from studies.lessons.serving.guard import HOSTS, TOKEN, App, Guard

if TYPE_CHECKING:
    import uvicorn

SESSION_SECONDS = 5
"""how long a closed page is remembered, for a browser that has lost its connection for a moment"""

PAGE = """<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>simfield: lessons</title>
<link rel="icon" href="data:,">
<style>
body {{ font-family: system-ui, sans-serif; max-width: 46rem; margin: 2.5rem auto; padding: 0 1rem; line-height: 1.5; }}
ol {{ padding-left: 1.4rem; }}
li {{ margin: 1.1rem 0; }}
a {{ font-size: 1.15rem; color: #005a8e; }}
p {{ margin: 0.2rem 0; }}
</style>
</head>
<body>
<h1>What self-calibration does</h1>
<p>Each lesson has a question and a few controls. Move them: everything is computed anew at once, by the same simulator
and the same bundle adjustment that the studies use. Nothing is kept when you leave.</p>
<ol>
{lessons}
</ol>
<p>Lessons 1 to 4 fly over the field of L. Mauelshagen, Hamburg 1980: 41 groups of points in Rheidt near Bonn, with his
wide-angle and super-wide-angle cameras.</p>
</body>
</html>
"""


def index_page() -> str:
    """The page that lists the lessons."""
    lines = (
        f'<li><a href="{lesson.id}/">{html.escape(lesson.question)}</a><p>{html.escape(lesson.summary)}</p></li>'
        for lesson in LESSONS
    )
    return PAGE.format(lessons="\n".join(lines))


def application(token: str, port: int) -> App:
    """The guarded ASGI application: / is the index, /redundancy/ and so on are the lessons."""
    # no question to a package index whether there is a newer marimo
    os.environ.setdefault("MARIMO_SKIP_UPDATE_CHECK", "1")
    import marimo
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import HTMLResponse
    from starlette.routing import Mount, Route

    def index(request: Request) -> HTMLResponse:
        return HTMLResponse(index_page())

    shown: list[Any] = []

    def kept(app: Any) -> Any:
        shown.append(app)
        return app

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        yield
        # the threads of visitors who are still there would keep the process from ending
        for each in shown:
            await each.state.session_manager.shutdown()

    builder = marimo.create_asgi_app(quiet=True, include_code=False, session_ttl=SESSION_SECONDS)
    for lesson in LESSONS:
        builder = builder.with_app(path=f"/{lesson.id}", root=str(lesson.app_file), middleware=[kept])
    routes = [Route("/", index), Mount("/", builder.build())]
    return Guard(cast(App, Starlette(routes=routes, lifespan=lifespan)), token, port)


def warm_up(say: Callable[[str], None]) -> None:
    """Run every lesson once, so that nothing is compiled or imported while a visitor waits."""
    for number, lesson in enumerate(LESSONS, start=1):
        say(f"preparing lesson {number} of {len(LESSONS)}: {lesson.question}")
        import_module(f"studies.lessons.apps.{lesson.id}").app.run()


def serve(port: int, *, browser: bool, say: Callable[[str], None]) -> None:
    """Serve the lessons on 127.0.0.1 until interrupted; port 0 takes a free one.

    say is told the address with its token. Raises OSError where the port is taken.
    """
    from threadpoolctl import threadpool_limits

    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listening:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((HOSTS[0], port))
        listening.listen()
        port = listening.getsockname()[1]
        warm_up(say)
        token = secrets.token_urlsafe(24)
        address = f"http://{HOSTS[0]}:{port}/?{TOKEN}={token}"
        say(f"open {address}")
        say("stop with Ctrl-C")
        if browser:
            threading.Timer(0.5, webbrowser.open, (address,)).start()
        # two threads of BLAS cost several times more when the other core draws for another visitor
        with threadpool_limits(limits=1, user_api="blas"):
            _server(application(token, port)).run(sockets=[listening])


def _server(app: App) -> uvicorn.Server:
    import uvicorn

    options: dict[str, Any] = {"log_level": "warning", "access_log": False, "server_header": False}
    # a page left open must not keep the server from ending
    return uvicorn.Server(uvicorn.Config(app, **options, timeout_graceful_shutdown=1, proxy_headers=False))
