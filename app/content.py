"""What an answer depends on, as one name for it."""

from hashlib import sha256
from importlib.metadata import version

from pydantic import BaseModel

from app.reading import Files

VERSION = version("asperity")
DELIVERY = {"surface", "surface_2", "archive", "webhook_url", "verify", "inline_mask"}
"""Fields that do not change what is computed; of the files the contents count."""


def content_id(files: Files, form: BaseModel, model: str) -> str:
    """An id of 32 hexadecimal digits, the same for the same files, fields, model and version of Asperity alone."""
    parts = [model, VERSION, form.model_dump_json(exclude=DELIVERY)]
    hashes = [sha256(part.encode()) for part in parts] + [sha256(files.surface), sha256(files.surface_2 or b"")]
    return sha256(b"".join(part.digest() for part in hashes)).hexdigest()[:32]
