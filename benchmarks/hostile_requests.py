"""Hostile requests to `irtiming serve`: what is served that must not be, what changes on the disk, what memory it takes.

Usage, from the root of the checkout: python benchmarks/hostile_requests.py --requests 10000 --seed 1

Each request is drawn: method, path, token, Host, Origin, body and its stated length, sound or not. Those with the right token try
to leave the folder. Exit status 1 if anything outside is served, anything changes, the server breaks down or its memory grows by
more than `MOST_GROWTH_MIB`.
"""

import argparse
import random
import re
import socket
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import quote, urlsplit

CANARY = b"canary-that-must-not-sing"
MOST_GROWTH_MIB = 150
_ANSWER_S = 2.0

METHODS = (
    "GET",
    "GET",
    "GET",
    "HEAD",
    "POST",
    "PUT",
    "DELETE",
    "OPTIONS",
    "TRACE",
    "CONNECT",
    "PATCH",
    "get",
    "\x00GET",
)
OUTSIDE = (
    "../outside/secret.nxs", "..%2foutside%2fsecret.nxs", "%2e%2e/outside/secret.nxs", "/etc/passwd", "link.nxs",
    "way-out/secret.nxs", ".hidden.json", "notes.sh", "sub/../../outside/secret.nxs", "....//outside/secret.nxs",
    "..\\outside\\secret.nxs", "%252e%252e/outside/secret.nxs", "file:///etc/passwd", "run.nxs/../../outside/secret.nxs",
    "run.nxs%00.html", "~/x", "%c0%ae%c0%ae/outside/secret.nxs", "", ".", "..", "sub", "\u202e", "a" * 5000,
)  # fmt: skip
PLACES = (
    "/", "/plan", "/rig", "/record", "/library", "/analyse", "/campaigns", "/history", "/certificate", "/apply",
    "/live.jpg", "/nothing",
    "/openapi.json", "/docs", "/_nicegui/client/1/upload/1", "/_nicegui_ws/socket.io/?EIO=4&transport=polling",
    "/_nicegui_ws/socket.io/?EIO=4&transport=websocket", "//evil.example/", "/look/page.css",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Served:
    """A server: its process and address, the folder of everything, with ``lab`` (served) and ``outside``, and what it said."""

    process: subprocess.Popen
    address: str
    around: Path
    said: Path

    @property
    def host(self) -> str:
        return urlsplit(self.address).netloc

    @property
    def token(self) -> str:
        return self.address.split("token=")[1]

    @property
    def port(self) -> int:
        return int(self.host.split(":")[1])


@contextmanager
def served(around: Path) -> Iterator[Served]:
    """A server of the folder ``lab`` in ``around``, on any port that is free, until the block ends."""
    (around / "lab").mkdir(exist_ok=True)
    command = [sys.executable, "-m", "irtiming", "serve", str(around / "lab"), "--port", "0", "--upload-mib", "1"]
    said = around.parent / f"{around.name}-said.txt"
    with said.open("wb") as output, subprocess.Popen(command, stdout=output, stderr=subprocess.STDOUT) as process:
        while "\n" not in said.read_text() and process.poll() is None:
            time.sleep(0.05)
        line = said.read_text().split("\n")[0]
        if not line.startswith("open http"):
            process.kill()
            raise RuntimeError(f"the server did not begin: {said.read_text()}")
        try:
            yield Served(process=process, address=line.removeprefix("open "), around=around, said=said)
        finally:
            process.terminate()
            try:
                process.wait(30)
            except subprocess.TimeoutExpired:
                process.kill()


def lay_out(around: Path) -> None:
    """Files within and outside, some of them hidden, links, or of a kind that is not served."""
    for name in ("lab/sub", "outside"):
        (around / name).mkdir(parents=True)
    (around / "lab" / "run.nxs").write_bytes(b"inside, and no recording")
    for name in ("outside/secret.nxs", "lab/.hidden.json", "lab/notes.sh"):
        (around / name).write_bytes(CANARY)
    (around / "lab" / "link.nxs").symlink_to(around / "outside" / "secret.nxs")
    (around / "lab" / "way-out").symlink_to(around / "outside")


def state(around: Path) -> list[tuple[str, int, int]]:
    """Every file with its size and when it changed."""
    return sorted(
        (str(one.relative_to(around)), one.lstat().st_size, one.lstat().st_mtime_ns) for one in around.rglob("*")
    )


@dataclass(frozen=True, kw_only=True)
class Request:
    """One request, and whether it has what a browser of the right person has: token, Host and, where it must, Origin.

    Of one that ``is_cut`` the end never comes; who asked one that ``leaves`` does not wait for the answer.
    """

    content: bytes
    is_right: bool = True
    is_cut: bool = False
    leaves: bool = False


def request(rng: random.Random, found: Served) -> Request:
    """Any request."""
    method = rng.choice(METHODS)
    path = rng.choice(PLACES)
    if rng.random() < 0.6:
        name = rng.choice(OUTSIDE)
        name = quote(name) if rng.random() < 0.5 else name.replace(" ", "+")
        path = rng.choice((f"/file?name={name}", f"/picture?name={name}&width=96", f"/library?file={name}", f"/look/{name}",
                           f"/_nicegui/3/static/{name}", f"/{name}", f"/analyse?result={name}"))  # fmt: skip
    if rng.random() < 0.1:
        path += (
            "&" if "?" in path else "?"
        ) + f"token={rng.choice((found.token[:-1], '', 'x' * 3000, found.token.upper()))}"
    path = re.sub(r"[\x00-\x20\x7f]", "+", path)
    hosts = rng.choice(
        ([found.host],) * 5 + ([], ["evil.example"], [found.host, "evil.example"], [f"{found.host}.evil.example"])
    )
    origins = rng.choice(([], [f"http://{found.host}"], [f"http://{found.host}"], ["http://evil.example"], ["null"]))
    has_token = rng.random() < 0.4
    cookie = found.token if has_token else rng.choice(("", "wrong", found.token[::-1], "\xff" * 50, "x" * 20_000))
    lines = [f"{method} {path} HTTP/1.1", *(f"Host: {one}" for one in hosts), *(f"Origin: {one}" for one in origins)]
    lines.append(f"Cookie: irtiming-{found.port}={cookie}")
    body = b""
    if rng.random() < 0.3:
        body = rng.randbytes(rng.choice((0, 10, 5000, 200_000, 3_000_000)))
        told = rng.choice((str(len(body)), str(len(body)), "99999999999999", "-5", "1e9", "chunked"))
        lines.append("Transfer-Encoding: chunked" if told == "chunked" else f"Content-Length: {told}")
        if told == "chunked":
            body = f"{len(body):x}\r\n".encode() + body + b"\r\n0\r\n\r\n"
    if rng.random() < 0.05:
        lines += [
            "Upgrade: websocket",
            "Connection: Upgrade",
            "Sec-WebSocket-Version: 13",
            "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==",
        ]
    else:
        lines.append("Connection: close")
    lines += [f"X-{number}: {'y' * 200}" for number in range(rng.choice((0, 0, 0, 3, 200)))]
    content = "\r\n".join(lines).encode("utf-8", "replace") + b"\r\n\r\n" + body
    is_cut = rng.random() < 0.05
    if is_cut:
        content = content[: rng.randrange(1, len(content))]
    right = has_token and hosts == [found.host] and "evil" not in str(origins) and "null" not in origins
    return Request(content=content, is_right=right, is_cut=is_cut, leaves=rng.random() < 0.05)


def answer(found: Served, asked: Request) -> bytes:
    """All that the server says to a request; nothing where the one who asked leaves at once."""
    said = b""
    with suppress(OSError), socket.create_connection(("127.0.0.1", found.port), timeout=_ANSWER_S) as line:
        with suppress(OSError):
            line.sendall(asked.content)
        if asked.leaves:
            return b""
        if asked.is_cut:
            line.shutdown(socket.SHUT_WR)
        while len(said) < 2**21 and (part := line.recv(2**16)):
            said += part
    return said


def memory_mib(pid: int) -> float:
    """Resident memory of a process."""
    text = Path(f"/proc/{pid}/status").read_text()
    return int(re.findall(r"VmRSS:\s+(\d+) kB", text)[0]) / 1024


def attack(found: Served, *, n: int, seed: int) -> tuple[Counter[str], list[str]]:
    """How often each status came, and every answer that must not be."""
    rng, counts, wrong = random.Random(seed), Counter[str](), list[str]()
    for number in range(n):
        asked = request(rng, found)
        said = answer(found, asked)
        status = said[9:12].decode("latin-1") if said.startswith(b"HTTP/1.1 ") else "none"
        counts[status] += 1
        first = asked.content.split(b"\r\n")[0][:150]
        if CANARY in said or b"root:" in said:
            wrong.append(f"{number}: {first!r} got what is outside")
        refused = ("400", "403", "413", "none", *(["405"] if b"Upgrade: websocket" in asked.content else []))
        if not asked.is_right and status not in refused:
            wrong.append(f"{number}: {first!r} without token, Host or Origin got {status}")
        if status.startswith("5") and status != "503":
            wrong.append(f"{number}: {first!r} got {status}")
    return counts, wrong


def is_alive(found: Served) -> bool:
    """Whether the first page still comes to the right person."""
    cookie = f"Cookie: irtiming-{found.port}={found.token}"
    asked = f"GET / HTTP/1.1\r\nHost: {found.host}\r\n{cookie}\r\nConnection: close\r\n\r\n".encode()
    return answer(found, Request(content=asked)).startswith(b"HTTP/1.1 200")


def main() -> int:
    """Exit status 1 if anything is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--requests", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        around = Path(place).resolve() / "all"
        lay_out(around)
        before = state(around)
        with served(around) as found:
            assert is_alive(found)
            time.sleep(6)  # what is loaded after the first page
            first_mib, begun = memory_mib(found.process.pid), time.monotonic()
            counts, wrong = attack(found, n=given.requests, seed=given.seed)
            lasted_s = time.monotonic() - begun
            last_mib = memory_mib(found.process.pid)
            if not is_alive(found):
                wrong.append("the server has broken down")
            if "Traceback" in (said := found.said.read_text()):
                wrong.append(f"the server said: {said[-2000:]}")
        if state(around) != before:
            wrong.append("something changed on the disk")
        if last_mib - first_mib > MOST_GROWTH_MIB:
            wrong.append("the server's memory has grown")
    print(f"{given.requests} requests of seed {given.seed} in {lasted_s:.0f} s; answers: {dict(counts.most_common())}")
    print(f"memory of the server: {first_mib:.0f} MiB before, {last_mib:.0f} MiB after")
    print(f"{len(wrong)} wrong")
    for text in wrong[:20]:
        print(text)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
