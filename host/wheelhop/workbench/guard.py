"""Who may talk to the workbench: the browser that was given the address with its token.

Other pages in the same browser can send requests to 127.0.0.1, too, and names that a stranger owns
can be made to point there (DNS rebinding). So every request must name us as Host, come from our own
pages if it says where it comes from, and bring the token: once in the address, then as a cookie.
"""

from __future__ import annotations

import socket
from collections.abc import Awaitable, Callable, Iterator, MutableMapping
from hmac import compare_digest
from http.cookies import CookieError, SimpleCookie
from ipaddress import ip_address
from secrets import token_urlsafe
from typing import Any
from urllib.parse import parse_qs

Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[MutableMapping[str, Any]]]
Send = Callable[[MutableMapping[str, Any]], Awaitable[None]]
App = Callable[[Scope, Receive, Send], Awaitable[None]]

POLICY = (
    "default-src 'self'; script-src 'self' 'nonce-{nonce}' 'unsafe-eval'; object-src 'none';"
    " style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:;"
    " frame-ancestors 'none'; base-uri 'none'; form-action 'self'"
)
"""Nothing is fetched from anywhere else, and no script runs that is not in a file of ours or marked
with the nonce of this answer: none in an attribute, none that came with somebody's names. The
page's framework cannot do without eval, in which it compiles templates and runs what the server
asks for, nor without styles in attributes."""
NONCE = "wheelhop.nonce"
"""Under which a request's scope holds the nonce of its answer."""


LOCAL, EVERYWHERE = "127.0.0.1", "0.0.0.0"


def known_as(host: str) -> Callable[[str], bool]:
    """Whether a name is one of ours, if we listen on `host`.

    On all interfaces, every IPv4 address is: no stranger can make a number point here, and which
    numbers are ours the system knows. Of names, only this computer's own.
    """
    if host != EVERYWHERE:
        names = {host, "localhost"} if host == LOCAL else {host}
        return names.__contains__
    own = {"localhost", socket.gethostname().lower(), socket.getfqdn().lower()}
    return lambda name: name.lower() in own or _is_number(name)


def _is_number(name: str) -> bool:
    try:
        ip_address(name)
    except ValueError:
        return False
    return True


class Guard:
    """Passes requests on to an ASGI application if they may: `ours` tells whether we are known by a
    name, and `port` is the one we listen on."""

    def __init__(self, app: App, token: str, ours: Callable[[str], bool], port: int) -> None:
        self._app = app
        self._token = token
        self._ours = ours
        self._port = port
        self._cookie = f"wheelhop-{port}"  # its name must tell ports apart, as cookies do not

    def _is_us(self, host: str) -> bool:
        name, _, port = host.rpartition(":")
        return port == str(self._port) and self._ours(name)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        elif refusal := self._refusal(scope):
            await _refuse(scope, send, refusal)
        elif self._in_address(scope):
            await self._let_in(scope, send)
        elif self._in_cookie(scope):
            scope[NONCE] = token_urlsafe(16)
            await self._app(scope, receive, _with_policy(send, scope[NONCE]))
        else:
            line = "the address lacks its token: open the one that wheelhop workbench printed"
            await _refuse(scope, send, line)

    def _refusal(self, scope: Scope) -> str:
        hosts = list(_header(scope, b"host"))
        if len(hosts) != 1 or not self._is_us(hosts[0]):
            return "this is not the name the workbench is known by"
        for origin in _header(scope, b"origin"):
            if origin.partition("://")[2] != hosts[0]:
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


def _with_policy(send: Send, nonce: str) -> Send:
    async def sending(message: MutableMapping[str, Any]) -> None:
        if message["type"] == "http.response.start":
            policy = POLICY.format(nonce=nonce)
            message["headers"] = [
                *message.get("headers", []),
                (b"content-security-policy", policy.encode()),
                (b"x-content-type-options", b"nosniff"),
                (b"referrer-policy", b"no-referrer"),
            ]
        await send(message)

    return sending


async def _refuse(scope: Scope, send: Send, line: str) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": line})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8")]
    await send({"type": "http.response.start", "status": 403, "headers": headers})
    await send({"type": "http.response.body", "body": f"wheelhop: {line}\n".encode()})
