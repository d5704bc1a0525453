"""Who may have what of the page: decided by an HTTP request alone. Pure but for reading files.

A browser that shows a page of somebody else's may still be made to ask for ours: by a link, a form,
a script, or a name that suddenly means this machine. Four things keep such requests out. The Host
has to be one of ours, exactly. The token is known to whom the launcher printed it for only. It
travels in the address once and then in a cookie that neither scripts nor other sites' requests
carry. And the socket, by which all actions go, has to name one of our origins, exactly.
"""

import hmac
from collections.abc import Mapping
from http.cookies import CookieError, SimpleCookie
from pathlib import Path
from typing import NamedTuple
from urllib.parse import parse_qs, urlsplit

from nodes.hmi.address import Address
from nodes.hmi.protocol.values import Role

SOCKET = "/socket"
_TYPES = {
    ".css": "text/css",
    ".html": "text/html",
    ".js": "text/javascript",
    ".stl": "model/stl",
    ".svg": "image/svg+xml",
}
_UNKNOWN = (
    "This page needs the address that was printed when the robot was started:\n"
    "a line that begins with `page:`. Open that one.\n"
)
_ENTRY = (
    '<!doctype html><meta charset="utf-8"><meta http-equiv="refresh" content="0;url=/">'
    '<link rel="icon" href="/icon.svg" type="image/svg+xml">'
    '<title>MSMA</title><p><a href="/">Go on</a></p>\n'
)
"""Leads on without the token in the address; a page of ours, so the browser sends the cookie.

It names the icon, since browsers ask for another one of each page that names none.
"""


class Reply(NamedTuple):
    """What to answer: status, headers and body."""

    status: int
    headers: Mapping[str, str]
    body: bytes = b""


class Entry(NamedTuple):
    """The socket may be opened, for that role."""

    role: Role


class Doorkeeper:
    """Answers requests for the page.

    Args:
        address: The page's origin and tokens.
        names: Host names or addresses, without port, by which browsers may call it.
        folder: The page's files.
        extra: Other files, by the path of the request.
    """

    def __init__(
        self, address: Address, names: tuple[str, ...], folder: Path, extra: Mapping[str, Path]
    ) -> None:
        scheme = urlsplit(address.origin).scheme
        usual = {"http": 80, "https": 443}[scheme]
        self._tokens: dict[str, Role] = {address.operator: "operator", address.engineer: "engineer"}
        self.hosts = {f"{name}:{address.port}" for name in names}
        if address.port == usual:
            self.hosts |= set(names)
        self.origins = {f"{scheme}://{host}" for host in self.hosts}
        self._cookie = f"msma-{address.port}"  # browsers do not keep cookies apart by port
        secure = "; Secure" if scheme == "https" else ""
        self._cookie_end = f"; HttpOnly; SameSite=Strict; Path=/{secure}"
        sockets = " ".join(sorted(one.replace("http", "ws", 1) for one in self.origins))
        self._headers = {
            "Content-Security-Policy": (
                f"default-src 'self'; connect-src 'self' {sockets}; frame-ancestors 'none'; "
                "base-uri 'none'; form-action 'none'; object-src 'none'"
            ),
            "Cross-Origin-Opener-Policy": "same-origin",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
            "Cache-Control": "no-store",
        }
        self._files = {
            "/" + file.relative_to(folder).as_posix(): file
            for file in sorted(folder.rglob("*"))
            if file.is_file() and file.resolve().is_relative_to(folder.resolve())
        } | dict(extra)
        if "/index.html" in self._files:
            self._files["/"] = self._files["/index.html"]

    def answer(self, path: str, headers: Mapping[str, list[str]]) -> Reply | Entry:
        """Answer a GET request for a path (with query), with headers by lower-case names."""
        if headers.get("host", []) not in [[host] for host in self.hosts]:
            return self._text(421, "This is not the host that the page is served on.\n")
        path, _, query = path.partition("?")
        origins = headers.get("origin", [])
        if path == SOCKET:
            role = self._role_by_cookie(headers)
            if len(origins) != 1 or origins[0] not in self.origins or role is None:
                return self._text(403, _UNKNOWN)
            return Entry(role)
        if any(origin not in self.origins for origin in origins):
            return self._text(403, _UNKNOWN)
        if path == "/" and (given := parse_qs(query).get("token")):
            if self._role(given[0]) is None:
                return self._text(403, _UNKNOWN)
            cookie = f"{self._cookie}={given[0]}{self._cookie_end}"
            return self._reply(200, _ENTRY.encode(), "text/html; charset=utf-8", cookie)
        if self._role_by_cookie(headers) is None:
            return self._text(403, _UNKNOWN)
        file = self._files.get(path)
        if file is None:
            return self._text(404, "There is no such file.\n")
        try:
            return self._reply(200, file.read_bytes(), _type_of(file))
        except OSError:
            return self._text(404, "There is no such file any more.\n")

    def text(self, status: int, said: str) -> Reply:
        """Return an answer in plain text."""
        return self._text(status, said)

    def _role(self, token: str) -> Role | None:
        """Return the role that a token gives, compared in a time that says nothing of it."""
        sent = token.encode(errors="replace")
        for known, role in self._tokens.items():
            if hmac.compare_digest(sent, known.encode()):
                return role
        return None

    def _role_by_cookie(self, headers: Mapping[str, list[str]]) -> Role | None:
        jar: SimpleCookie = SimpleCookie()
        try:
            jar.load("; ".join(headers.get("cookie", [])))
        except CookieError:
            return None
        return self._role(jar[self._cookie].value) if self._cookie in jar else None

    def _text(self, status: int, said: str) -> Reply:
        return self._reply(status, said.encode(), "text/plain; charset=utf-8")

    def _reply(self, status: int, body: bytes, kind: str, cookie: str = "") -> Reply:
        headers = {**self._headers, "Content-Type": kind, "Content-Length": str(len(body))}
        return Reply(status, headers | ({"Set-Cookie": cookie} if cookie else {}), body)


def _type_of(file: Path) -> str:
    kind = _TYPES.get(file.suffix.lower(), "text/plain")
    return f"{kind}; charset=utf-8" if kind.startswith("text/") else kind
