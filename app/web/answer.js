// The numbers of a prediction and of a verification.

import { area, duration, length, number, percent, resistance, score, signed } from "./format.js";

const at = (id) => document.getElementById(id);

function figure(term, value, note, lead = false) {
  const group = document.createElement("div");
  if (lead) group.className = "lead";
  const dt = document.createElement("dt");
  dt.textContent = term;
  const dd = document.createElement("dd");
  dd.textContent = value;
  if (note) dd.append(Object.assign(document.createElement("small"), { textContent: note }));
  group.append(dt, dd);
  return group;
}

export function showPrediction(prediction) {
  const { expected_error: expected, timings_ms: timings, surface } = prediction;
  const ohm = prediction.contact_resistance_ohm;
  at("figures").replaceChildren(
    figure("Contact area", area(prediction.contact_area_mm2), `± ${percent(expected.contact_area, 2)} expected`, true),
    figure("Contact fraction", percent(prediction.contact_fraction), "of the nominal area"),
    ohm === null
      ? figure("Contact resistance", "–", "no resistivity given")
      : figure("Contact resistance", resistance(ohm), `± ${percent(expected.contact_resistance, 2)} expected`),
    figure("Expected Dice", score(1 - expected.dice), "overlap with the exact mask"),
    figure("Rms height", length(surface.rms_height_um)),
    figure("Rms slope", number(surface.rms_slope, 3)),
    figure("Answered in", duration(timings.total)),
  );
  at("warnings").replaceChildren(
    ...prediction.warnings.map((text) => Object.assign(document.createElement("li"), { textContent: text })),
  );
  at("provenance").textContent = `Method ${prediction.method}, model ${prediction.model}, id ${prediction.id}`;
  at("timings").replaceChildren(
    ...Object.entries(timings).map(([stage, milliseconds]) => {
      const row = document.createElement("tr");
      row.append(
        Object.assign(document.createElement("th"), { scope: "row", textContent: stage }),
        Object.assign(document.createElement("td"), { textContent: `${number(milliseconds, 3)} ms` }),
      );
      return row;
    }),
  );
  at("numbers").hidden = false;
}

export function showComparison(job) {
  const { comparison, result } = job;
  at("comparison").replaceChildren(
    figure("Dice", score(comparison.dice), "overlap of the two masks", true),
    figure("Area error", signed(comparison.area_error)),
    figure("Resistance error", comparison.resistance_error === null ? "–" : signed(comparison.resistance_error)),
    figure("BF score", score(comparison.bf_score)),
    figure("Jaccard", score(comparison.jaccard)),
    figure("Pixel accuracy", score(comparison.pixel_accuracy)),
    figure("Reference area", area(result.contact_area_mm2)),
    ...(result.contact_resistance_ohm === null
      ? []
      : [figure("Reference resistance", resistance(result.contact_resistance_ohm))]),
  );
  at("reference").textContent = result.status;
}
