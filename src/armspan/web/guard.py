"""Who may come in: on this machine every page of ours, from elsewhere only who has the token; never another site.

A page of another site that is open in the same browser can send requests here. Its ``Origin`` gives it away, and a
name that was made to point here (DNS rebinding) gives itself away as ``Host``.
"""

import html
import secrets
from collections.abc import Mapping
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs, urlencode, urlsplit

from starlette.responses import HTMLResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

COOKIE = "armspan_token"
LOCAL = frozenset({"127.0.0.1", "localhost", "[::1]"})
"""Names of this machine under which the page is served without a token."""

_POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; font-src 'self' data:; connect-src 'self'; frame-ancestors 'none'; "
    "form-action 'self'; base-uri 'self'"
)
_ASK = """<!doctype html><html lang="en"><head><meta charset="utf-8"><title>Armspan</title>
<meta name="viewport" content="width=device-width, initial-scale=1"></head>
<body style="font: 20px sans-serif; max-width: 34em; margin: 3em auto; padding: 0 1em">
<h1>Armspan</h1><p>{words}</p>
<form method="get" action="/"><label>Token <input name="token" autofocus autocomplete="off" style="font: inherit">
</label> <button style="font: inherit">Enter</button></form></body></html>"""


class Guard:
    """An ASGI middleware before everything else, WebSockets included.

    ``token`` None serves only under the names of this machine.
    """

    def __init__(self, app: ASGIApp, token: str | None) -> None:
        self._app, self._token = app, token

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Let a request in, or answer it here."""
        if scope["type"] not in ("http", "websocket"):
            await self._app(scope, receive, send)
            return
        headers = {key.decode("latin-1").lower(): value.decode("latin-1") for key, value in scope["headers"]}
        answer = self._refused(scope, headers)
        if answer is None:
            await self._let_in(scope, receive, send)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008, "reason": "not allowed"})
        else:
            await answer(scope, receive, send)

    async def _let_in(self, scope: Scope, receive: Receive, send: Send) -> None:
        try:
            await self._app(scope, receive, _with_policy(send) if scope["type"] == "http" else send)
        except RuntimeError as error:
            if str(error) != "No response returned.":  # Starlette's word for a browser that went before its answer
                raise

    def _refused(self, scope: Scope, headers: Mapping[str, str]) -> Response | None:
        host = headers.get("host", "")
        if self._token is None and _name(host) not in LOCAL:
            return _plain(f"This page is served on this machine only: open it as http://127.0.0.1:{_port(host)}/")
        origin = headers.get("origin")
        if origin is not None and urlsplit(origin).netloc.lower() != host.lower():
            return _plain("Requests of other sites are refused")
        return None if self._token is None else self._asked(scope, headers, self._token)

    def _asked(self, scope: Scope, headers: Mapping[str, str], token: str) -> Response | None:
        """What somebody without the token sees; who brings it in the address gets a cookie."""
        if same(_cookie(headers), token):
            return None
        query = parse_qs(scope.get("query_string", b"").decode("latin-1"))
        told = query.pop("token", [""])[0]
        if scope["type"] == "http" and same(told, token):
            rest = urlencode(query, doseq=True)
            answer = RedirectResponse(scope["path"] + (f"?{rest}" if rest else ""), status_code=303)
            answer.set_cookie(COOKIE, token, httponly=True, samesite="lax")
            return answer
        words = "That token is wrong. " if told else ""
        words += "This page asks for the token that the terminal shows in which Armspan was started."
        return HTMLResponse(_ASK.format(words=html.escape(words)), status_code=403 if told else 401)


def same(told: str, token: str) -> bool:
    """Whether two tokens are the same, in a time that says nothing of where they differ."""
    return secrets.compare_digest(told.encode(), token.encode())


def _cookie(headers: Mapping[str, str]) -> str:
    try:
        found = SimpleCookie(headers.get("cookie", "")).get(COOKIE)
    except CookieError:
        return ""
    return found.value if found else ""


def _name(host: str) -> str:
    return host.rpartition(":")[0].lower() if host.rpartition("]")[2].count(":") else host.lower()


def _port(host: str) -> str:
    return host.rpartition(":")[2] if ":" in host else "80"


def _plain(words: str) -> Response:
    return Response(words + "\n", status_code=403, media_type="text/plain")


def _with_policy(send: Send) -> Send:
    async def told(message: "dict[str, object]") -> None:
        if message["type"] == "http.response.start":
            headers = message.setdefault("headers", [])
            headers.append((b"content-security-policy", _POLICY.encode()))  # type: ignore[attr-defined]
            headers.append((b"referrer-policy", b"same-origin"))  # type: ignore[attr-defined]
        await send(message)

    return told  # type: ignore[return-value]
