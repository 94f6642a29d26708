// The page: choose a file, see what was read, predict, watch the verification arrive.

import { predict, Problem } from "./api.js";
import { showPrediction } from "./answer.js";
import { clearErrors, contents, showErrors, units } from "./form.js";
import { length } from "./format.js";
import { decode, drawHeights, drawMasks, drawnWidth, loadMask, setOpacity, setShape } from "./picture.js";
import { readHeader } from "./png.js";
import { follow, forget } from "./verification.js";

const at = (id) => document.getElementById(id);
const form = at("form");

/** The map chosen and the masks known of it. */
const shown = { header: null, levels: null, predicted: null, reference: null };

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
  shown.levels = null;
  shown.header = await readHeader(file);
  const { header } = shown;
  at("surface-read").textContent = header
    ? `${header.rows} rows × ${header.columns} columns, ${header.bitDepth}-bit${header.grey ? " grey" : ", not grey"}`
    : "not a PNG file";
  if (!header) return;
  try {
    shown.levels = drawHeights(await decode(file));
    at("empty").hidden = true;
  } catch (error) {
    if (!(error instanceof DOMException)) throw error;
    at("surface-read").textContent += "; the browser cannot draw it";
  }
  describe();
}

/** Say what was read, with its physical size as far as the units are typed. */
function describe() {
  const { header } = shown;
  if (!header) return;
  const { dy, dx, range } = units();
  const sized = dy > 0 && dx > 0;
  const pixels = `${header.rows} rows × ${header.columns} columns`;
  const size = sized ? `${length(header.columns * dx)} wide, ${length(header.rows * dy)} high` : "size: give the pixel size";
  const levels = shown.levels ?? { lowest: 0, highest: 1 };
  const heights = range > 0 ? `heights span ${length((levels.highest - levels.lowest) * range)}` : "heights: give the height range";
  const details = Object.assign(document.createElement("span"), { textContent: `${size}; ${heights}` });
  at("read").replaceChildren(`${pixels}, ${header.bitDepth}-bit`, details);
  at("ramp-low").textContent = range > 0 ? length(levels.lowest * range) : "low";
  at("ramp-high").textContent = range > 0 ? length(levels.highest * range) : "high";
  at("caption").hidden = false;
  setShape(sized ? (header.columns * dx) / (header.rows * dy) : header.columns / header.rows);
  drawBar(sized ? header.columns * dx : null);
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
    const prediction = await predict(contents());
    shown.predicted = await loadMask(prediction.mask_url);
    shown.reference = null;
    offerReference(false);
    showPrediction(prediction);
    at("controls").hidden = false;
    drawView();
    drawBar(prediction.surface.columns * prediction.surface.pixel_size_x_um);
    if (at("picture").getBoundingClientRect().top > window.innerHeight / 2) at("picture").scrollIntoView({ behavior: "smooth" });
    if (prediction.verification) verify(prediction.verification.url);
  } catch (error) {
    if (!(error instanceof Problem)) throw error;
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
