"""From height maps and the fields of a form to the contact problem in SI units: the one place where units are converted."""

from collections.abc import Iterator, Mapping

from app.errors import FieldError, InvalidFormError
from app.forms import BodiesForm, meaning
from app.height_map import LARGEST_SIDE, HeightMap
from app.preparation import composite, cropped, detrended, filled, resampled
from solver.problem import ContactProblem, FloatArray, effective_modulus

SAME = 1e-3
"""Relative difference up to which two pixel sizes count as one."""

Size = tuple[float, float]


def contact_problem(form: BodiesForm, load: float, height_map: HeightMap, second: HeightMap | None = None) -> ContactProblem:
    """Heights in m, prepared as the form says, under a load.

    Args:
        form: what people gave besides files.
        load: in N.
        height_map: of the rough surface.
        second: of the surface that it touches, seen from outside its body; a flat if left out.

    Raises:
        InvalidFormError: a unit is missing that the file does not hold, or something does not fit the map.
        InvalidProblemError: the map is too small, or both bodies are rigid.
    """
    maps = {"height_range_um": height_map} | ({} if second is None else {"height_range_2_um": second})
    pixel_size = given_pixel_size(form) or height_map.pixel_size
    faults = list(_unit_faults(form, maps, pixel_size))
    if faults or pixel_size is None:
        raise InvalidFormError(faults)
    units = {name: unit for name, one in maps.items() if (unit := _height_unit(form, one, name)) is not None}
    heights = _heights(form, height_map, units["height_range_um"])
    if second is not None:
        other = _heights(form, second, units["height_range_2_um"])
        _check_second(heights, other, pixel_size, second)
        heights = composite(heights, other)
    heights = detrended(heights, form.detrend)
    if form.resample_um is not None:
        shape = _new_shape(heights.shape, pixel_size, form.resample_um * 1e-6)
        heights, pixel_size = resampled(heights, shape), _covering(heights.shape, pixel_size, shape)
    return ContactProblem(
        heights=heights,
        pixel_size=pixel_size,
        load=load,
        effective_modulus=_effective_modulus(form),
        boundary=form.boundary,
        hardness=None if form.hardness_gpa is None else form.hardness_gpa * 1e9,
    )


def differ(one: Size, other: Size) -> bool:
    """Whether two pixel sizes are not the same."""
    return any(abs(a / b - 1) > SAME for a, b in zip(one, other, strict=True))


def given_pixel_size(form: BodiesForm) -> Size | None:
    """dy, dx in m, as the form has it."""
    if form.pixel_size_um is not None:
        return form.pixel_size_um * 1e-6, form.pixel_size_um * 1e-6
    if form.pixel_size_y_um is not None and form.pixel_size_x_um is not None:
        return form.pixel_size_y_um * 1e-6, form.pixel_size_x_um * 1e-6
    return None


def _heights(form: BodiesForm, height_map: HeightMap, unit: float) -> FloatArray:
    """In m, cropped, without gaps."""
    values = height_map.values
    if form.crop is not None:
        values = cropped(values, form.crop)
        if values.shape != (form.crop.rows, form.crop.columns):
            rows, columns = height_map.values.shape
            raise _refusal("crop", "out-of-range", f"crop reaches beyond the map of {rows} x {columns} pixels.")
    heights: FloatArray = filled(values) * unit
    return heights


def _height_unit(form: BodiesForm, height_map: HeightMap, range_field: str) -> float | None:
    """What a value of 1 means, in m; None where neither request nor file says."""
    given = getattr(form, range_field) if height_map.bit_depth is not None else form.height_unit_um
    return height_map.height_unit if given is None else float(given) * 1e-6


def _unit_faults(form: BodiesForm, maps: Mapping[str, HeightMap], pixel_size: Size | None) -> Iterator[FieldError]:
    """Units that are missing, or that do not belong to the files; all of them at once."""
    if pixel_size is None:
        first = next(iter(maps.values())).file_format
        yield FieldError(
            "pixel_size_um",
            "missing",
            f"pixel_size_um is missing, and the {first} file does not hold it: give the {meaning('pixel_size_um')}, or "
            "pixel_size_x_um, pixel_size_y_um.",
        )
    for range_field, height_map in maps.items():
        image, name = height_map.bit_depth is not None, height_map.file_format
        wanted = range_field if image else "height_unit_um"
        if not image and getattr(form, range_field) is not None:
            yield FieldError(
                range_field,
                "not-for-this-file",
                f"{range_field} is for grey images; the {name} file holds heights as numbers. Leave it out; height_unit_um "
                "says what their unit is where the file does not.",
            )
        elif _height_unit(form, height_map, range_field) is None:
            yield FieldError(wanted, "missing", f"{wanted} is missing: give the {meaning(wanted)}.")


def _check_second(heights: FloatArray, other: FloatArray, pixel_size: Size, second: HeightMap) -> None:
    advice = "give both on the same grid."
    if heights.shape != other.shape:
        (rows, columns), (rows_2, columns_2) = heights.shape, other.shape
        sizes = f"surface_2 has {rows_2} x {columns_2} pixels, surface {rows} x {columns}"
        raise _refusal("surface_2", "other-shape", f"{sizes}; {advice}")
    if second.pixel_size and differ(second.pixel_size, pixel_size):
        raise _refusal("surface_2", "other-pixel-size", f"surface_2 has pixels of another size than surface; {advice}")


def _new_shape(shape: tuple[int, ...], pixel_size: Size, wanted: float) -> tuple[int, int]:
    rows, columns = (max(1, round(side * size / wanted)) for side, size in zip(shape, pixel_size, strict=True))
    if max(rows, columns) > LARGEST_SIDE:
        raise _refusal(
            "resample_um",
            "out-of-range",
            f"resample_um makes {rows} x {columns} pixels; each side may have up to {LARGEST_SIDE}.",
        )
    return rows, columns


def _covering(shape: tuple[int, ...], pixel_size: Size, new: tuple[int, int]) -> Size:
    """Pixel size of a new grid over the same area."""
    return shape[0] * pixel_size[0] / new[0], shape[1] * pixel_size[1] / new[1]


def _effective_modulus(form: BodiesForm) -> float:
    """E* in Pa."""
    if form.effective_modulus_gpa is not None:
        return form.effective_modulus_gpa * 1e9
    bodies = form.youngs_modulus_1_gpa, form.poissons_ratio_1, form.youngs_modulus_2_gpa, form.poissons_ratio_2
    modulus_1, ratio_1, modulus_2, ratio_2 = (value for value in bodies if value is not None)
    return effective_modulus(modulus_1 * 1e9, ratio_1, modulus_2 * 1e9, ratio_2)


def _refusal(field: str, code: str, detail: str) -> InvalidFormError:
    return InvalidFormError([FieldError(field, code, detail)])
