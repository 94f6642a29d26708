"""Mutated uploads against a running service: nothing may crash, hang, or be answered with a 5xx.

    asperity benchmark fuzz [COUNT] [DIRECTORY]

PNG, TIFF, NPY, CSV and text files of instruments, and the files of DIRECTORY, with flipped bits, cut ends, moved and
repeated parts, and extreme numbers; sent to /v1/predictions by several clients at once.
"""

import io
import sys
import time
from collections import Counter
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import httpx
import numpy as np
from PIL import Image
from tqdm import tqdm

from benchmarks.service import service
from solver import random_midpoint_displacement

CLIENTS = 4
SIDE = 32
FIELDS = {
    "load_n": "1",
    "pixel_size_um": "1",
    "effective_modulus_gpa": "100",
    "verify": "false",
    "accuracy": "fast",
}
NUMBERS = ("npy", "csv", "tiff-float")
"""Seeds whose heights are numbers without a unit."""

LARGEST_SEED = 700_000
"""Bytes of the files of DIRECTORY that are used; larger ones only take longer."""


def main() -> None:
    """Print what was answered."""
    wanted = int(sys.argv[1]) if len(sys.argv) > 1 else 10_000
    seeds = dict(_seeds())
    for path in sorted(Path(sys.argv[2]).iterdir()) if len(sys.argv) > 2 else []:
        if path.suffix not in (".png", ".json", ".md") and path.stat().st_size <= LARGEST_SEED:
            seeds[path.suffix[1:]] = path.read_bytes()
    names = sorted(seeds)
    answers: Counter[tuple[str, int]] = Counter()
    slowest = 0.0
    with service() as (client, _), ThreadPoolExecutor(CLIENTS) as pool:
        turns = ((i, names[i % len(names)]) for i in range(wanted))
        jobs = ((name, mutated(seeds[name], np.random.default_rng(i))) for i, name in turns)
        for name, status, seconds in tqdm(pool.map(lambda job: _sent(client, *job), jobs), total=wanted):
            answers[name, status] += 1
            slowest = max(slowest, seconds)
        alive = client.get("/readyz").status_code
    statuses = sorted({status for _, status in answers})
    print(f"| seed | {' | '.join(map(str, statuses))} |\n|---|{'---|' * len(statuses)}")
    for name in names:
        print(f"| {name} | {' | '.join(str(answers[name, status]) for status in statuses)} |")
    broken = sum(found for (_, status), found in answers.items() if status >= 500)
    print(f"\n{wanted} uploads: {broken} answered with 5xx; slowest answer {slowest:.1f} s; /readyz afterwards {alive}.")


def mutated(data: bytes, generator: np.random.Generator) -> bytes:
    """A file with a few things wrong."""
    result = bytearray(data)
    for _ in range(int(generator.integers(1, 6))):
        at = int(generator.integers(max(len(result), 1)))
        if generator.random() < 0.5:
            at = min(at, int(generator.integers(1, 400)))  # headers matter most
        length = int(generator.integers(1, 64))
        match generator.integers(7):
            case 0 if result:
                result[at % len(result)] ^= 1 << int(generator.integers(8))
            case 1:
                result[at : at + length] = generator.bytes(length)
            case 2:
                del result[at:]
            case 3:
                del result[at : at + length]
            case 4:
                result[at:at] = result[at : at + length]
            case 5:
                extreme = (0, 1, 255, 65535, 2**31 - 1, 2**32 - 1)[int(generator.integers(6))]
                result[at : at + 4] = extreme.to_bytes(4, "little" if generator.random() < 0.5 else "big")
            case _:
                result += generator.bytes(length)
    return bytes(result)


def _sent(client: httpx.Client, name: str, data: bytes) -> tuple[str, int, float]:
    started = time.perf_counter()
    unit = "height_unit_um" if name in NUMBERS else "height_range_um" if name.startswith(("png", "tiff")) else None
    fields = FIELDS if unit is None else FIELDS | {unit: "1"}
    response = client.post("/v1/predictions", data=fields, files={"surface": (name, data)})
    return name, response.status_code, time.perf_counter() - started


def _seeds() -> Iterator[tuple[str, bytes]]:
    heights = random_midpoint_displacement(SIDE, seed=1)
    codes = np.rint(heights * 65535).astype(np.uint16)
    for name, values in (("png16", codes), ("png8", (codes // 257).astype(np.uint8))):
        yield name, _image(values, "PNG")
    for name, array, compression in (
        ("tiff16", codes, "raw"),
        ("tiff16-lzw", codes, "tiff_lzw"),
        ("tiff-float", heights.astype(np.float32), "tiff_adobe_deflate"),
    ):
        yield name, _image(array, "TIFF", compression=compression)
    file = io.BytesIO()
    np.save(file, heights)
    yield "npy", file.getvalue()
    rows = ["\t".join(f"{value:.6e}" for value in row) for row in heights]
    yield "csv", "\n".join(rows).replace("\t", ",").encode()
    header = ["# Channel: Height", "# Width: 10 um", "# Height: 10 um", "# Value units: m"]
    yield "asc", "\n".join(header + rows).encode()


def _image(values: np.ndarray, kind: str, **options: str) -> bytes:
    file = io.BytesIO()
    Image.fromarray(values).save(file, format=kind, **options)
    return file.getvalue()


if __name__ == "__main__":
    main()
