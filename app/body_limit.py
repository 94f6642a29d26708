"""Stop request bodies that are too large while they stream, before they are spooled to disk."""

from starlette.datastructures import Headers
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.errors import UploadTooLargeError

MEBIBYTE = 2**20


class BodyLimit:
    """ASGI middleware; whoever reads a body beyond the limit gets an error that becomes a problem document.

    Starlette's own limiter answers in plain text.
    """

    def __init__(self, app: ASGIApp, limit_mib: int) -> None:
        self.app = app
        self.limit_mib = limit_mib

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Pass the request on with a `receive` that counts.

        Raises:
            UploadTooLargeError: from that `receive`, when more than the limit is announced or has come.
        """
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        announced = Headers(scope=scope).get("content-length", "")
        size = int(announced) if announced.isdecimal() else 0
        received = 0

        async def counting_receive() -> Message:
            nonlocal received
            self._check(size)
            message = await receive()
            received += len(message.get("body", b""))
            self._check(received)
            return message

        await self.app(scope, counting_receive, send)

    def _check(self, size: int) -> None:
        if size > self.limit_mib * MEBIBYTE:
            raise UploadTooLargeError(
                f"The upload has more than {self.limit_mib} MiB, the most that is accepted. "
                "Crop the map, bin its pixels, or compress the PNG better."
            )
