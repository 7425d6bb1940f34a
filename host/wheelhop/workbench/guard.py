"""Who may talk to the workbench: the browser that was given the address with its token.

Other pages in the same browser can send requests to 127.0.0.1, too, and names that a stranger owns
can be made to point there (DNS rebinding). So every request must name us as Host, come from our own
pages if it says where it comes from, and bring the token: once in the address, then as a cookie.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Iterator, MutableMapping
from hmac import compare_digest
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

POLICY = (
    "default-src 'self' 'unsafe-inline' 'unsafe-eval' data: blob:; connect-src 'self';"
    " frame-ancestors 'none'; base-uri 'none'; form-action 'self'"
)
"""Nothing is fetched from anywhere else. The page's framework compiles its templates, 'eval'."""


class Guard:
    """Passes requests on to an ASGI application if they may; `hosts` are the values of Host, with
    the port, by which we are known."""

    def __init__(self, app: App, token: str, hosts: frozenset[str]) -> None:
        self._app = app
        self._token = token
        self._hosts = hosts

    @property
    def _cookie(self) -> str:
        """A cookie's name does not know of ports: two workbenches must not share one."""
        return f"wheelhop-{min(self._hosts).rpartition(':')[2]}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        elif refusal := self._refusal(scope):
            await _refuse(scope, send, refusal)
        elif self._in_address(scope):
            await self._let_in(scope, send)
        elif self._in_cookie(scope):
            await self._app(scope, receive, _with_policy(send))
        else:
            line = "the address lacks its token: open the one that wheelhop workbench printed"
            await _refuse(scope, send, line)

    def _refusal(self, scope: Scope) -> str:
        hosts = list(_header(scope, b"host"))
        if len(hosts) != 1 or hosts[0] not in self._hosts:
            return "this is not the name the workbench is known by"
        for origin in _header(scope, b"origin"):
            if origin.partition("://")[2] not in self._hosts:
                return "requests of other pages are not answered"
        return ""

    def _in_address(self, scope: Scope) -> bool:
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [])
        return scope["type"] == "http" and any(map(self._is_token, given))

    def _in_cookie(self, scope: Scope) -> bool:
        for header in _header(scope, b"cookie"):
            try:
                morsel = SimpleCookie(header).get(self._cookie)
            except CookieError:
                continue
            if morsel is not None and self._is_token(morsel.value):
                return True
        return False

    def _is_token(self, given: str) -> bool:
        return compare_digest(given.encode("utf-8", "replace"), self._token.encode())

    async def _let_in(self, scope: Scope, send: Send) -> None:
        """To the same page without the token, which then is in no history and no bookmark."""
        cookie = f"{self._cookie}={self._token}; HttpOnly; SameSite=Strict; Path=/"
        headers = [(b"location", scope["path"].encode()), (b"set-cookie", cookie.encode())]
        await send({"type": "http.response.start", "status": 303, "headers": headers})
        await send({"type": "http.response.body", "body": b""})


def _header(scope: Scope, name: bytes) -> Iterator[str]:
    return (value.decode("latin-1") for key, value in scope["headers"] if key == name)


def _with_policy(send: Send) -> Send:
    async def sending(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            policy = (b"content-security-policy", POLICY.encode())
            message["headers"] = [*message.get("headers", []), policy]
        await send(message)

    return sending


async def _refuse(scope: Scope, send: Send, line: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": line})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": "http.response.start", "status": 403, "headers": headers})
    await send({"type": "http.response.body", "body": f"wheelhop: {line}\n".encode()})
