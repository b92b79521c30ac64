"""Who may talk to the server of the pages."""

import asyncio

import pytest

from irtiming.web.guard import MOST_BYTES, Guard, Rules

TOKEN = "right-token"
HOST = "127.0.0.1:8321"
COOKIE = ("cookie", f"irtiming-8321={TOKEN}")
ORIGIN = ("origin", f"http://{HOST}")
UPLOAD = 5 * MOST_BYTES


def _answer(method="GET", path="/", query="", *, headers=(("host", HOST),), body=b"", kind="http"):
    """Status of the answer, and how many requests reached what is behind the guard."""
    reached, sent = [], []

    async def behind(scope, receive, send):
        reached.append(scope["path"])
        if scope["type"] == "http":
            while (await receive()).get("more_body"):
                pass
            await send({"type": "http.response.start", "status": 200, "headers": []})
            await send({"type": "http.response.body", "body": b""})

    async def receive():
        nonlocal body
        part, body = body[: 2**18], body[2**18 :]
        return {"type": "http.request", "body": part, "more_body": bool(body)}

    async def send(message):
        sent.append(message)

    scope = {
        "type": kind, "method": method, "path": path, "query_string": query.encode(),
        "headers": [(name.encode(), value.encode("latin-1")) for name, value in headers],
    }  # fmt: skip
    rules = Rules(hosts=(HOST, "localhost:8321"), token=TOKEN, cookie="irtiming-8321", upload_bytes=UPLOAD)
    asyncio.run(Guard(behind, rules=rules)(scope, receive, send))
    return sent[0].get("status") if sent else None, len(reached)


def test_the_token_is_taken_once_from_the_address_and_then_from_the_cookie():
    """Oracle: the rules; the first request is sent on to an address without the token, and reaches nothing."""
    assert _answer(query=f"token={TOKEN}") == (303, 0)
    assert _answer(headers=(("host", HOST), COOKIE)) == (200, 1)


@pytest.mark.parametrize(
    "request_",
    [
        {},
        {"query": "token=wrong"},
        {"query": "token="},
        {"query": f"token={TOKEN}&" + "&".join(f"a={n}" for n in range(16))},
        {"path": "/plan", "query": f"token={TOKEN}"},
        {"method": "POST", "query": f"token={TOKEN}"},
        {"headers": (COOKIE,)},
        {"headers": (("host", "evil.example"), COOKIE)},
        {"headers": (("host", f"{HOST}.evil.example"), COOKIE)},
        {"headers": (("host", HOST), ("host", "evil.example"), COOKIE)},
        {"headers": (("host", HOST), ("origin", "http://evil.example"), COOKIE)},
        {"headers": (("host", HOST), ("origin", "null"), COOKIE)},
        {"headers": (("host", HOST), ORIGIN, ("origin", "http://evil.example"), COOKIE)},
        {"method": "POST", "headers": (("host", HOST), COOKIE)},
        {"kind": "websocket", "headers": (("host", HOST), COOKIE)},
        {"kind": "websocket", "headers": (("host", HOST), ORIGIN)},
        {"headers": (("host", HOST), ("cookie", "irtiming-8321=")), "path": "/record"},
        {"headers": (("host", HOST), ("cookie", f"irtiming-8322={TOKEN}"))},
        {"headers": (("host", HOST), ("cookie", "x=" + "y" * 100_000 + f"; irtiming-8321={TOKEN}"))},
        {"headers": (("host", HOST), ("cookie", "irtiming-8321=\xe9\xff"))},
    ],
)
def test_what_lacks_token_host_or_origin_reaches_nothing(request_):
    """Oracle: the rules, one broken at a time."""
    status, reached = _answer(**request_)
    assert (status in (403, None), reached) == (True, 0)


@pytest.mark.parametrize(("path", "most"), [("/", MOST_BYTES), ("/_nicegui/client/1/upload/2", UPLOAD)])
def test_a_request_has_no_more_bytes_than_it_may(path, most):
    """Oracle: the sizes, told beforehand or not, one byte too many and just enough."""
    own = (("host", HOST), ORIGIN, COOKIE)
    told = (*own, ("content-length", str(most + 1)))
    assert _answer("POST", path, headers=told) == (413, 0)
    assert _answer("POST", path, headers=(*own, ("content-length", "-1"))) == (413, 0)
    assert _answer("POST", path, headers=own, body=bytes(most + 1)) == (413, 1)
    assert _answer("POST", path, headers=own, body=bytes(most)) == (200, 1)
