"""Predictions and verifications of measured height maps over HTTP.

    asperity benchmark real-maps DIRECTORY [PICTURES]

DIRECTORY holds the maps and ``surfaces.json`` (name, png, pixel_size_x_um, pixel_size_y_um, height_range_um); the load of
each is chosen so that about a twentieth of it touches. Heights under the masks are drawn into PICTURES.
"""

import json
import sys
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from app.uploads import decode
from benchmarks.service import post, service, wait_for_job
from model import Surrogate, compare
from solver import ContactProblem, solve

MODULUS_GPA = 100.0
MATERIAL = {"effective_modulus_gpa": MODULUS_GPA, "resistivity_ohm_m": 1e-7}
FRACTION = 0.05


def load_for_fraction(heights: np.ndarray, pixel_size: tuple[float, float]) -> float:
    """A load in N, to two digits, that brings about FRACTION of the map into contact."""
    low, high = -15.0, 6.0
    while high - low > 0.02:
        middle = (low + high) / 2
        problem = ContactProblem(heights, pixel_size, 10**middle, MODULUS_GPA * 1e9)
        if solve(problem, tolerance=1e-2).contact_fraction < FRACTION:
            low = middle
        else:
            high = middle
    return float(f"{10**low:.2g}")


def draw(png: bytes, mask: bytes, reference: bytes, path: Path) -> None:
    """The map in grey; white where both masks touch, red only the prediction, blue only the reference."""
    grey = np.array(Image.open(BytesIO(png)), dtype=np.float64)
    grey = 40 + 130 * (grey - grey.min()) / np.ptp(grey)
    picture = np.repeat(grey[..., np.newaxis], 3, axis=2).astype(np.uint8)
    predicted, truth = (np.array(Image.open(BytesIO(data)), dtype=bool) for data in (mask, reference))
    picture[predicted & truth] = (255, 255, 255)
    picture[predicted & ~truth] = (255, 60, 40)
    picture[truth & ~predicted] = (60, 120, 255)
    Image.fromarray(picture).save(path)


def main() -> None:
    """Print a table, one map a row."""
    directory = Path(sys.argv[1])
    pictures = Path(sys.argv[2]) if len(sys.argv) > 2 else None
    surrogate = Surrogate.load()
    print("| map | pixels | load N | contact | network alone: Dice | expected | served by | Dice | area error | solve s |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    with service() as (client, _):
        for entry in json.loads((directory / "surfaces.json").read_text()):
            png = (directory / entry["png"]).read_bytes()
            pixel_size = entry["pixel_size_y_um"] * 1e-6, entry["pixel_size_x_um"] * 1e-6
            heights = decode(png).values * (entry["height_range_um"] * 1e-6)
            load = load_for_fraction(heights, pixel_size)
            answer = post(client, png, load_n=load, **_units(entry), **MATERIAL)
            job = wait_for_job(client, answer["verification"]["job_id"])
            if job["status"] != "finished" or not job["result"]["converged"]:
                print(f"| {entry['name']} | {job['status']}: {job['error'] or job['result']['status']} |", flush=True)
                continue
            result, found = job["result"], job["comparison"]
            masks = [client.get(url).content for url in (answer["mask_url"], result["mask_url"])]
            alone = surrogate.estimate(ContactProblem(heights, pixel_size, load, MODULUS_GPA * 1e9))
            reference = np.array(Image.open(BytesIO(masks[1])), dtype=bool)
            print(
                f"| {entry['name']} | {heights.shape[0]} x {heights.shape[1]} | {load:g} | {result['contact_fraction']:.2%} "
                f"| {compare(reference, alone.contact_mask).dice:.4f} | {1 - alone.expected_error.dice:.4f} "
                f"| {answer['method']} | {found['dice']:.4f} | {found['area_error']:+.2%} | {result['solve_seconds']:.1f} |",
                flush=True,
            )
            if pictures:
                pictures.mkdir(parents=True, exist_ok=True)
                draw(png, *masks, pictures / f"{entry['name']}.png")


def _units(entry: dict[str, Any]) -> dict[str, Any]:
    return {name: entry[name] for name in ("pixel_size_x_um", "pixel_size_y_um", "height_range_um")}


if __name__ == "__main__":
    main()
