"""Decoding where it can do no harm: a child process for each file, with little memory and little time.

The readers of forty formats were not written for hostile files. PNG files are checked before and need no child.
"""

import io
import json
import resource
from multiprocessing import get_context
from multiprocessing.connection import Connection
from multiprocessing.context import ForkServerContext
from multiprocessing.forkserver import ensure_running

import numpy as np

from app import errors
from app.errors import DamagedFileError, DecodingLimitError, UploadError
from app.height_map import HeightMap
from app.uploads import decode, is_png

MEMORY_BYTES = 4 * 2**30
"""Address space of a child; a map of 4096 x 4096 takes 128 MiB, and the readers hold several copies of it."""

SECONDS = 20.0

PRELOADED = ["app.formats.instrument", "PIL.TiffImagePlugin", "app.sandbox", "app.cli"]
"""What children are forked with; the last is what the main module imports, which each child runs again."""

ADVICE = "Crop it, or export it as PNG or NPY."

ANSWERED, REFUSED = b"+", b"-"


class Sandbox:
    """Children that decode; the first file waits for the readers to be imported, later ones only for a fork."""

    def __init__(self) -> None:
        self._context: ForkServerContext = get_context("forkserver")
        self._context.set_forkserver_preload(PRELOADED)

    def start(self) -> None:
        """Have the readers imported, without waiting for it."""
        ensure_running()

    def decode(self, data: bytes) -> HeightMap:
        """As :func:`app.uploads.decode`.

        Raises:
            UploadError: one of its subclasses; ``DecodingLimitError`` beyond the limits.
        """
        if is_png(data):
            return decode(data)
        ours, theirs = self._context.Pipe(duplex=False)
        child = self._context.Process(target=_decode_in_child, args=(data, theirs), daemon=True)
        child.start()
        theirs.close()
        try:
            if not ours.poll(SECONDS):
                raise DecodingLimitError(f"The file takes more than {SECONDS:g} s to decode. {ADVICE}")
            return _unpacked(ours.recv_bytes())
        except EOFError as error:
            raise DamagedFileError(f"The file cannot be decoded: its reader failed. {ADVICE}") from error
        finally:
            child.kill()
            child.join()
            ours.close()


def _decode_in_child(data: bytes, answer: Connection) -> None:
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    try:
        packed = ANSWERED + _packed(decode(data))
    except UploadError as error:
        packed = REFUSED + json.dumps([type(error).__name__, str(error)]).encode()
    except MemoryError:
        said = f"The file takes too much memory to decode. {ADVICE}"
        packed = REFUSED + json.dumps([DecodingLimitError.__name__, said]).encode()
    answer.send_bytes(packed)


def _packed(height_map: HeightMap) -> bytes:
    """As a line of JSON and an array: what comes back from a child is never unpickled."""
    known = {name: value for name, value in vars(height_map).items() if name != "values"}
    file = io.BytesIO()
    file.write(json.dumps(known).encode() + b"\n")
    np.save(file, height_map.values, allow_pickle=False)
    return file.getvalue()


def _unpacked(answer: bytes) -> HeightMap:
    if answer.startswith(REFUSED):
        name, message = json.loads(answer[1:])
        kind = getattr(errors, name)
        raise kind(message)
    file = io.BytesIO(answer[1:])
    known = json.loads(file.readline())
    known["pixel_size"] = known["pixel_size"] and tuple(known["pixel_size"])
    return HeightMap(values=np.load(file, allow_pickle=False), **known)
