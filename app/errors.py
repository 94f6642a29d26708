"""Typed errors of the boundary between people and the packages below: uploads and forms."""

from collections.abc import Sequence
from dataclasses import dataclass

from solver.errors import AsperityError


@dataclass(frozen=True)
class FieldError:
    """One field of a form that cannot be used.

    Attributes:
        field: its name, as in the form.
        code: stable name of the fault.
        detail: what is wrong and what to change.
    """

    field: str
    code: str
    detail: str


class InvalidFormError(AsperityError):
    """One or more fields of a request that are missing or not valid."""

    code = "invalid-form"
    title = "Some fields are missing or not valid"
    http_status = 422

    def __init__(self, errors: Sequence[FieldError]) -> None:
        super().__init__(" ".join(error.detail for error in errors))
        self.errors = errors

    def __reduce__(self) -> tuple[type["InvalidFormError"], tuple[Sequence[FieldError]]]:
        """Keeps the errors on the way from one process to another."""
        return type(self), (self.errors,)


class InvalidSettingsError(AsperityError):
    """An environment variable that cannot be used."""

    code = "invalid-settings"
    title = "A setting is not valid"
    http_status = 422


class InternalError(AsperityError):
    """A failure of the service itself; its log says why."""

    def __init__(self) -> None:
        super().__init__(
            "The service failed on this request; its log says why. Nothing is wrong with the request as far as it knows."
        )


class MalformedRequestError(AsperityError):
    """A request whose body is not what its headers say, such as a multipart form without its end."""

    code = "bad-request"
    title = "Bad Request"
    http_status = 400


class NotFoundError(AsperityError):
    """A path at which there is nothing."""

    code = "not-found"
    title = "Not Found"
    http_status = 404


class MethodNotAllowedError(AsperityError):
    """A method that a path does not have."""

    code = "method-not-allowed"
    title = "Method Not Allowed"
    http_status = 405


class IdempotencyKeyReusedError(AsperityError):
    """An idempotency key that stands for a request with other contents."""

    code = "idempotency-key-reused"
    title = "The idempotency key stands for another request"
    http_status = 422


class UnauthorizedError(AsperityError):
    """No API key, or an unknown one, where one is required."""

    code = "unauthorized"
    title = "An API key is required"
    http_status = 401


class ForbiddenError(AsperityError):
    """An API key that does not allow this."""

    code = "forbidden"
    title = "The API key does not allow this"
    http_status = 403


class RateLimitedError(AsperityError):
    """More requests than a client may make in a minute."""

    code = "rate-limited"
    title = "Too many requests"
    http_status = 429

    def __init__(self, most: int, retry_after_s: int) -> None:
        super().__init__(f"More than {most} requests within a minute; wait {retry_after_s} s, and try again.")
        self.retry_after_s = retry_after_s


class BusyError(AsperityError):
    """More requests wait to be computed than may wait."""

    code = "busy"
    title = "The service is busy"
    http_status = 503


class ComputeError(AsperityError):
    """Nothing can be computed, or what computes dies of a request."""

    code = "compute-failed"
    title = "The computation failed"
    http_status = 503


class UploadError(AsperityError):
    """A file that cannot be read as a height map."""

    code = "invalid-upload"
    title = "The file cannot be read as a height map"
    http_status = 422


class ArchiveError(UploadError):
    """A file that cannot be read as an archive of height maps."""

    code = "invalid-archive"
    title = "The archive cannot be read"


class UploadTooLargeError(UploadError):
    """A request body larger than the service accepts."""

    code = "upload-too-large"
    title = "The upload is too large"
    http_status = 413


class SlowUploadError(UploadError):
    """A request body that stops coming, or takes too long."""

    code = "slow-upload"
    title = "The upload takes too long"
    http_status = 408


class UnknownFormatError(UploadError):
    """A file of no format that is read."""

    code = "unknown-format"
    title = "The file has no format that is read"
    http_status = 415


class DamagedFileError(UploadError):
    """A file whose contents contradict its format."""

    code = "damaged-file"
    title = "The file is damaged"


class NotAHeightMapError(UploadError):
    """A file that holds something else than heights on a grid of rows and columns."""

    code = "not-a-height-map"
    title = "The file holds no height map"


class MissingHeightsError(UploadError):
    """A height map most of whose pixels were not measured."""

    code = "missing-heights"
    title = "Too many pixels have no height"


class DecodingLimitError(UploadError):
    """A file that takes more time or memory to decode than an upload may."""

    code = "decoding-limit"
    title = "The file takes too much to decode"
    http_status = 413


class TruncatedPngError(UploadError):
    """A PNG file that ends before its picture does."""

    code = "truncated-png"
    title = "The PNG file is incomplete"


class DamagedPngError(UploadError):
    """A PNG file whose contents contradict their checksums or the format."""

    code = "damaged-png"
    title = "The PNG file is damaged"


class ColourPngError(UploadError):
    """A PNG file in colour."""

    code = "colour-png"
    title = "The PNG file is in colour"


class PalettePngError(UploadError):
    """A PNG file with a palette."""

    code = "palette-png"
    title = "The PNG file has a palette"


class TransparentPngError(UploadError):
    """A PNG file with an alpha channel or a transparent grey level."""

    code = "transparent-png"
    title = "The PNG file has transparency"


class LowBitDepthError(UploadError):
    """A grey PNG file with 1, 2 or 4 bits a pixel."""

    code = "low-bit-depth"
    title = "The PNG file has too few grey levels"


class ImageTooLargeError(UploadError):
    """A file that announces more pixels than a contact problem may have."""

    code = "image-too-large"
    title = "The height map has too many pixels"
    http_status = 413


class ConstantHeightsError(UploadError):
    """A file whose pixels are all the same."""

    code = "constant-heights"
    title = "The height map is constant"
