"""Who is let in and who is not; the applications behind are never asked by those who are not."""

import asyncio

import pytest

from studies.lessons.serving.guard import Guard

TOKEN = "a-token-of-some-length"
PORT = 8000
HOST = (b"host", b"127.0.0.1:8000")
COOKIE = (b"cookie", b"simfield-8000=" + TOKEN.encode())


class Behind:
    """An application that counts how often it is called."""

    def __init__(self):
        self.calls = 0

    async def __call__(self, scope, receive, send):
        self.calls += 1
        headers = [(b"content-type", b"text/plain"), (b"Content-Security-Policy", b"default-src *")]
        await send({"type": "http.response.start", "status": 200, "headers": headers})
        await send({"type": "http.response.body", "body": b"inside"})


def ask(*headers, path="/", query="", kind="http"):
    """(messages sent, calls of the application behind)."""
    behind, sent = Behind(), []

    async def receive():
        return {"type": "websocket.connect"}

    async def send(message):
        sent.append(message)

    scope = {"type": kind, "path": path, "query_string": query.encode(), "headers": list(headers)}
    asyncio.run(Guard(behind, TOKEN, PORT)(scope, receive, send))
    return sent, behind.calls


def status(*headers, **more):
    sent, calls = ask(*headers, **more)
    assert (calls == 1) == (sent[0]["status"] == 200)
    return sent[0]["status"]


def test_the_cookie_opens():
    assert status(HOST, COOKIE) == 200
    assert status((b"host", b"localhost:8000"), COOKIE) == 200
    assert status(HOST, COOKIE, (b"origin", b"http://127.0.0.1:8000")) == 200


@pytest.mark.parametrize(
    "cookie",
    [b"", b"simfield-8000=", b"simfield-8000=wrong", b"simfield-8001=" + TOKEN.encode(), b"\xff;=;", b"simfield-8000"],
)
def test_nothing_else_does(cookie):
    assert status(HOST, (b"cookie", cookie)) == 403


@pytest.mark.parametrize(
    "host",
    [
        *(b"", b"evil.example", b"evil.example:8000", b"127.0.0.1", b"127.0.0.1:8001", b"127.0.0.1:8000.evil.example"),
        *(b"0.0.0.0:8000", b"[::1]:8000", b"127.0.0.1:8000@evil.example"),
    ],
)
def test_a_foreign_host_is_refused_even_with_the_token(host):
    assert status((b"host", host), COOKIE) == 421
    assert status((b"host", host), query=f"token={TOKEN}") == 421


def test_a_missing_or_double_host_is_refused():
    assert status(COOKIE) == 421
    assert status(HOST, (b"host", b"evil.example"), COOKIE) == 421


@pytest.mark.parametrize("origin", [b"http://evil.example", b"null", b"https://127.0.0.1:8000", b"http://127.0.0.1"])
@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_a_foreign_origin_is_refused(origin, kind):
    sent, calls = ask(HOST, COOKIE, (b"origin", origin), kind=kind)
    assert calls == 0
    assert sent[0]["type"] == "websocket.close" if kind == "websocket" else sent[0]["status"] == 403


def test_a_websocket_needs_the_cookie():
    assert ask(HOST, kind="websocket")[0][0]["type"] == "websocket.close"
    assert ask(HOST, kind="websocket", query=f"token={TOKEN}")[1] == 0
    assert ask(HOST, COOKIE, kind="websocket")[1] == 1


def test_the_token_becomes_a_cookie_and_leaves_the_address():
    sent, calls = ask(HOST, path="/interval/", query=f"a=1&token={TOKEN}")
    headers = dict(sent[0]["headers"])
    assert (sent[0]["status"], calls) == (303, 0)
    assert headers[b"location"] == b"/interval/?a=1"
    assert headers[b"set-cookie"].split(b"; ")[1:] == [b"Path=/", b"HttpOnly", b"SameSite=Strict"]
    assert status(HOST, (b"cookie", headers[b"set-cookie"].split(b";")[0])) == 200


@pytest.mark.parametrize("path", ["//evil.example/", "/\\evil.example", "///evil.example"])
def test_the_redirection_stays_here(path):
    sent, _ = ask(HOST, path=path, query=f"token={TOKEN}")
    assert dict(sent[0]["headers"])[b"location"].startswith(b"/evil.example")


@pytest.mark.parametrize("token", ["", "wrong", TOKEN[:-1], TOKEN + "x", "\udcff", "ä"])
def test_a_wrong_token_is_refused(token):
    assert status(HOST, query=f"token={token.encode('utf-8', 'replace').decode()}") == 403


def test_files_with_a_hash_in_their_name_are_kept_by_the_browser():
    kept = (b"cache-control", b"private, max-age=86400, immutable")
    assert kept in ask(HOST, COOKIE, path="/interval/assets/index-1234.js")[0][0]["headers"]
    assert kept not in ask(HOST, COOKIE, path="/interval/")[0][0]["headers"]


def test_the_browser_is_forbidden_to_ask_others():
    sent, _ = ask(HOST, COOKIE)
    headers = [(name.lower(), value) for name, value in sent[0]["headers"]]
    policies = [value.decode() for name, value in headers if name == b"content-security-policy"]
    assert len(policies) == 1
    assert policies[0].startswith("default-src 'none';")
    sources = {word for part in policies[0].split(";") for word in part.split()[1:]}
    hosts = {source for source in sources if not source.startswith("'") and not source.endswith(":")}
    assert hosts == {"ws://127.0.0.1:8000", "ws://localhost:8000"}
    assert (b"referrer-policy", b"no-referrer") in headers
