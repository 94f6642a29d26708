"""The page in a real browser, against the real service."""

import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

from app.api_key import new_key
from tests.app.conftest import UNITS, serving
from tests.app.files import ascii_grid, png, surface_codes, surface_png

ARGUMENTS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
PATIENCE_MS = 60_000


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    program = shutil.which("chromium")
    if program is None:
        if "CI" in os.environ:
            pytest.fail("chromium is not installed")
        pytest.skip("chromium is not installed")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=ARGUMENTS)
        yield browser
        browser.close()


@pytest.fixture(params=[1400, 400])
def page(request: pytest.FixtureRequest, browser: Browser, server: str) -> Iterator[Page]:
    """The page, at the width of a desk and of a pocket; nothing may go wrong in its scripts."""
    page = browser.new_page(viewport={"width": request.param, "height": 900})
    page.set_default_timeout(PATIENCE_MS)
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("requestfailed", lambda request: faults.append(request.url))
    page.goto(server)
    yield page
    assert faults == []
    assert page.evaluate("document.documentElement.scrollWidth") <= request.param
    page.close()


@pytest.fixture
def surface(tmp_path: Path) -> Path:
    path = tmp_path / "surface.png"
    path.write_bytes(surface_png())
    return path


def fill(page: Page, surface: Path, **fields: str) -> None:
    page.set_input_files("#surface", surface)
    for name, value in (UNITS | fields).items():
        page.fill(f"#{name}", value)


def painted(page: Page, canvas: str) -> int:
    """Number of opaque pixels of a canvas."""
    script = """canvas => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data
        .filter((value, index) => index % 4 === 3 && value === 255).length"""
    return int(page.locator(canvas).evaluate(script))


def test_from_upload_to_verification(page: Page, surface: Path) -> None:
    fill(page, surface, resistivity_ohm_m="1.7e-8")
    expect(page.locator("#read")).to_contain_text("64 rows × 64 columns, 16-bit")
    expect(page.locator("#read")).to_contain_text("1 mm wide, 1 mm high; heights span 50 µm")
    assert painted(page, "#heights") == 64 * 64

    with page.expect_response("**/v1/predictions") as response:
        page.get_by_role("button", name="Predict contact").click()
    prediction = response.value.json()
    figures = page.locator("#figures")
    expect(figures).to_contain_text("mm²")
    expect(figures).to_contain_text(re.compile(r"Contact resistance[\d.]+ [mµ]?Ω"))
    expect(page.locator("#controls")).to_be_visible()
    assert painted(page, "#overlay") == round(prediction["contact_fraction"] * 64 * 64)

    expect(page.locator("#state")).to_have_text("finished", timeout=PATIENCE_MS)
    expect(page.locator("#comparison")).to_contain_text(re.compile(r"Dice(0\.\d{4}|1\.0000)"))
    expect(page.locator("#comparison")).to_contain_text("Area error")
    expect(page.locator("#reference")).to_contain_text("Converged")
    difference = page.get_by_role("radio", name="Difference")
    expect(difference).to_be_enabled()
    page.locator("label", has=difference).click()
    expect(difference).to_be_checked()
    expect(page.locator("#legend")).to_have_text(re.compile("both.*predicted only.*reference only"))

    page.locator("#opacity").fill("30")
    expect(page.locator("#overlay")).to_have_css("opacity", "0.3")


def test_pixels_that_are_not_square_keep_their_shape(page: Page, tmp_path: Path) -> None:
    surface = tmp_path / "oblong.png"
    surface.write_bytes(png(surface_codes()[:, :32].copy()))
    page.set_input_files("#surface", surface)
    page.get_by_label("Pixels are not square").check()
    page.get_by_label("Pixel size x").fill("10")
    page.get_by_label("Pixel size y").fill("20")
    expect(page.locator("#read")).to_contain_text("64 rows × 32 columns")
    expect(page.locator("#read")).to_contain_text("320 µm wide, 1.28 mm high")
    box = page.locator("#heights").bounding_box()
    assert box is not None
    assert box["height"] / box["width"] == pytest.approx(4, rel=0.02)


def test_errors_stand_at_their_fields(page: Page, surface: Path) -> None:
    fill(page, surface, load_n="-5", effective_modulus_gpa="")
    page.get_by_role("button", name="Predict contact").click()
    expect(page.locator("#error-load_n")).to_have_text(re.compile("Total normal force is -5; it must be positive"))
    expect(page.locator("#error-effective_modulus_gpa")).to_contain_text("Effective modulus E* is missing")
    expect(page.locator("#load_n")).to_have_attribute("aria-invalid", "true")
    expect(page.locator("#load_n")).to_be_focused()
    expect(page.locator("#error-resistivity_ohm_m")).to_be_empty()
    expect(page.locator("#numbers")).to_be_hidden()

    page.fill("#load_n", "5")
    page.fill("#effective_modulus_gpa", UNITS["effective_modulus_gpa"])
    page.fill("#pixel_size_um", "")
    page.fill("#height_range_um", "")
    page.get_by_role("button", name="Predict contact").click()
    expect(page.locator("#error-pixel_size_um")).to_contain_text("Pixel size is missing")
    expect(page.locator("#error-height_range_um")).to_contain_text("Height range is missing")
    expect(page.locator("#error-load_n")).to_be_empty()

    page.fill("#pixel_size_um", UNITS["pixel_size_um"])
    page.fill("#height_range_um", UNITS["height_range_um"])
    page.get_by_role("button", name="Predict contact").click()
    expect(page.locator("#numbers")).to_be_visible()
    expect(page.locator("#error-load_n")).to_be_empty()


def test_an_instrument_file_is_drawn_with_its_own_units(page: Page, tmp_path: Path) -> None:
    file = tmp_path / "scan.asc"
    file.write_bytes(ascii_grid(surface_codes()[:, :48] * 1e-9))
    fill(page, file, pixel_size_um="", height_range_um="")
    expect(page.locator("#surface-read")).to_contain_text("drawn once it is read")
    page.get_by_role("button", name="Predict contact").click()
    expect(page.locator("#numbers")).to_be_visible()
    expect(page.locator("#read")).to_contain_text("64 rows × 48 columns, ASC")
    expect(page.locator("#read")).to_contain_text("96 µm wide, 64 µm high; heights span 52.32 µm")
    assert painted(page, "#heights") == 64 * 48
    assert painted(page, "#overlay") > 0


def test_a_key_is_asked_for_where_one_is_required(browser: Browser, surface: Path) -> None:
    secret, key = new_key("page")
    with serving(ASPERITY_API_KEYS=f"[{key.model_dump_json(exclude_none=True)}]") as url:
        page = browser.new_page()
        page.goto(url)
        fill(page, surface)
        expect(page.locator("#key")).to_be_hidden()
        page.get_by_role("button", name="Predict contact").click()
        expect(page.locator("#error-form")).to_contain_text("requires an API key")
        page.fill("#key", secret)
        page.get_by_role("button", name="Predict contact").click()
        expect(page.locator("#numbers")).to_be_visible(timeout=PATIENCE_MS)
        assert painted(page, "#overlay") > 0
        expect(page.locator("#state")).to_have_text("finished", timeout=PATIENCE_MS)
        page.close()


def test_a_file_that_is_no_height_map_is_told_at_the_file(page: Page, tmp_path: Path) -> None:
    text = tmp_path / "notes.png"
    text.write_text("not a picture")
    fill(page, text)
    expect(page.locator("#surface-read")).to_have_text("not a PNG; drawn once it is read")
    page.get_by_role("button", name="Predict contact").click()
    expect(page.locator("#error-surface")).to_contain_text("no format that is read")


def test_two_bodies_in_place_of_the_effective_modulus(page: Page, surface: Path) -> None:
    fill(page, surface)
    page.locator("label", has=page.get_by_role("radio", name="Two bodies")).click()
    for name, value in {"youngs_modulus_1_gpa": "inf", "poissons_ratio_1": "0.3"}.items():
        page.fill(f"#{name}", value)
    page.get_by_role("button", name="Predict contact").click()
    expect(page.locator("#error-effective_modulus_gpa")).to_contain_text("Young’s modulus 2, Poisson’s ratio 2 missing")
    page.fill("#youngs_modulus_2_gpa", "6.2")
    page.fill("#poissons_ratio_2", "0.3")
    page.get_by_role("button", name="Predict contact").click()
    expect(page.locator("#numbers")).to_be_visible()
