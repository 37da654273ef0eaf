"""Who may talk to the lessons: this machine's browser, with the token, and nobody else.

A page of another site cannot reach the server by a name that it makes point here (DNS rebinding), because a foreign
Host header is refused; its scripts cannot open a websocket, because a foreign Origin is refused; another user of the
machine has not the token. What is sent back allows the browser to load nothing from any other host.
"""

from __future__ import annotations

import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qsl, urlencode

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
App = Callable[[Message, Receive, Send], Awaitable[None]]

HOSTS = ("127.0.0.1", "localhost")
TOKEN = "token"
FORBIDDEN, MISDIRECTED = 403, 421
# their names contain a hash of their content; a reload would otherwise ask for each of some 200 again
ASSETS = ((b"cache-control", b"private, max-age=86400, immutable"),)

# marimo's pages have inline scripts and compile expressions; styles are set by scripts
POLICY = (
    "default-src 'none'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob:; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self' {sockets}; worker-src 'self' blob:; "
    "manifest-src 'self'; base-uri 'self'; form-action 'self'; frame-ancestors 'none'"
)


class Guard:
    """Demands Host, Origin and token of every request and websocket before `app` sees them.

    The first call carries the token in its address; it is answered by a cookie and the same address without it.
    """

    def __init__(self, app: App, token: str, port: int) -> None:
        self.app, self.token = app, token
        self.hosts = tuple(f"{host}:{port}" for host in HOSTS)
        # cookies know no ports, so two servers on this machine need two names
        self.cookie = f"simfield-{port}"
        policy = POLICY.format(sockets=" ".join(f"ws://{host}" for host in self.hosts))
        self.headers = (
            (b"content-security-policy", policy.encode()),
            (b"referrer-policy", b"no-referrer"),
            (b"x-content-type-options", b"nosniff"),
            (b"cross-origin-opener-policy", b"same-origin"),
            (b"cross-origin-resource-policy", b"same-origin"),
        )

    async def __call__(self, scope: Message, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = _headers(scope)
        refusal = self._refusal(headers)
        asked = parse_qsl(scope["query_string"].decode("latin-1"), keep_blank_values=True)
        given = [value for name, value in asked if name == TOKEN]
        if refusal is not None:
            await _refuse(scope, receive, send, *refusal)
        elif given and scope["type"] == "http" and self._right(given[0]):
            rest = urlencode([(name, value) for name, value in asked if name != TOKEN])
            await self._welcome(send, scope["path"] + (f"?{rest}" if rest else ""))
        elif self._right(_cookie(headers, self.cookie)):
            await self.app(scope, receive, self._with_headers(send, scope["path"]))
        else:
            await _refuse(scope, receive, send, FORBIDDEN, "open the address that `simfield teach` has printed")

    def _refusal(self, headers: dict[str, str]) -> tuple[int, str] | None:
        if headers.get("host", "") not in self.hosts:
            return MISDIRECTED, "this server answers to its own address only"
        origin = headers.get("origin")
        if origin is not None and origin not in [f"http://{host}" for host in self.hosts]:
            return FORBIDDEN, "this server answers its own pages only"
        return None

    def _right(self, token: str) -> bool:
        return secrets.compare_digest(token.encode(), self.token.encode())

    async def _welcome(self, send: Send, path: str) -> None:
        # a path of two slashes would be an address of another host
        place = "/" + path.lstrip("/\\")
        cookie = f"{self.cookie}={self.token}; Path=/; HttpOnly; SameSite=Strict"
        headers = [
            (b"location", place.encode("latin-1", "replace")),
            (b"set-cookie", cookie.encode()),
            (b"cache-control", b"no-store"),
            *self.headers,
        ]
        await send({"type": "http.response.start", "status": 303, "headers": headers})
        await send({"type": "http.response.body", "body": b""})

    def _with_headers(self, send: Send, path: str) -> Send:
        async def sending(message: Message) -> None:
            if message["type"] == "http.response.start":
                asset = message["status"] == 200 and path.rpartition("/")[0].endswith("/assets")
                added = self.headers + (ASSETS if asset else ())
                ours = {name for name, _ in added}
                kept = [(name, value) for name, value in message.get("headers", []) if name.lower() not in ours]
                message = {**message, "headers": [*kept, *added]}
            await send(message)

        return sending


def _headers(scope: Message) -> dict[str, str]:
    """The headers by lower-case name; of one given twice, both, so that it fits nothing."""
    found: dict[str, str] = {}
    for name, value in scope["headers"]:
        key, text = name.decode("latin-1").lower(), value.decode("latin-1")
        found[key] = f"{found[key]}; {text}" if key in found else text
    return found


def _cookie(headers: dict[str, str], name: str) -> str:
    try:
        jar = SimpleCookie(headers.get("cookie", ""))
    except CookieError:
        return ""
    return jar[name].value if name in jar else ""


async def _refuse(scope: Message, receive: Receive, send: Send, status: int, sentence: str) -> None:
    if scope["type"] == "websocket":
        # closed before it was accepted: the browser is told 403
        await receive()
        await send({"type": "websocket.close", "code": 1008})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"cache-control", b"no-store")]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": f"{sentence}\n".encode()})
