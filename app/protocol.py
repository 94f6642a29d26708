"""HTTP as uvicorn speaks it, but not for ever with a client that does not say what it wants."""

import asyncio

from uvicorn.protocols.http.httptools_impl import HttpToolsProtocol

HEADERS_S = 10.0
"""Longest time from a new connection, or the first byte of a request, to the end of its headers."""


class Protocol(HttpToolsProtocol):
    """Closes connections whose headers do not come; bodies are watched by ``app.intake``."""

    _overdue: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Begin to wait."""
        super().connection_made(transport)
        self._wait_for_headers()

    def data_received(self, data: bytes) -> None:
        """Whatever comes between two requests is no reason to wait longer."""
        super().data_received(data)
        between = self.cycle is None or self.cycle.response_complete
        if between and not self.transport.is_closing() and self._overdue is None and self.timeout_keep_alive_task is None:
            self._wait_for_headers()

    def on_message_begin(self) -> None:
        """Wait for the headers of the next request."""
        super().on_message_begin()
        self._wait_for_headers()

    def on_headers_complete(self) -> None:
        """They have come."""
        self._stop_waiting()
        super().on_headers_complete()

    def connection_lost(self, exc: Exception | None) -> None:
        """They will not come."""
        self._stop_waiting()
        super().connection_lost(exc)

    def _wait_for_headers(self) -> None:
        self._stop_waiting()
        self._overdue = self.loop.call_later(HEADERS_S, self.transport.close)

    def _stop_waiting(self) -> None:
        if self._overdue is not None:
            self._overdue.cancel()
            self._overdue = None
