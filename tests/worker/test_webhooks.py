"""Webhooks: signed, pinned to public addresses, and sent until they are taken."""

import json
import threading
import time
from collections.abc import Callable, Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest
from pydantic import SecretStr
from redis import Redis

from tests.worker.conftest import rough, worker
from worker.errors import WebhookError
from worker.jobs import VerificationQueue
from worker.parcel import Parcel
from worker.settings import Settings
from worker.webhooks import deliver, public_address, signature

SECRET = "a secret of ours"  # noqa: S105


class Receiver(HTTPServer):
    """Takes messages, and refuses the first few."""

    def __init__(self, refusals: int = 0) -> None:
        self.refusals = refusals
        self.messages: list[tuple[dict[str, str], str]] = []
        super().__init__(("127.0.0.1", 0), _Handler)
        threading.Thread(target=self.serve_forever, daemon=True).start()

    @property
    def url(self) -> str:
        return f"http://localhost:{self.server_port}/hook"


class _Handler(BaseHTTPRequestHandler):
    server: Receiver

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["content-length"])).decode()
        self.server.messages.append((dict(self.headers), body))
        self.send_response(500 if len(self.server.messages) <= self.server.refusals else 204)
        self.end_headers()

    def log_message(self, format: str, *args: object) -> None:
        """Say nothing."""


@pytest.fixture
def receiver() -> Iterator[Callable[..., Receiver]]:
    made: list[Receiver] = []

    def make(refusals: int = 0) -> Receiver:
        made.append(Receiver(refusals))
        return made[-1]

    yield make
    for one in made:
        one.shutdown()


@pytest.fixture(autouse=True)
def environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ASPERITY_WEBHOOK_SECRET", SECRET)
    monkeypatch.setenv("ASPERITY_WEBHOOK_PRIVATE", "true")


def wait_until(condition: Callable[[], bool], timeout_s: float = 60) -> None:
    deadline = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < deadline
        time.sleep(0.05)


def test_the_end_of_a_job_is_told_once_and_signed(
    connection: Redis, settings: Settings, receiver: Callable[..., Receiver]
) -> None:
    known = settings.model_copy(update={"webhook_secret": SecretStr(SECRET), "webhook_private": True})
    queue, hook = VerificationQueue(connection, known), receiver()
    with worker(settings):
        job_id = queue.enqueue(Parcel(rough(32)), webhook_url=hook.url)
        wait_until(lambda: len(hook.messages) > 0)
        time.sleep(0.5)
    ((headers, body),) = hook.messages
    assert json.loads(body)["type"] == "job.finished"
    assert json.loads(body)["data"] == {"id": job_id, "url": f"/v1/jobs/{job_id}"}
    expected = signature(SECRET, headers["webhook-id"], int(headers["webhook-timestamp"]), body)
    assert headers["webhook-signature"] == expected["webhook-signature"]
    assert headers["webhook-id"] == f"msg_{job_id}"
    assert headers["Host"] == hook.url.split("/")[2]


def test_canceled_jobs_are_told_too_and_refusals_are_tried_again(
    connection: Redis, settings: Settings, receiver: Callable[..., Receiver]
) -> None:
    known = settings.model_copy(update={"webhook_secret": SecretStr(SECRET), "webhook_private": True})
    queue, hook = VerificationQueue(connection, known), receiver(refusals=1)
    queue.cancel(queue.enqueue(Parcel(rough(32)), webhook_url=hook.url))
    with worker(settings):
        wait_until(lambda: len(hook.messages) == 2)
    (first, body), (second, again) = hook.messages
    assert body == again
    assert json.loads(body)["type"] == "job.canceled"
    assert first["webhook-id"] == second["webhook-id"]


def test_the_signature_is_that_of_the_standard() -> None:
    """https://www.standardwebhooks.com: HMAC-SHA256 of id.timestamp.payload, in base64; the number is of openssl dgst."""
    headers = signature("key", "msg_1", 1700000000, '{"a":1}')
    assert headers["webhook-signature"] == "v1,KSgv0SSgWzG5LPnm9tfWJRfBlWqAqHz+OlObgspQi/g="


@pytest.mark.parametrize(
    "url",
    [
        "http://127.0.0.1/",
        "http://localhost:6379/",
        "http://10.0.0.8/",
        "http://192.168.1.1/admin",
        "http://169.254.169.254/latest/meta-data",
        "http://[::1]/",
        "http://[::ffff:127.0.0.1]/",
        "http://0.0.0.0/",
        "http://2130706433/",
        "http://100.64.0.1/",
    ],
)
def test_addresses_that_are_not_public_are_refused(url: str) -> None:
    with pytest.raises(WebhookError, match=r"not a public address|not known"):
        public_address(url, private=False)


@pytest.mark.parametrize(
    "url", ["ftp://1.1.1.1/", "file:///etc/passwd", "1.1.1.1", "http://", "http://a:b@1.1.1.1/", "http://1.1.1.1:99999/"]
)
def test_what_is_no_url_of_a_webhook(url: str) -> None:
    with pytest.raises(WebhookError):
        public_address(url, private=True)


def test_a_public_address_is_taken() -> None:
    assert public_address("https://1.1.1.1/hook", private=False) == "1.1.1.1"


def test_a_refusal_and_silence_raise(receiver: Callable[..., Receiver]) -> None:
    with pytest.raises(WebhookError, match="answered 500"):
        deliver(receiver(refusals=1).url, "msg_1", "{}")
    with pytest.raises(WebhookError, match="cannot be reached"):
        deliver("http://127.0.0.1:9/", "msg_1", "{}")


def test_without_a_secret_webhooks_are_refused(queue: VerificationQueue) -> None:
    without = VerificationQueue(queue.connection, queue.settings.model_copy(update={"webhook_secret": None}))
    with pytest.raises(WebhookError, match="ASPERITY_WEBHOOK_SECRET"):
        without.enqueue(Parcel(rough(32)), webhook_url="https://1.1.1.1/")
    assert without.waiting() == 0
