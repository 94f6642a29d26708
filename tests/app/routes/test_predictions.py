"""POST /v1/predictions and what can be read again."""

import base64
import io
import time
from collections.abc import Callable

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from scipy.io import netcdf_file

from model import compare
from solver import boyer_resistance, effective_modulus
from tests.app.conftest import UNITS
from tests.app.files import ascii_grid, header, png, surface_codes, surface_png

Predict = Callable[..., httpx.Response]


def read_mask(data: bytes) -> NDArray[np.bool_]:
    image = Image.open(io.BytesIO(data))
    assert image.mode == "1"
    return np.asarray(image)


@pytest.fixture(scope="module")
def mask_of(client: httpx.Client) -> Callable[[httpx.Response], NDArray[np.bool_]]:
    def fetch(response: httpx.Response) -> NDArray[np.bool_]:
        assert response.status_code == 200, response.text
        answer = client.get(response.json()["mask_url"])
        assert answer.headers["content-type"] == "image/png"
        return read_mask(answer.content)

    return fetch


def test_numbers_agree_with_the_mask(predict: Predict, mask_of: Callable[..., NDArray[np.bool_]]) -> None:
    response = predict(resistivity_ohm_m="1.7e-8")
    answer, mask = response.json(), mask_of(response)
    assert 0 < mask.mean() < 1
    assert answer["contact_fraction"] == pytest.approx(mask.mean())
    assert answer["contact_area_mm2"] == pytest.approx(mask.mean() * 1.0)
    pixel = (15.625e-6, 15.625e-6)
    assert answer["contact_resistance_ohm"] == pytest.approx(boyer_resistance(mask, pixel, 1.7e-8))
    assert answer["method"] in {"surrogate", "surrogate and solver", "solver"}
    assert answer["verification"] is None
    quantities = ("dice", "contact_area", "contact_resistance")
    assert set(answer["expected_error"]) == {*quantities, *(f"{quantity}_bound" for quantity in quantities)}
    for quantity in quantities:
        assert 0 <= answer["expected_error"][quantity] <= answer["expected_error"][f"{quantity}_bound"] <= 1
    stages = [value for stage, value in answer["timings_ms"].items() if stage != "total"]
    assert all(stage >= 0 for stage in stages)
    assert 0 < sum(stages) <= answer["timings_ms"]["total"]


def test_the_accuracy_asked_for_is_reached(predict: Predict, mask_of: Callable[..., NDArray[np.bool_]]) -> None:
    exact = predict(accuracy="exact")
    assert exact.json()["method"] == "solver"
    assert set(exact.json()["expected_error"].values()) == {0.0}
    reference = mask_of(exact)
    for accuracy, floor in (("fast", 0.9), ("balanced", 0.97), ("0.02", 0.95)):
        assert compare(reference, mask_of(predict(accuracy=accuracy))).dice > floor


@pytest.mark.parametrize("accuracy", ["perfect", "2", "nan"])
def test_other_accuracies_are_refused(predict: Predict, accuracy: str) -> None:
    response = predict(accuracy=accuracy)
    assert response.status_code == 422
    (error,) = response.json()["errors"]
    assert error["field"] == "accuracy"
    assert "'balanced'" in error["detail"]


def test_what_was_read_is_told(predict: Predict) -> None:
    surface = predict().json()["surface"]
    assert (surface["rows"], surface["columns"], surface["bit_depth"]) == (64, 64, 16)
    assert surface["height_range_um"] == pytest.approx(50)
    assert surface["pixel_size_x_um"] == pytest.approx(15.625)


def test_no_resistance_is_guessed(predict: Predict) -> None:
    assert predict().json()["contact_resistance_ohm"] is None


def test_the_answer_can_be_read_again(predict: Predict, client: httpx.Client) -> None:
    answer = predict(verify="true").json()
    assert client.get(f"/v1/predictions/{answer['id']}").json() == answer


def test_the_same_request_is_computed_once(predict: Predict, client: httpx.Client) -> None:
    first = predict(load_n="20.25", verify="true")
    again = predict(load_n="20.25", verify="true", inline_mask="true")
    assert (first.headers["asperity-cache"], again.headers["asperity-cache"]) == ("miss", "hit")
    assert again.json() == first.json() | {"mask": again.json()["mask"]}
    for other in ({"load_n": "20.26"}, {"accuracy": "fast"}, {"outputs": "roughness"}, {"resistivity_ohm_m": "1e-8"}):
        assert predict(**{"load_n": "20.25"} | other).headers["asperity-cache"] == "miss"
    assert predict(surface_png(seed=9), load_n="20.25").headers["asperity-cache"] == "miss"


def test_a_known_prediction_can_be_verified_later_and_again(
    predict: Predict, client: httpx.Client, finish: Callable[[str], dict[str, object]]
) -> None:
    surface = surface_png(1024)
    assert predict(surface, load_n="2.5").json()["verification"] is None
    later = predict(surface, load_n="2.5", verify="true").json()
    client.delete(later["verification"]["url"])
    assert finish(later["verification"]["url"])["status"] == "canceled"
    again = predict(surface, load_n="2.5", verify="true").json()
    assert again["verification"]["job_id"] != later["verification"]["job_id"]
    assert client.get(f"/v1/predictions/{again['id']}").json() == again
    client.delete(again["verification"]["url"])


def test_an_idempotency_key_stands_for_one_request(client: httpx.Client) -> None:
    def post(load: str) -> httpx.Response:
        fields = UNITS | {"load_n": load, "verify": "false"}
        headers = {"idempotency-key": "my first request"}
        return client.post("/v1/predictions", data=fields, files={"surface": surface_png()}, headers=headers)

    assert post("7").json() == post("7").json()
    refused = post("8")
    assert refused.status_code == 422
    assert refused.json()["type"] == "/problems/idempotency-key-reused"


def test_who_would_rather_not_wait_is_told_where_to_ask(client: httpx.Client, predict: Predict) -> None:
    request = {"data": UNITS | {"load_n": "21.5"}, "files": {"surface": surface_png()}}
    accepted = client.post("/v1/predictions", headers={"Prefer": "respond-async"}, **request)  # type: ignore[arg-type]
    assert accepted.status_code == 202
    place = accepted.headers["location"]
    assert accepted.headers["preference-applied"] == "respond-async"
    assert accepted.json() == {"id": place.rpartition("/")[2], "url": place}
    while (answer := client.get(place)).status_code == 202:
        assert int(answer.headers["retry-after"]) > 0
        time.sleep(0.02)
    assert answer.json()["id"] == predict(load_n="21.5").json()["id"]
    at_once = client.post("/v1/predictions", headers={"Prefer": "respond-async, wait=30"}, **request)  # type: ignore[arg-type]
    assert at_once.json() == answer.json()
    assert at_once.headers["preference-applied"] == "wait=30"


def test_who_did_not_wait_is_told_what_was_wrong(client: httpx.Client) -> None:
    request = {"data": UNITS, "files": {"surface": surface_png()[:200]}}
    place = client.post("/v1/predictions", headers={"Prefer": "respond-async"}, **request).headers["location"]  # type: ignore[arg-type]
    while (answer := client.get(place)).status_code == 202:
        time.sleep(0.02)
    at_once = client.post("/v1/predictions", **request)  # type: ignore[arg-type]
    assert answer.status_code == at_once.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"
    assert {"type": answer.json()["type"], "detail": answer.json()["detail"]}.items() <= at_once.json().items()


def test_a_field_that_is_unknown_is_refused(predict: Predict) -> None:
    response = predict(bonudary="periodic")
    assert response.status_code == 422
    (error,) = response.json()["errors"]
    assert (error["field"], error["code"]) == ("bonudary", "unknown")
    assert "did you mean boundary?" in error["detail"]


def test_a_load_beyond_elasticity_is_told(predict: Predict) -> None:
    assert not any("linear elasticity" in warning for warning in predict(load_n="20").json()["warnings"])
    assert any("linear elasticity" in warning for warning in predict(load_n="2e5").json()["warnings"])


def test_what_was_not_asked_for_is_said_to_be_so(predict: Predict, client: httpx.Client) -> None:
    answer = predict(load_n="23.5").json()
    response = client.get(f"/v1/predictions/{answer['id']}/pressure.npy")
    assert response.status_code == 404
    assert "outputs=pressure" in response.json()["detail"]


def test_predictions_are_listed_newest_first_by_pages(predict: Predict, client: httpx.Client) -> None:
    ids = [predict(load_n=load).json()["id"] for load in ("31.5", "32.5", "33.5")]
    first = client.get("/v1/predictions", params={"limit": 2}).json()
    assert [one["id"] for one in first["items"]] == ids[:0:-1]
    assert client.get(first["next"]).json()["items"][0]["id"] == ids[0]
    assert client.get("/v1/predictions", params={"before": "0" * 32}).status_code == 404


def test_the_mask_comes_inline_on_request(predict: Predict, client: httpx.Client) -> None:
    answer = predict(inline_mask="true").json()
    assert base64.b64decode(answer["mask"]) == client.get(answer["mask_url"]).content
    assert predict().json()["mask"] is None


def test_only_what_is_asked_for_is_computed(predict: Predict, client: httpx.Client) -> None:
    plain = predict(resistivity_ohm_m="1e-7").json()
    assert plain["statistics"] is plain["resistances"] is plain["roughness"] is None
    assert plain["fields"] == {}
    assert client.get(f"/v1/predictions/{plain['id']}/pressure.npy").status_code == 404
    asked = predict(
        resistivity_ohm_m="1e-7", outputs="statistics,resistances, roughness,pressure,heights,probability"
    ).json()
    assert asked["statistics"]["contact_spots"] >= 1
    assert asked["resistances"]["boyer_ohm"] == pytest.approx(asked["contact_resistance_ohm"])
    assert asked["roughness"]["rms_slope"] == pytest.approx(asked["surface"]["rms_slope"], rel=0.1)
    assert set(asked["fields"]) == {"pressure", "heights", "probability"}


def test_fields_come_as_numpy_picture_and_netcdf(
    predict: Predict, client: httpx.Client, mask_of: Callable[..., NDArray[np.bool_]]
) -> None:
    response = predict(outputs="pressure,heights")
    answer, mask = response.json(), mask_of(response)
    pressure = np.load(io.BytesIO(client.get(answer["fields"]["pressure"]["npy_url"]).content))
    np.testing.assert_array_equal(pressure > 0, mask)
    assert pressure.sum() * (15.625e-6) ** 2 == pytest.approx(20)
    link = answer["fields"]["heights"]
    assert link["unit"] == "m"
    codes = np.asarray(Image.open(io.BytesIO(client.get(link["png_url"]).content)))
    heights = link["lowest"] + codes / 65535 * (link["highest"] - link["lowest"])
    np.testing.assert_allclose(heights, surface_codes() / 65535 * 50e-6, atol=1e-9)
    bundle = client.get(answer["bundle_url"])
    with netcdf_file(io.BytesIO(bundle.content), mmap=False) as root:
        np.testing.assert_array_equal(root.variables["contact_mask"][:], mask)
        np.testing.assert_array_equal(root.variables["pressure"][:], pressure)
        assert root.variables["pressure"].units == b"Pa"


@pytest.mark.parametrize(
    ("outputs", "words"), [("pressure,stress", "heights, pressure"), ("resistances", "mean resistivity of the two bodies")]
)
def test_outputs_that_cannot_be(predict: Predict, outputs: str, words: str) -> None:
    response = predict(outputs=outputs)
    assert response.status_code == 422
    (error,) = response.json()["errors"]
    assert error["field"] == "outputs"
    assert words in error["detail"]


def test_a_file_with_units_needs_none(predict: Predict) -> None:
    data = ascii_grid(surface_codes()[:, :48] * 1e-9)
    response = predict(data, pixel_size_um=None, height_range_um=None)
    assert response.status_code == 200, response.text
    surface = response.json()["surface"]
    assert surface["file_format"] == "ASC"
    assert (surface["pixel_size_x_um"], surface["pixel_size_y_um"]) == pytest.approx((2, 1))
    assert surface["height_range_um"] == pytest.approx(np.ptp(surface_codes()[:, :48]) * 1e-3, rel=1e-3)


def test_two_rough_surfaces(predict: Predict, client: httpx.Client) -> None:
    """Half of the negative of a surface, turned over, leaves half of its roughness."""
    second = png((65535 - surface_codes()[:, ::-1]) // 2)
    files = {"surface": surface_png(), "surface_2": second}
    data = UNITS | {"height_range_2_um": "50", "verify": "false"}
    answer = client.post("/v1/predictions", data=data, files=files)
    assert answer.status_code == 200, answer.text
    assert answer.json()["surface"]["height_range_um"] == pytest.approx(25, rel=1e-3)


def test_the_same_problem_in_other_units_has_the_same_mask(
    predict: Predict, mask_of: Callable[..., NDArray[np.bool_]]
) -> None:
    reference = mask_of(predict())
    per_axis = predict(pixel_size_um=None, pixel_size_x_um="15.625", pixel_size_y_um="15.625")
    np.testing.assert_array_equal(mask_of(per_axis), reference)
    bodies = {
        "youngs_modulus_1_gpa": "10",
        "poissons_ratio_1": "0.3",
        "youngs_modulus_2_gpa": "20",
        "poissons_ratio_2": "0.25",
    }
    modulus = effective_modulus(10, 0.3, 20, 0.25)
    np.testing.assert_array_equal(
        mask_of(predict(effective_modulus_gpa=None, **bodies)), mask_of(predict(effective_modulus_gpa=repr(modulus)))
    )


def test_rows_and_columns_stay_as_uploaded(predict: Predict, mask_of: Callable[..., NDArray[np.bool_]]) -> None:
    codes = surface_codes()[:, :40].copy()
    codes[:20] //= 4
    pixels = {"pixel_size_um": None, "pixel_size_x_um": "10", "pixel_size_y_um": "20"}
    response = predict(png(codes), **pixels)
    surface, mask = response.json()["surface"], mask_of(response)
    assert (surface["rows"], surface["columns"]) == mask.shape == (64, 40)
    assert (surface["pixel_size_x_um"], surface["pixel_size_y_um"]) == pytest.approx((10, 20))
    assert not mask[:20].any()
    assert codes[mask].mean() > np.quantile(codes, 0.9)
    turned = mask_of(predict(png(codes.T.copy()), pixel_size_um=None, pixel_size_x_um="20", pixel_size_y_um="10"))
    assert (mask == turned.T).mean() > 0.95


@pytest.mark.parametrize(
    ("surface", "fields", "status", "code", "field", "words"),
    [
        (surface_png(), {"load_n": "-1"}, 422, "invalid-form", "load_n", "load_n is -1; it must be positive"),
        (surface_png(), {"load_n": "NaN"}, 422, "invalid-form", "load_n", "must be a finite number"),
        (surface_png(), {"height_range_um": None}, 422, "invalid-form", "height_range_um", "give the height from black"),
        (surface_png(), {"load_n": ""}, 422, "invalid-form", "load_n", "load_n is missing"),
        (surface_png(), {"verify": "perhaps"}, 422, "invalid-form", "verify", "true or false"),
        (surface_png()[:500], {}, 422, "truncated-png", "surface", "ends before"),
        (b"GIF89a", {}, 415, "unknown-format", "surface", "Send PNG, TIFF"),
        (header(9000, 9000), {}, 413, "image-too-large", "surface", "Crop"),
        (png(np.full((64, 64), 7, np.uint8)), {}, 422, "constant-heights", "surface", "same height"),
        (png(np.arange(6, dtype=np.uint8).reshape(2, 3)), {}, 422, "invalid-heights", "surface", "2 x 3 pixels"),
        (
            surface_png(),
            {
                "effective_modulus_gpa": None,
                "youngs_modulus_1_gpa": "inf",
                "poissons_ratio_1": "0.3",
                "youngs_modulus_2_gpa": "inf",
                "poissons_ratio_2": "0.3",
            },
            422,
            "invalid-material",
            "effective_modulus_gpa",
            "Both bodies are rigid",
        ),
    ],
)
def test_refusals(
    predict: Predict, surface: bytes, fields: dict[str, str | None], status: int, code: str, field: str, words: str
) -> None:
    response = predict(surface, **fields)
    problem = response.json()
    assert response.status_code == problem["status"] == status
    assert response.headers["content-type"] == "application/problem+json"
    assert problem["type"] == f"/problems/{code}"
    assert problem["instance"] == "/v1/predictions"
    assert [error["field"] for error in problem["errors"]] == [field]
    assert words in problem["detail"]


def test_without_a_file_it_says_so(client: httpx.Client) -> None:
    problem = client.post("/v1/predictions", data={"load_n": "1"}).json()
    assert "surface" in [error["field"] for error in problem["errors"]]


def test_too_large_an_upload_is_refused(predict: Predict) -> None:
    response = predict(bytes(5 * 2**20))
    assert response.status_code == 413
    assert response.json()["type"] == "/problems/upload-too-large"


@pytest.mark.parametrize("prediction_id", ["0" * 32, "nonsense", "..%2F..%2Fredis"])
@pytest.mark.parametrize("rest", ["", "/mask.png"])
def test_unknown_ids_are_not_found(client: httpx.Client, prediction_id: str, rest: str) -> None:
    response = client.get(f"/v1/predictions/{prediction_id}{rest}")
    assert response.status_code == 404
    assert response.headers["content-type"] == "application/problem+json"
