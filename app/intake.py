"""How request bodies come in: no larger and no slower than is accepted, and a piece at a time."""

import asyncio

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.errors import SlowUploadError, UploadTooLargeError

MEBIBYTE = 2**20

PIECE_S = 10.0
"""Longest silence within a body."""

BODY_S = 120.0
"""Longest time for a whole body."""


class Intake:
    """ASGI middleware; whoever reads a body beyond the limits gets an error that becomes a problem document.

    Requests begin, and their pieces are handed on, one at a time: a burst of uploads lets the event loop go on in between.
    Starlette's own limiter answers in plain text.
    """

    def __init__(self, app: ASGIApp, limit_mib: int, piece_s: float = PIECE_S, body_s: float = BODY_S) -> None:
        self.app = app
        self.limit_mib = limit_mib
        self.piece_s = piece_s
        self.body_s = body_s
        self._turn = asyncio.Lock()

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on with a `receive` that counts and watches the clock.

        Raises:
            UploadTooLargeError: from that `receive`, when more than the limit is announced or has come.
            SlowUploadError: from the same, when the client falls silent or takes too long.
        """
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        announced = Headers(scope=scope).get("content-length", "")
        size = int(announced) if announced.isdecimal() else 0
        received, complete = 0, False
        deadline = asyncio.get_running_loop().time() + self.body_s

        async def watched_receive() -> Message:
            nonlocal received, complete
            if complete:  # what follows is the end of the connection
                return await receive()
            self._check(size)
            silence = asyncio.get_running_loop().time() + self.piece_s
            try:
                async with asyncio.timeout_at(min(deadline, silence)):
                    message = await receive()
            except TimeoutError as error:
                raise SlowUploadError(
                    f"The upload fell silent for {self.piece_s:g} s, or took more than {self.body_s:g} s; send it again."
                ) from error
            received += len(message.get("body", b""))
            complete = not message.get("more_body", False)
            self._check(received)
            await self._take_turn()
            return message

        await self._take_turn()
        await self.app(scope, watched_receive, send)

    async def _take_turn(self) -> None:
        """Let the event loop go on once between this and whoever came before."""
        async with self._turn:
            await asyncio.sleep(0)

    def _check(self, size: int) -> None:
        if size > self.limit_mib * MEBIBYTE:
            raise UploadTooLargeError(
                f"The upload has more than {self.limit_mib} MiB, the most that is accepted. "
                "Crop the map, bin its pixels, or compress the PNG better."
            )
