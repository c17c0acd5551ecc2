"""The door: only pages of this server, in the browser of who was given its address, get in.

Other people's pages in the same browser can send requests here too. They cannot read the cookie (`HttpOnly`), it does
not go along with what they send (`SameSite=Strict`), and what they send says from where it comes (`Origin`). A name of
theirs that leads to this machine (DNS rebinding) is told by the `Host`. On a machine of many users the token in the
cookie keeps the others out.
"""

from __future__ import annotations

import secrets
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie

from starlette.datastructures import Headers, MutableHeaders, QueryParams
from starlette.responses import JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from propermodel.studio.faults import StudioError, error_body, faults_of

MOST_BYTES = 2**20  # of the body of a request
_WRITING = ("POST", "PUT", "PATCH")
_MEDIA = "application/json"

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "worker-src 'self'; font-src 'self'; form-action 'none'; base-uri 'none'; frame-ancestors 'none'"
)
_HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cache-Control": "no-store",
}


def new_token() -> str:
    """A token that nobody guesses."""
    return secrets.token_urlsafe(32)


@dataclass(frozen=True)
class Door:
    """Where the server listens, and the token that lets in."""

    port: int
    token: str = field(default_factory=new_token, repr=False)
    _once: set[str] = field(default_factory=set[str], repr=False)

    @property
    def hosts(self) -> frozenset[str]:
        """What `Host` may say."""
        return frozenset({f"127.0.0.1:{self.port}", f"localhost:{self.port}"})

    @property
    def cookie(self) -> str:
        """The name of the cookie; cookies are shared by all ports of a host, so the port is in it."""
        return f"propermodel-{self.port}"

    @property
    def address(self) -> str:
        """The address with the token, for who starts the server."""
        return f"http://127.0.0.1:{self.port}/?token={self.token}"

    def address_for_once(self) -> str:
        """An address that lets in one browser, for who shows it to others: all users of a machine see command lines."""
        token = new_token()
        self._once.add(token)
        return f"http://127.0.0.1:{self.port}/?token={token}"

    def is_token(self, text: str) -> bool:
        """Whether this is the token; how long it takes tells nothing."""
        return _is_same(text, self.token)

    def opens(self, text: str) -> bool:
        """Whether this token of an address lets a browser in; one that is for once does so no more."""
        for token in list(self._once):
            if _is_same(text, token):
                self._once.discard(token)
                return True
        return self.is_token(text)


def _is_same(one: str, other: str) -> bool:
    return secrets.compare_digest(one.encode("utf-8", "replace"), other.encode())


class Guard:
    """Looks at every request before the application sees it."""

    def __init__(self, app: ASGIApp, door: Door) -> None:
        self._app = app
        self._door = door

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Refuse the request, or pass it on."""
        if scope["type"] != "http":
            await self._app(scope, receive, send)
            return
        sender = _with_headers(send)
        try:
            answer = self._let_in(scope)
            if answer is None:
                await self._app(scope, _limited(receive), sender)
                return
        except StudioError as error:
            answer = refusal(error)
        await answer(scope, receive, sender)

    def _let_in(self, scope: Scope) -> Response | None:
        """An answer in place of the application's; None to let the request in.

        Raises:
            StudioError: the request is refused.
        """
        headers = Headers(scope=scope)
        hosts = headers.getlist("host")
        if len(hosts) != 1 or hosts[0] not in self._door.hosts:
            raise StudioError.with_status(
                403,
                "studio/host",
                f"this server is not called '{', '.join(hosts)[:100]}'",
                help=f"open http://127.0.0.1:{self._door.port}/ on the machine on which it runs",
            )
        for origin in headers.getlist("origin"):
            if origin.removeprefix("http://") not in self._door.hosts:
                raise StudioError.with_status(
                    403,
                    "studio/origin",
                    f"a page of '{origin[:100]}' may not use this server",
                    help="use the studio's own page, in a window of its own",
                )
        token = QueryParams(scope["query_string"]).get("token")
        if scope["path"] == "/" and token is not None and self._door.opens(token):
            return self._welcome()
        if not self._is_known(headers):
            return PlainTextResponse(f"{unknown()}\n", status_code=401)
        if scope["method"] in _WRITING:
            _check_body(headers)
        return None

    def _welcome(self) -> Response:
        answer = RedirectResponse("/", status_code=303)
        answer.set_cookie(self._door.cookie, self._door.token, httponly=True, samesite="strict", path="/")
        return answer

    def _is_known(self, headers: Headers) -> bool:
        for text in headers.getlist("cookie"):
            try:
                found = SimpleCookie(text).get(self._door.cookie)
            except CookieError:
                continue
            if found is not None and self._door.is_token(found.value):
                return True
        return False


def refusal(error: StudioError) -> Response:
    """The answer to a request that is refused."""
    return JSONResponse(error_body(faults_of(error)), status_code=error.status)


def unknown() -> StudioError:
    """The refusal of a browser that nobody has let in."""
    return StudioError.with_status(
        401,
        "studio/token",
        "this browser has not been let in",
        help="open the address that `propermodel studio` printed, with the token at its end",
    )


def _check_body(headers: Headers) -> None:
    media = headers.get("content-type", "").partition(";")[0].strip().lower()
    if media != _MEDIA:
        raise StudioError.with_status(
            415, "studio/content-type", f"the body is '{media[:100]}', not JSON", help=f"send it as {_MEDIA}"
        )
    length = headers.get("content-length", "")
    if length.isascii() and length.isdigit() and (len(length) > 15 or int(length) > MOST_BYTES):
        raise _too_large()


def _too_large() -> StudioError:
    return StudioError.with_status(
        413,
        "studio/too-large",
        f"the body has more than {MOST_BYTES} bytes",
        help="put large data into a file in the folder and name it",
    )


def _limited(receive: Receive) -> Receive:
    """What comes of a body, until it is too much."""
    seen = 0

    async def inner() -> Message:
        nonlocal seen
        message = await receive()
        seen += len(message.get("body", b""))
        if seen > MOST_BYTES:
            raise _too_large()
        return message

    return inner


def _with_headers(send: Send) -> Send:
    """What every answer says besides."""

    async def inner(message: Message) -> None:
        if message["type"] == "http.response.start":
            headers = MutableHeaders(scope=message)
            for name, value in _HEADERS.items():
                headers.setdefault(name, value)
        await send(message)

    return inner
