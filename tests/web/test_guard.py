import asyncio

import pytest

from armspan.web.guard import COOKIE, Guard, same


async def inner(scope, receive, send):
    if scope["type"] == "websocket":
        await send({"type": "websocket.accept"})
        return
    await send({"type": "http.response.start", "status": 200, "headers": []})
    await send({"type": "http.response.body", "body": b"inside"})


def asked(token=None, kind="http", path="/", query="", **headers):
    """What comes back from a guarded page: its messages."""
    sent = []

    async def send(message):
        sent.append(message)

    async def receive():
        return {"type": f"{kind}.connect" if kind == "websocket" else "http.request"}

    told = {"host": "127.0.0.1:8080"} | headers
    scope = {
        "type": kind,
        "method": "GET",
        "path": path,
        "query_string": query.encode(),
        "headers": [(key.encode(), value.encode()) for key, value in told.items()],
    }
    asyncio.run(Guard(inner, token)(scope, receive, send))
    return sent


def status(messages):
    return messages[0].get("status", messages[0]["type"])


@pytest.mark.parametrize("host", ["127.0.0.1:8080", "localhost:8080", "LOCALHOST", "[::1]:8080"])
def test_this_machine_comes_in_without_a_token(host):
    sent = asked(host=host, origin=f"http://{host}")
    assert status(sent) == 200
    assert b"frame-ancestors 'none'" in dict(sent[0]["headers"])[b"content-security-policy"]


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example:8080", "192.168.0.7:8080", ""])
def test_a_name_that_was_made_to_point_here_is_refused(host):
    sent = asked(host=host)
    assert status(sent) == 403
    assert b"this machine only" in sent[1]["body"]


@pytest.mark.parametrize("origin", ["http://evil.example", "http://127.0.0.1:9999", "null"])
@pytest.mark.parametrize("token", [None, "secret"])
def test_other_sites_are_refused_on_the_web_socket_too(origin, token):
    cookie = {"cookie": f"{COOKIE}=secret"}
    assert status(asked(token, origin=origin, **cookie)) == 403
    [closed] = asked(token, "websocket", origin=origin, **cookie)
    assert (closed["type"], closed["code"]) == ("websocket.close", 1008)


def test_from_elsewhere_the_token_is_asked_for():
    elsewhere = {"host": "192.168.0.7:8080"}
    assert status(asked("secret", **elsewhere)) == 401
    assert status(asked("secret", query="token=wrong", **elsewhere)) == 403
    assert status(asked("secret", cookie=f"{COOKIE}=wrong", **elsewhere)) == 401
    assert status(asked("secret", "websocket", **elsewhere)) == "websocket.close"
    assert status(asked("secret", "websocket", query="token=secret", **elsewhere)) == "websocket.close"


def test_a_wrong_token_is_said_in_place():
    body = asked("secret", query="token=%3Cb%3E")[1]["body"]
    assert b"That token is wrong" in body
    assert b"<b>" not in body


def test_the_token_becomes_a_cookie_and_leaves_the_address():
    sent = asked("secret", path="/master", query="token=secret&x=1")
    headers = dict(sent[0]["headers"])
    assert (status(sent), headers[b"location"]) == (303, b"/master?x=1")
    assert b"HttpOnly" in headers[b"set-cookie"]
    assert status(asked("secret", cookie=f"a=b; {COOKIE}=secret")) == 200
    assert status(asked("secret", "websocket", cookie=f"{COOKIE}=secret")) == "websocket.accept"


def test_tokens_are_compared_whole():
    assert same("secret", "secret")
    assert not same("secre", "secret")
    assert not same("sécret", "secret")


def test_what_is_no_request_passes():
    sent = []

    async def app(scope, receive, send):
        sent.append(scope["type"])

    asyncio.run(Guard(app, "secret")({"type": "lifespan"}, None, None))
    assert sent == ["lifespan"]
