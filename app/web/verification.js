// Follow a verification job until it ends.

import { cancel, job as fetchJob, Problem } from "./api.js";
import { showComparison } from "./answer.js";
import { number } from "./format.js";

const POLL_MS = 400;
const TOLERANCE = 1e-6; // residual at which the reference solve ends
const ENDED = ["finished", "failed", "canceled"];
const WORDS = { queued: "waiting", started: "solving", finished: "finished", failed: "failed", canceled: "canceled" };

const at = (id) => document.getElementById(id);
let followed = null;

at("cancel").addEventListener("click", () => followed && withoutFailing(cancel(followed)));

/** The answer, or null with the problem shown: what fails now is asked again at the next turn. */
async function withoutFailing(answer) {
  try {
    return await answer;
  } catch (error) {
    if (!(error instanceof Problem)) throw error;
    at("progress-text").textContent = error.message;
    return null;
  }
}

/** Show the job at `url` as it goes; resolves with the finished job, or null if it ended otherwise. */
export async function follow(url) {
  followed = url;
  at("comparison").replaceChildren();
  at("reference").textContent = "";
  at("verification").hidden = false;
  let first = null;
  while (followed === url) {
    const job = await withoutFailing(fetchJob(url));
    if (followed !== url) return null;
    if (job) {
      first ??= job.progress?.residual;
      showProgress(job, first);
      if (job.status === "finished") {
        showComparison(job);
        return job;
      }
      if (ENDED.includes(job.status)) return null;
    }
    await new Promise((resolve) => setTimeout(resolve, POLL_MS));
  }
  return null;
}

function showProgress(job, first) {
  const { status, progress } = job;
  const running = !ENDED.includes(status);
  at("state").textContent = WORDS[status];
  at("state").className = `state ${status}`;
  at("cancel").hidden = !running;
  at("progress").hidden = !running;
  if (!running) {
    at("progress-text").textContent = job.error ?? "";
  } else if (progress) {
    at("progress-text").textContent = `Iteration ${progress.iteration}, residual ${number(progress.residual, 2)}`;
    at("progress").value = Math.log(first / progress.residual) / Math.log(first / TOLERANCE) || 0;
  } else {
    at("progress-text").textContent =
      status === "queued" ? "Waiting for a worker." : "The reference solver has started.";
    at("progress").value = 0;
  }
}

/** Stop following, as another prediction begins. */
export function forget() {
  followed = null;
  at("verification").hidden = true;
}
