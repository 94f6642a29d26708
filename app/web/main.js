// The page: choose a file, see what was read, predict, watch the verification arrive.

import { file as load, predict, Problem, useKey } from "./api.js";
import { showPrediction } from "./answer.js";
import { clearErrors, contents, showErrors, units } from "./form.js";
import { length } from "./format.js";
import { clearPicture, decode, drawHeights, drawMasks, drawnWidth, loadMask, setOpacity, setShape } from "./picture.js";
import { readHeader } from "./png.js";
import { follow, forget } from "./verification.js";

const at = (id) => document.getElementById(id);
const form = at("form");

/** The map chosen, what the service read of it, and the masks known of it. */
const shown = { file: null, header: null, levels: null, read: null, predicted: null, reference: null };

async function chooseFile() {
  const [file] = at("surface").files;
  if (!file) return;
  forget();
  clearErrors();
  at("numbers").hidden = true;
  at("controls").hidden = true;
  at("legend").replaceChildren();
  at("drop").classList.add("filled");
  at("drop-title").textContent = file.name;
  Object.assign(shown, { file, header: await readHeader(file), levels: null, read: null, predicted: null, reference: null });
  const { header } = shown;
  at("surface-read").textContent = header
    ? `${header.rows} rows × ${header.columns} columns, ${header.bitDepth}-bit${header.grey ? " grey" : ", not grey"}`
    : "not a PNG; drawn once it is read";
  if (header) await draw(file);
  else erase();
}

async function draw(picture) {
  try {
    shown.levels = drawHeights(await decode(picture));
    at("empty").hidden = true;
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    at("surface-read").textContent += "; the browser cannot draw it";
  }
  describe();
}

function erase() {
  clearPicture();
  at("caption").hidden = true;
  at("empty").hidden = false;
}

/** The map as far as it is known: what the service read, else the header of the PNG and the units typed so far. */
function known() {
  const { header, read, levels } = shown;
  if (read) {
    return {
      rows: read.rows,
      columns: read.columns,
      kind: read.file_format,
      dy: read.pixel_size_y_um,
      dx: read.pixel_size_x_um,
      low: 0,
      high: read.height_range_um,
    };
  }
  if (!header) return null;
  const { dy, dx, range } = units();
  const { lowest, highest } = levels ?? { lowest: 0, highest: 1 };
  const { rows, columns } = header;
  return { rows, columns, kind: `${header.bitDepth}-bit`, dy, dx, low: lowest * range, high: highest * range };
}

/** Say what was read, with its physical size as far as the units are known. */
function describe() {
  const map = known();
  if (!map) return;
  const { rows, columns, dy, dx, low, high } = map;
  const sized = dy > 0 && dx > 0;
  const scaled = high > low;
  const size = sized ? `${length(columns * dx)} wide, ${length(rows * dy)} high` : "size: give the pixel size";
  const heights = scaled ? `heights span ${length(high - low)}` : "heights: give the height range";
  const details = Object.assign(document.createElement("span"), { textContent: `${size}; ${heights}` });
  at("read").replaceChildren(`${rows} rows × ${columns} columns, ${map.kind}`, details);
  at("ramp-low").textContent = scaled ? length(low) : "low";
  at("ramp-high").textContent = scaled ? length(high) : "high";
  at("caption").hidden = false;
  setShape(sized ? (columns * dx) / (rows * dy) : columns / rows);
  drawBar(sized ? columns * dx : null);
}

/** A scale bar of 1, 2 or 5 times a power of ten, about a quarter of the map. */
function drawBar(width) {
  at("bar").parentElement.hidden = width === null;
  if (width === null) return;
  const power = 10 ** Math.floor(Math.log10(width / 4));
  const size = [5, 2, 1].map((step) => step * power).find((step) => step <= width / 4);
  at("bar").style.width = `${(drawnWidth() * size) / width}px`;
  at("bar-length").textContent = length(size);
}

function drawView() {
  const { predicted, reference } = shown;
  const view = form.ownerDocument.querySelector("input[name=view]:checked").value;
  drawMasks(view === "reference" ? null : predicted, view === "predicted" ? null : reference);
  const entries = view === "difference"
    ? [["touch", "both"], ["only-predicted", "predicted only"], ["only-reference", "reference only"]]
    : [["touch", `${view} contact`]];
  at("legend").replaceChildren(
    ...entries.map(([className, textContent]) => Object.assign(document.createElement("li"), { className, textContent })),
  );
}

function offerReference(offered) {
  for (const value of ["reference", "difference"]) document.querySelector(`input[value=${value}]`).disabled = !offered;
  if (!offered) document.querySelector("input[value=predicted]").checked = true;
}

async function submit(event) {
  event.preventDefault();
  if (at("predict").ariaBusy === "true") return;
  forget();
  clearErrors();
  at("predict").ariaBusy = "true";
  at("predict").textContent = "Predicting…";
  try {
    const { file, header } = shown;
    if (at("key").value) useKey(at("key").value);
    const fields = contents();
    if (!header) fields.set("outputs", "heights");
    const prediction = await predict(fields);
    const predicted = await loadMask(prediction.mask_url);
    const picture = header ? null : await load(prediction.fields.heights.png_url);
    if (shown.file !== file) return; // another was chosen meanwhile
    Object.assign(shown, { predicted, reference: null });
    if (picture) {
      shown.read = prediction.surface;
      await draw(picture);
    }
    offerReference(false);
    showPrediction(prediction);
    at("controls").hidden = false;
    drawView();
    describe();
    if (at("picture").getBoundingClientRect().top > window.innerHeight / 2) at("picture").scrollIntoView({ behavior: "smooth" });
    if (prediction.verification) verify(prediction.verification.url);
  } catch (error) {
    if (!(error instanceof Problem)) throw error;
    if (error.status === 401) at("key-field").hidden = false;
    showErrors(error);
  } finally {
    at("predict").ariaBusy = "false";
    at("predict").textContent = "Predict contact";
  }
}

async function verify(url) {
  const job = await follow(url);
  if (!job?.result.mask_url) return;
  shown.reference = await loadMask(job.result.mask_url);
  offerReference(true);
}

at("surface").addEventListener("change", chooseFile);
form.addEventListener("input", describe);
form.addEventListener("change", describe);
form.addEventListener("submit", submit);
at("opacity").addEventListener("input", (event) => setOpacity(event.target.value / 100));
for (const radio of document.querySelectorAll("input[name=view]")) radio.addEventListener("change", drawView);
for (const name of ["dragenter", "dragover"]) at("drop").addEventListener(name, () => at("drop").classList.add("over"));
for (const name of ["dragleave", "drop"]) at("drop").addEventListener(name, () => at("drop").classList.remove("over"));
window.addEventListener("resize", describe);
setOpacity(at("opacity").value / 100);
