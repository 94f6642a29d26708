// The form: which fields are asked for, what it holds, and errors beside the field they concern.

const form = document.getElementById("form");

function show(choice, shown) {
  for (const part of form.querySelectorAll(`[data-choice="${choice}"]`)) {
    part.hidden = !shown;
    for (const input of part.querySelectorAll("input")) input.disabled = !shown;
  }
}

function choose() {
  const oblong = document.getElementById("oblong").checked;
  const bodies = form.elements.material.value === "bodies";
  show("square", !oblong);
  show("oblong", oblong);
  show("effective", !bodies);
  show("bodies", bodies);
}

document.getElementById("oblong").addEventListener("change", choose);
for (const radio of form.elements.material) radio.addEventListener("change", choose);
choose();

/** What is sent: the fields shown, as typed. */
export function contents() {
  const data = new FormData(form);
  data.delete("material");
  if (!data.has("verify")) data.set("verify", "false");
  if (data.get("surface").size === 0) data.delete("surface");
  return data;
}

/** Pixel size (y, x) and height range in micrometres as typed so far; NaN where they are not numbers. */
export function units() {
  const typed = (name) => parseFloat(form.elements[name].value);
  const oblong = document.getElementById("oblong").checked;
  return {
    dy: typed(oblong ? "pixel_size_y_um" : "pixel_size_um"),
    dx: typed(oblong ? "pixel_size_x_um" : "pixel_size_um"),
    range: typed("height_range_um"),
  };
}

export function clearErrors() {
  for (const message of form.querySelectorAll(".error")) message.textContent = "";
  for (const input of form.querySelectorAll("[aria-invalid]")) input.removeAttribute("aria-invalid");
}

/** A message in the words of this page: labels in place of the names of fields. */
function inWords(detail) {
  return detail.replace(/\b[a-z]+(_[a-z0-9]+)+\b|^surface\b/g, (name) => {
    const input = form.elements[name];
    return input?.ariaLabel ?? input?.labels?.[0].firstChild.textContent.trim() ?? name;
  });
}

/** Put each message beside its field, the rest above the button; focus the first field concerned. */
export function showErrors(problem) {
  clearErrors();
  const elsewhere = [];
  for (const { field, detail } of problem.errors) {
    const place = document.getElementById(`error-${field}`);
    if (place) place.textContent = inWords(detail);
    else elsewhere.push(inWords(detail));
    form.elements[field]?.setAttribute?.("aria-invalid", "true");
  }
  if (problem.errors.length === 0) elsewhere.push(problem.message);
  document.getElementById("error-form").textContent = elsewhere.join(" ");
  form.querySelector("[aria-invalid]:enabled")?.focus();
}
