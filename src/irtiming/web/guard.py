"""Who may talk to the server: whoever has the token, from a page of the server itself, in requests of a bounded size."""

import hmac
from collections.abc import Awaitable, Callable, Iterable, MutableMapping
from dataclasses import dataclass
from http.cookies import CookieError, SimpleCookie
from typing import Any, Literal, TypeAlias, final
from urllib.parse import parse_qs

Scope: TypeAlias = MutableMapping[str, Any]
Message: TypeAlias = MutableMapping[str, Any]
Receive: TypeAlias = Callable[[], Awaitable[Message]]
Send: TypeAlias = Callable[[Message], Awaitable[None]]
App: TypeAlias = Callable[[Scope, Receive, Send], Awaitable[None]]
Headers: TypeAlias = list[tuple[bytes, bytes]]

MOST_BYTES = 2**20
"""Of a request that is no upload."""

_SAFE = ("GET", "HEAD")
_COOKIE_BYTES = 8192
_FIELDS = 16  # of an address, at most
_POLICY = (
    "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
    "img-src 'self' data: blob:; object-src 'none'; frame-ancestors 'self'; base-uri 'self'; form-action 'self'"
)
_HEADERS: Headers = [
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cross-origin-opener-policy", b"same-origin"),
    (b"cross-origin-resource-policy", b"same-origin"),
]


@final
@dataclass(frozen=True, kw_only=True)
class Rules:
    """What a request must have: one of the ``hosts`` as its Host, with port, and the token in a cookie or the address.

    ``upload_bytes`` is the most that an upload may have.
    """

    hosts: tuple[str, ...]
    token: str
    cookie: str
    upload_bytes: int

    @property
    def origins(self) -> tuple[str, ...]:
        """Of pages of the server itself."""
        return tuple(f"http://{host}" for host in self.hosts)


@final
class _TooLarge(Exception):  # noqa: N818 - says what the request is
    """A request with more bytes than it may have."""


@final
class Guard:
    """Stands before the whole server; what it refuses reaches nothing behind it.

    Parameters
    ----------
    app
        The server.
    rules
        What a request must have.
    """

    def __init__(self, app: App, *, rules: Rules) -> None:
        self._app, self._rules = app, rules

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request, or one line that stays open."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if (why := self._complaint(scope)) is not None:
            await _refuse(scope, send, why)
        elif scope["type"] == "http" and self._token_in_address(scope):
            await self._admit(scope, send)
        elif scope["type"] == "http":
            await self._bounded(scope, receive, send)
        else:
            await self._opened(scope, receive, send)

    async def _opened(self, scope: Scope, receive: Receive, send: Send) -> None:
        """A line that stays open, if who asked for it is still there."""
        first: list[Message] = [await receive()]
        if first[0]["type"] != "websocket.connect":
            return

        async def replayed() -> Message:
            return first.pop() if first else await receive()

        await self._app(scope, replayed, send)

    def _complaint(self, scope: Scope) -> str | None:
        headers: Headers = scope["headers"]
        if _the_one(headers, b"host") not in self._rules.hosts:
            return "this server has another name; open the address that irtiming serve printed"
        origins = [value.decode("latin-1") for name, value in headers if name == b"origin"]
        is_plain = scope["type"] == "http" and scope["method"] in _SAFE
        if any(origin not in self._rules.origins for origin in origins) or (not is_plain and len(origins) != 1):
            return "the request comes from a page of another server"
        if not (is_plain and self._token_in_address(scope)) and not self._is_known(headers):
            return "this page needs its token; open the address that irtiming serve printed"
        return None

    def _token_in_address(self, scope: Scope) -> bool:
        if scope["path"] != "/":
            return False
        try:
            given = parse_qs(scope["query_string"].decode("latin-1"), max_num_fields=_FIELDS)
        except ValueError:  # there are more
            return False
        return any(self._is_token(one) for one in given.get("token", ()))

    def _is_known(self, headers: Headers) -> bool:
        text = "; ".join(value.decode("latin-1") for name, value in headers if name == b"cookie")
        if len(text) > _COOKIE_BYTES:
            return False
        try:
            found = SimpleCookie(text).get(self._rules.cookie)
        except CookieError:
            return False
        return found is not None and self._is_token(found.value)

    def _is_token(self, text: str) -> bool:
        return hmac.compare_digest(text.encode("utf-8", "replace"), self._rules.token.encode())

    async def _admit(self, scope: Scope, send: Send) -> None:
        """The token goes from the address, where others may read it, into a cookie that no script reads."""
        cookie = f"{self._rules.cookie}={self._rules.token}; Path=/; HttpOnly; SameSite=Strict"
        headers = [(b"location", b"/"), (b"set-cookie", cookie.encode()), (b"cache-control", b"no-store"), *_HEADERS]
        await _answer(send, status=303, headers=headers)

    async def _bounded(self, scope: Scope, receive: Receive, send: Send) -> None:
        """The server behind, which never sees more bytes than there may be."""
        most = self._rules.upload_bytes if "/upload/" in scope["path"] else MOST_BYTES
        announced = _the_one(scope["headers"], b"content-length")
        if announced is not None and (not announced.isdecimal() or len(announced) > 18 or int(announced) > most):
            await _refuse(scope, send, f"a request of {announced:.20} bytes; it may have {most}", status=413)
            return
        received, has_begun, has_left = 0, False, False

        async def counted() -> Message:
            nonlocal received, has_left
            message = await receive()
            has_left = has_left or message["type"] == "http.disconnect"
            received += len(message.get("body", b""))
            if received > most:
                raise _TooLarge
            return message

        async def marked(message: Message) -> None:
            nonlocal has_begun
            if message["type"] == "http.response.start":
                has_begun = True
                message["headers"] = _with_policy(message["headers"])
            await send(message)

        try:
            await self._app(scope, counted, marked)
        except Exception:
            if has_left:  # what is behind complains of a browser that goes before it has its answer
                return
            if received <= most or has_begun:
                raise
            await _refuse(scope, send, f"a request of more than {most} bytes", status=413)


def _the_one(headers: Headers, name: bytes) -> str | None:
    """The value of a header that is there once; None where it is not there, or twice."""
    found = [value.decode("latin-1") for key, value in headers if key == name]
    return found[0] if len(found) == 1 else None


def _with_policy(headers: Iterable[tuple[bytes, bytes]]) -> Headers:
    """The headers of an answer, with what a browser may load for it: nothing from other hosts."""
    kept = list(headers)
    own = any(name == b"content-security-policy" for name, _ in kept)
    return [*kept, *_HEADERS, *([] if own else [(b"content-security-policy", _POLICY.encode())])]


async def _refuse(scope: Scope, send: Send, why: str, *, status: Literal[403, 413] = 403) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 1008, "reason": why[:100]})
        return
    headers = [(b"content-type", b"text/plain; charset=utf-8"), (b"connection", b"close"), *_HEADERS]
    await _answer(send, status=status, headers=headers, body=f"irtiming: {why}\n".encode())


async def _answer(send: Send, *, status: int, headers: Headers, body: bytes = b"") -> None:
    headers = [*headers, (b"content-length", str(len(body)).encode())]
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
