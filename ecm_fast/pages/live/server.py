"""The server of the live page: a few files and a socket, on this machine alone.

It listens on the loopback address, answers only who calls it by that name (so that no other site's name can be made
to lead here), and takes requests only from its own page.
"""

import errno
import json
import logging
import os
import socket
import threading
import time
from collections.abc import Callable
from http import HTTPStatus
from pathlib import Path
from typing import Any, Self

from ...errors import InputError
from .scene import Scene, parsed

__all__ = ["Page"]

_HOST = "127.0.0.1"
_FILES = {
    "/": ("page.html", "text/html; charset=utf-8"),
    "/page.css": ("page.css", "text/css; charset=utf-8"),
    "/page.svg": ("page.svg", "image/svg+xml"),
    "/page.js": ("page.js", "text/javascript; charset=utf-8"),
}
_PORTS = 65535  # the largest of TCP
_SOCKET = "/socket"
_HEADERS = {
    "Content-Security-Policy": "default-src 'self'; frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Cache-Control": "no-store",
}
# a request is a few hundred characters; what is longer is no request
_LONGEST = 1 << 16
_MOST = 32
"""Connections at once: a page holds one and asks for its four files by others; each takes up to three descriptors of
the 256 that the smallest systems give a process."""
_SILENT = 5.0  # seconds after which a connection that asks for nothing is closed
_PARTING = 0.1  # seconds in which one that is refused may read why


class _Listener(socket.socket):
    """A listening socket that waits where the process has no descriptor left: an error would end the server."""

    def accept(self) -> tuple[socket.socket, Any]:
        while True:
            try:
                return super().accept()
            except OSError as error:
                if error.errno not in (errno.EMFILE, errno.ENFILE):
                    raise
            time.sleep(_PARTING)


class Page:
    """A running server; use it in a ``with`` statement.

    Parameters
    ----------
    make : a scene for each page that connects
    port : 0 finds a free one

    Attributes
    ----------
    url : where the page is
    frames : how many were answered
    """

    def __init__(self, make: Callable[[], Scene], port: int = 0) -> None:
        if not 0 <= port <= _PORTS:
            raise InputError(f"--port {port}: allowed is a whole number up to {_PORTS}, 0 for a free one")
        try:
            from websockets.sync.server import ServerConnection, serve
        except ImportError:
            raise InputError("the page needs the package websockets: pip install 'ecm-fast[view]'") from None
        quiet = logging.getLogger(f"{__name__}.connections")  # what a client does wrong is not our user's business
        quiet.addHandler(logging.NullHandler())
        quiet.propagate = False
        self._make = make
        self._connection: Any = ServerConnection
        self._sockets: list[socket.socket] = []
        self._lock = threading.Lock()
        self.frames = 0
        try:
            made = socket.create_server((_HOST, port))
            start: Any = serve
            self._server: Any = start(
                self._talk,
                sock=_Listener(made.family, made.type, made.proto, fileno=made.detach()),
                create_connection=self._admitted,
                open_timeout=_SILENT,
                process_request=self._answer,
                max_size=_LONGEST,
                compression=None,
                server_header=None,
                logger=quiet,
            )
        except OSError as error:
            raise InputError(f"--port {port}: cannot be listened on ({_why(error)})") from None
        self.port: int = self._server.socket.getsockname()[1]
        self.url = f"http://{_HOST}:{self.port}/"
        self._names = {f"{_HOST}:{self.port}", f"localhost:{self.port}"}

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown()

    def serve(self) -> None:
        """Answer until `stop` is called or the user interrupts."""
        self._server.serve_forever()

    def stop(self) -> None:
        """End `serve`, from another thread."""
        self._server.shutdown()

    def _admitted(self, client: socket.socket, *args: Any, **options: Any) -> Any:
        """Return a connection on a socket, or say why there is none and raise, so that the socket is closed."""
        with self._lock:
            self._sockets = [other for other in self._sockets if other.fileno() >= 0]
            full = len(self._sockets) >= _MOST
            if not full:
                self._sockets.append(client)
        if not full:
            return self._connection(client, *args, **options)
        text = f"{_MOST} connections are open, and no more are taken: close a page that shows this neck\n"
        client.settimeout(_PARTING)
        client.sendall(f"HTTP/1.1 503 Service Unavailable\r\nContent-Type: text/plain; charset=utf-8\r\n"
                    f"Content-Length: {len(text)}\r\nConnection: close\r\n\r\n{text}".encode())  # fmt: skip
        client.shutdown(socket.SHUT_WR)
        client.recv(_LONGEST)  # what is closed unread resets the connection, and the text is lost
        raise ConnectionRefusedError(text)

    def _answer(self, connection: Any, request: Any) -> Any:
        """Return a file or a refusal; None lets a page's socket in."""
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        if len(hosts) != 1 or hosts[0] not in self._names:
            return _refused(connection, HTTPStatus.FORBIDDEN, "this server is called by another name")
        if any(origin != f"http://{hosts[0]}" for origin in origins):
            return _refused(connection, HTTPStatus.FORBIDDEN, "no other page may talk to this server")
        path = request.path.partition("?")[0]
        if path == _SOCKET:
            return None if origins else _refused(connection, HTTPStatus.FORBIDDEN, "a socket is for the page alone")
        if path not in _FILES:
            return _refused(connection, HTTPStatus.NOT_FOUND, "no such page")
        name, kind = _FILES[path]
        return _response(connection, HTTPStatus.OK, (Path(__file__).parent / name).read_text(encoding="utf-8"), kind)

    def _talk(self, connection: Any) -> None:
        """Answer a page's requests, the newest first: whoever drags is not interested in where the pointer was."""
        from websockets.exceptions import ConnectionClosed

        scene = self._make()
        try:
            connection.send(json.dumps(scene.hello()))
            while True:
                newest = None
                for text in _waiting(connection):
                    try:
                        newest = parsed(text)
                    except InputError as error:
                        connection.send(json.dumps({"error": str(error)}))
                if newest is not None:
                    connection.send(json.dumps(self._frame(scene, newest)))
        except ConnectionClosed:
            return

    def _frame(self, scene: Scene, request: dict[str, Any]) -> dict[str, Any]:
        try:
            frame = scene.frame(request)
        except InputError as error:
            return {"id": request["id"], "error": str(error)}
        with self._lock:
            self.frames += 1
        return frame


def _why(error: OSError) -> str:
    return os.strerror(error.errno) if error.errno else str(error)


def _waiting(connection: Any) -> list[str | bytes]:
    """Wait for a message; return it with those behind it."""
    messages = [connection.recv()]
    while len(messages) < 1000:
        try:
            messages.append(connection.recv(timeout=0))
        except TimeoutError:
            break
    return messages


def _refused(connection: Any, status: HTTPStatus, text: str) -> Any:
    return _response(connection, status, f"{text}\n", "text/plain; charset=utf-8")


def _response(connection: Any, status: HTTPStatus, text: str, kind: str) -> Any:
    response = connection.respond(status, text)
    for name, value in {**_HEADERS, "Content-Type": kind}.items():
        if name in response.headers:
            del response.headers[name]
        response.headers[name] = value
    return response
