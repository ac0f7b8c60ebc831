"""The studio's server: a page, its modules, and one websocket, for this machine alone.

Every request must name this host; the page, the schema and the socket need the token that is in the printed address; a socket
must come from the page itself. The page names no path: it edits the one preset that was opened.
"""

import asyncio
import base64
import json
import math
import os
import secrets
import socket
import struct
import threading
from collections.abc import Sequence
from contextlib import asynccontextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import HTTPConnection, Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.websockets import WebSocket, WebSocketDisconnect

from gen_art.errors import GenArtError, UsageError
from gen_art.output.dependencies import dependencies
from gen_art.output.file_watch import FileWatch
from gen_art.output.input_tables import InputTable
from gen_art.output.live_plugins import LivePlugins
from gen_art.preset.schema import json_schema
from gen_art.studio.document import LARGEST_TEXT, Document
from gen_art.studio.token import kept_token
from gen_art.studio.worker import Worker, final_picture

__all__ = ["LARGEST_MESSAGE", "Studio", "listening_socket", "serve"]

PAGE = Path(__file__).parent / "page"
LARGEST_MESSAGE = 2 * LARGEST_TEXT  # bytes of a message from the page
MOST_QUEUED = 8  # messages that wait for a page, above which it gets no more pictures
SETTLE_AFTER = 0.3  # s after a change is done, in which its picture is made
LARGEST_PICTURE = 4096  # pixels of a side
MOST_HELD = 32  # keys at once
POLICY = (  # of what the page may load: its own files, and pictures that it was sent
    "default-src 'self'; img-src 'self' blob: data:; style-src 'self' 'unsafe-inline'; connect-src 'self'; "
    "frame-ancestors 'none'"
)


class Studio:
    """One preset, one worker, and the page that edits it; further pages watch."""

    def __init__(
        self, document: Document, plugins: LivePlugins, precision: str = "f32", threads: int | None = None
    ):  # fmt: skip
        self.document, self._plugins = document, plugins
        self.precision, self.threads = precision, threads
        self.token = kept_token()
        self.hosts: frozenset[str] = frozenset()
        self._pages: list[WebSocket] = []  # the first one edits
        self._queues: dict[WebSocket, asyncio.Queue] = {}
        self._loop: asyncio.AbstractEventLoop | None = None
        self._settling: asyncio.TimerHandle | None = None  # when the text takes over what was set
        self.worker = Worker(self._deliver, self._tell, precision, threads)

    @property
    def app(self) -> Starlette:
        routes = [
            Route("/", self._page),
            Route("/schema.json", self._schema),
            WebSocketRoute("/ws", self._socket),
            Mount("/page", StaticFiles(directory=PAGE)),
        ]
        return Starlette(routes=routes, middleware=[Middleware(_Guard, studio=self)], lifespan=self._lifespan)

    @asynccontextmanager
    async def _lifespan(self, app):
        self._loop = asyncio.get_running_loop()
        self.worker.start()
        self.worker.want(preset=self.document.preset, frame=self._poster_frame())
        with FileWatch() as watch:
            watching = threading.Thread(target=self._watch_files, args=(watch,), daemon=True)
            watching.start()
            yield
        self.worker.stop()
        await asyncio.to_thread(self.worker.join, 10.0)

    def _watch_files(self, watch: FileWatch) -> None:
        """In a thread of its own: wait for the files of the preset and of the plugins to be saved."""
        stamps = dependencies(self.document.file, {}, self._plugins.paths)
        while True:
            watch.follow(stamps)
            changed = watch.wait()
            if not changed or self._loop is None:
                return
            stamps = dependencies(self.document.file, {}, self._plugins.paths)  # before they are read
            asyncio.run_coroutine_threadsafe(self._files_changed(changed), self._loop).result()

    def _poster_frame(self) -> int:
        preset = self.document.preset
        return round(preset.poster_time * preset.clock.fps)

    def knows(self, connection: HTTPConnection) -> bool:
        """Whether a request has the token."""
        return secrets.compare_digest(connection.query_params.get("token", "").encode(), self.token.encode())

    async def _page(self, request: Request):
        if not self.knows(request):
            return PlainTextResponse("The address needs its token, as `gen-art studio` printed it.", 403)
        return FileResponse(PAGE / "index.html", headers={"Cache-Control": "no-store"})

    async def _schema(self, request: Request):
        if not self.knows(request):
            return PlainTextResponse("The address needs its token.", 403)
        return JSONResponse(json_schema())

    async def _socket(self, page: WebSocket):
        if not self.knows(page):
            await page.close(4403)
            return
        await page.accept()
        queue: asyncio.Queue = asyncio.Queue()
        self._queues[page] = queue
        self._pages.append(page)
        sender = asyncio.create_task(self._send_all(page, queue))
        try:
            self._put(page, {"type": "hello", "editor": self._pages[0] is page, "frame": self._poster_frame()})
            self._put(page, {"type": "document", **self.document.state})
            self.worker.reconnected()
            while True:
                message = await page.receive_text()
                if len(message) > LARGEST_MESSAGE:
                    await page.close(1009)
                    break
                await self._take(page, message)
        except WebSocketDisconnect:
            pass
        finally:
            sender.cancel()
            was_editor = self._pages[0] is page
            self._pages.remove(page)
            del self._queues[page]
            if was_editor:
                self.worker.leave()
                if self._pages:
                    self._put(self._pages[0], {"type": "hello", "editor": True, "frame": self._poster_frame()})
                    self.worker.reconnected()
            self.worker.want(playing=False, moving=False, diagnosed=False)

    async def _send_all(self, page: WebSocket, queue: asyncio.Queue) -> None:
        with suppress(WebSocketDisconnect, RuntimeError):  # the page has gone
            while True:
                message = await queue.get()
                if isinstance(message, bytes):
                    await page.send_bytes(message)
                else:
                    await page.send_text(_json(message))

    def _put(self, page: WebSocket, message: dict | bytes) -> None:
        """Queue a message for a page; a picture for one that is far behind is left out."""
        if not isinstance(message, bytes) or self._queues[page].qsize() < MOST_QUEUED:
            self._queues[page].put_nowait(message)

    def _tell_all(self, message: dict | bytes) -> None:
        for page in self._pages:
            self._put(page, message)

    def _deliver(self, header: dict, picture: bytes) -> None:
        """From the worker: length of the header (4 bytes, big-endian), header as JSON, JPEG."""
        head = _json(header).encode()
        self._from_worker(struct.pack(">I", len(head)) + head + picture)

    def _tell(self, message: dict) -> None:
        self._from_worker(message)

    def _from_worker(self, message: dict | bytes) -> None:
        if self._loop is not None and not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._tell_all, message)

    async def _take(self, page: WebSocket, text: str) -> None:
        """Do what a message of the page says; what cannot be meant is answered by a sentence."""
        try:
            message = json.loads(text)
            kind = message["type"]
            if kind == "shown":
                if page is self._pages[0]:
                    self.worker.shown()
                return
            if page is not self._pages[0]:
                if kind == "view":  # every page says what it would like to see
                    return
                self._put(page, {"type": "error", "text": "another page edits this preset; this one watches"})
                return
            await getattr(self, f"_on_{kind}")(page, message)
        except GenArtError as error:
            self._put(page, {"type": "error", "text": str(error)})
        except (ValueError, LookupError, TypeError, AttributeError, ArithmeticError, RecursionError) as error:
            self._put(
                page, {"type": "error", "text": f"the page sent what cannot be understood: {type(error).__name__}"}
            )

    async def _on_view(self, page: WebSocket, message: dict) -> None:
        changes: dict[str, Any] = {}
        if "frame" in message:
            changes["frame"] = max(0, int(message["frame"]))
        if "size" in message:
            width, height = (min(LARGEST_PICTURE, max(16, int(side))) for side in message["size"])
            changes["size"] = (width, height)
        changes |= {key: bool(message[key]) for key in ("playing", "moving", "diagnosed") if key in message}
        self.worker.want(**changes)

    async def _on_set(self, page: WebSocket, message: dict) -> None:
        """Values by path; with `done` the text takes them over."""
        done = bool(message.get("done", True))
        values = dict(message["values"])
        problems = self.document.set(values) if values else []
        self.worker.want(preset=self.document.preset, moving=not done)
        if problems and done:
            self._settle(problems)
        elif problems:
            self._put(page, {"type": "error", "text": "; ".join(f"{one['path']}: {one['text']}" for one in problems)})
        elif done:
            self._settle_later()

    def _settle(self, problems: list[dict] | None = None) -> None:
        """Let the text take over the values that were set, and show it."""
        if self._settling is not None:
            self._settling.cancel()
            self._settling = None
        self.document.settle()
        self._show_document(problems)

    def _settle_later(self) -> None:
        """After the picture, which writing YAML would hold up."""
        if self._settling is not None:
            self._settling.cancel()
        self._settling = asyncio.get_running_loop().call_later(SETTLE_AFTER, self._settle)

    async def _on_remove(self, page: WebSocket, message: dict) -> None:
        self._edited(self.document.remove(str(message["path"])))

    async def _on_text(self, page: WebSocket, message: dict) -> None:
        self.document.settle()
        self._edited(self.document.write(str(message["text"])))

    async def _on_undo(self, page: WebSocket, message: dict) -> None:
        self._edited(self.document.undo())

    async def _on_redo(self, page: WebSocket, message: dict) -> None:
        self._edited(self.document.redo())

    async def _on_save(self, page: WebSocket, message: dict) -> None:
        path = self.document.save()
        self._show_document()
        self._tell_all({"type": "said", "text": f"saved {path.name}"})

    async def _on_final(self, page: WebSocket, message: dict) -> None:
        if self.document.problems:
            raise UsageError("the preset has problems: mend them, and the final picture can be made")
        frame, preset, plugins = max(0, int(message["frame"])), self.document.preset, self._plugins.load()

        def make() -> None:
            self._tell({"type": "said", "text": "rendering the final picture", "stays": True})
            name, data = final_picture(preset, frame, self.precision, self.threads, plugins)
            picture = {"type": "final", "name": name, "png": base64.b64encode(data).decode("ascii")}
            if self._loop is not None:
                self._loop.call_soon_threadsafe(self._put_if_there, page, picture)

        self.worker.do(make)

    async def _on_steer(self, page: WebSocket, message: dict) -> None:
        if not message["on"]:
            self.worker.leave()
            return
        if self.document.problems:
            raise UsageError("the preset has problems: mend them, and it can be steered")
        self.worker.steer(self.document.preset)

    async def _on_devices(self, page: WebSocket, message: dict) -> None:
        """What the hands do: keys with how far they are pressed, and where the mouse was moved to, if it was."""
        held = {str(key): _share(message["held"][key]) for key in list(message["held"])[:MOST_HELD]}
        pointer = message.get("pointer")
        if pointer is None:
            self.worker.touch(held, None)
        else:
            across, down = pointer
            self.worker.touch(held, (_share(across), _share(down)))

    async def _on_keep(self, page: WebSocket, message: dict) -> None:
        """Write what was steered as tables beside the preset, which then goes by them."""
        loop = asyncio.get_running_loop()
        taken: asyncio.Future[list] = loop.create_future()

        def take(tables: list[InputTable]) -> None:
            loop.call_soon_threadsafe(taken.set_result, [replace(table, rows=list(table.rows)) for table in tables])

        self.worker.steered_tables(take)
        names = self.document.keep_inputs(await taken)
        self.worker.leave()
        self._edited(not self.document.problems, anew=True)
        self._tell_all({"type": "kept", "names": names})

    def _put_if_there(self, page: WebSocket, message: dict) -> None:
        if page in self._queues:
            self._put(page, message)

    def _edited(self, valid: bool, anew: bool = False) -> None:
        if valid and anew:
            self.worker.renew(self.document.preset)
        elif valid:
            self.worker.want(preset=self.document.preset, moving=False)
        self._show_document()

    def _show_document(self, problems: list[dict] | None = None) -> None:
        state = self.document.state
        self._tell_all(
            {"type": "document", **state, "problems": problems if problems is not None else state["problems"]}
        )

    async def _files_changed(self, paths: Sequence[Path]) -> None:
        """Files were saved elsewhere, or are gone: what is seen is made anew."""
        try:
            anew = set(paths) != {self.document.file}
            if anew:
                await self._reload_plugins()
            was_saved, before = self.document.is_saved, self.document.text
            self._edited(self.document.reload(), anew)
            if not was_saved and self.document.text != before:
                name = self.document.file.name
                self._tell_all(
                    {
                        "type": "said",
                        "text": f"{name} was read again; what you had changed is under Undo",
                        "stays": True,
                    }
                )
        except GenArtError as error:
            self._tell_all({"type": "error", "text": str(error)})
        except Exception as error:  # of a plugin, which may raise anything; the watch goes on
            self._tell_all({"type": "error", "text": f"this is a bug: {type(error).__name__}: {error}"})

    async def _reload_plugins(self) -> None:
        """In the worker's thread, where nothing is drawn meanwhile."""
        loop, done = asyncio.get_running_loop(), asyncio.get_running_loop().create_future()

        def reload() -> None:
            error: BaseException | None = None
            try:
                self._plugins.load()
            except Exception as raised:
                error = raised
            if error is None:
                loop.call_soon_threadsafe(done.set_result, None)
            else:
                loop.call_soon_threadsafe(done.set_exception, error)

        self.worker.do(reload)
        await done


def _share(value: Any) -> float:
    """A number of the page from 0 to 1. Raises ValueError for one that is not finite."""
    number = float(value)
    if not math.isfinite(number):
        raise ValueError("not finite")
    return min(max(number, 0.0), 1.0)


def _json(message: dict) -> str:
    """JSON, in which numbers that are not finite are text: JSON has none."""

    def finite(value: Any) -> Any:
        if isinstance(value, float) and not math.isfinite(value):
            return str(value)
        if isinstance(value, dict):
            return {key: finite(item) for key, item in value.items()}
        return [finite(item) for item in value] if isinstance(value, (list, tuple)) else value

    try:
        return json.dumps(message, allow_nan=False)
    except ValueError:
        return json.dumps(finite(message))


class _Guard:
    """Refuses requests that do not name this host, and sockets that do not come from its page."""

    def __init__(self, app, studio: Studio):
        self.app, self.studio = app, studio

    async def __call__(self, scope, receive, send):
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        connection = HTTPConnection(scope)
        host, origin = connection.headers.get("host", ""), connection.headers.get("origin")
        allowed = host in self.studio.hosts
        if scope["type"] == "websocket":
            allowed = allowed and origin in {f"http://{name}" for name in self.studio.hosts}
            if not allowed:
                await send({"type": "websocket.close", "code": 4403})
                return
        elif not allowed:
            await PlainTextResponse("This is a page of this machine alone.", 403)(scope, receive, send)
            return

        async def with_policy(message):
            if message["type"] == "http.response.start":
                message["headers"] = [
                    *message["headers"], (b"content-security-policy", POLICY.encode()),
                    (b"x-content-type-options", b"nosniff"), (b"referrer-policy", b"no-referrer"),
                ]  # fmt: skip
            await send(message)

        await self.app(scope, receive, with_policy)


def listening_socket(port: int) -> socket.socket:
    """A socket of this machine alone; port 0 takes a free one. Raises OSError for one that is taken."""
    found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    if os.name != "nt":  # there it would let two studios have one port
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        found.bind(("127.0.0.1", port))
        found.listen(64)  # so that who reads the address can connect at once
    except OSError:
        found.close()
        raise
    return found


def serve(studio: Studio, found: socket.socket) -> None:
    """Serve until the process is stopped."""
    port = found.getsockname()[1]
    studio.hosts = frozenset({f"127.0.0.1:{port}", f"localhost:{port}"})
    config = uvicorn.Config(
        studio.app, log_level="error", ws_max_size=LARGEST_MESSAGE, ws="websockets-sansio", lifespan="on",
        timeout_graceful_shutdown=2,
    )  # fmt: skip
    uvicorn.Server(config).run(sockets=[found])
