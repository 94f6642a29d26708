"""Webhooks: whoever asked for it is told when a job has ended, in the format of standardwebhooks.com.

A message is signed with HMAC-SHA256, sent again with growing pauses until it is taken, and never to an address that is not
public, unless that is allowed.
"""

import base64
import hmac
import ipaddress
import json
import socket
import time
from urllib.parse import urlsplit

import httpx
from rq.job import Job

from worker.errors import WebhookError
from worker.job_queue import WEBHOOKS, JobQueue
from worker.outcomes import Ended
from worker.settings import Settings
from worker.store import new_id

PAUSES_S = (5, 30, 120, 600, 3600, 6 * 3600)
TIMEOUT_S = 10.0
KEPT_S = 86400


def announce(job: Job, how: Ended) -> None:
    """Queue the message that a job has ended, if one was asked for."""
    url = job.meta.get("webhook_url")
    if url:
        body = {"type": f"job.{how}", "timestamp": time.time(), "data": {"id": job.id, "url": f"/v1/jobs/{job.id}"}}
        JobQueue(job.connection, name=WEBHOOKS).submit(
            "worker.webhooks.deliver",
            new_id(),
            f"webhook of {job.id}",
            KEPT_S,
            args=(url, f"msg_{job.id}", json.dumps(body)),
            pauses_s=PAUSES_S,
        )


def deliver(url: str, message_id: str, body: str) -> None:
    """The job: send a message once.

    Raises:
        WebhookError: it was not taken; the job is then tried again.
    """
    settings = Settings()
    if settings.webhook_secret is None:
        raise WebhookError("ASPERITY_WEBHOOK_SECRET is not set for this worker.")
    address = public_address(url, settings.webhook_private)
    parts = urlsplit(url)
    host = parts.hostname or ""
    literal = f"[{address}]" if ":" in address else address
    port = "" if parts.port is None else f":{parts.port}"
    pinned = parts._replace(netloc=f"{literal}{port}").geturl()  # the address that was checked, whatever the name says next
    headers = {"Host": host + port, "Content-Type": "application/json"}
    headers |= signature(settings.webhook_secret.get_secret_value(), message_id, int(time.time()), body)
    try:
        with httpx.Client(timeout=TIMEOUT_S, trust_env=False) as client:
            response = client.post(pinned, content=body, headers=headers, extensions={"sni_hostname": host})
    except httpx.HTTPError as error:
        raise WebhookError(f"{host} cannot be reached: {error}") from error
    if not response.is_success:
        raise WebhookError(f"{host} answered {response.status_code}.")


def signature(secret: str, message_id: str, timestamp: int, body: str) -> dict[str, str]:
    """Headers that prove who sent a message, and when."""
    digest = hmac.new(secret.encode(), f"{message_id}.{timestamp}.{body}".encode(), "sha256").digest()
    return {
        "webhook-id": message_id,
        "webhook-timestamp": str(timestamp),
        "webhook-signature": f"v1,{base64.b64encode(digest).decode()}",
    }


def public_address(url: str, private: bool) -> str:
    """An address of the host of a URL.

    Args:
        url: http or https.
        private: whether addresses that are not public are allowed.

    Raises:
        WebhookError: another kind of URL, an unknown host, or an address that is not allowed.
    """
    parts = urlsplit(url)
    try:
        port = parts.port or (443 if parts.scheme == "https" else 80)
        if parts.scheme not in ("http", "https") or not parts.hostname or parts.username is not None:
            raise WebhookError(f"{url} is no address for a webhook; give an http or https URL without a password.")
        found = {str(info[4][0]) for info in socket.getaddrinfo(parts.hostname, port, type=socket.SOCK_STREAM)}
    except (OSError, ValueError) as error:
        raise WebhookError(f"The host of {url} is not known ({error}).") from error
    if not private and not all(ipaddress.ip_address(address.partition("%")[0]).is_global for address in found):
        raise WebhookError(f"{parts.hostname} is not a public address; webhooks go to public ones only.")
    return sorted(found)[0]
