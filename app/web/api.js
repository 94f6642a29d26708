// The HTTP interface: JSON in, JSON out, refusals as Problem.

const KEY = "asperity-key";

/** A problem document (RFC 9457) as an error; `errors` lists { field, detail }. */
export class Problem extends Error {
  constructor(document) {
    super(document.detail);
    this.status = document.status;
    this.errors = document.errors;
  }
}

/** Send this API key from now on, in this window. */
export const useKey = (key) => sessionStorage.setItem(KEY, key);

async function send(url, options = {}) {
  const key = sessionStorage.getItem(KEY);
  let response;
  try {
    response = await fetch(url, { ...options, headers: key ? { Authorization: `Bearer ${key}` } : {} });
  } catch {
    throw new Problem({ detail: "The service cannot be reached. Is it running?", errors: [] });
  }
  if ((response.headers.get("content-type") ?? "").startsWith("application/problem+json")) {
    throw new Problem(await response.json());
  }
  return response;
}

const json = async (url, options) => (await send(url, options)).json();

/** @param {FormData} form */
export const predict = (form) => json("/v1/predictions", { method: "POST", body: form });

export const job = (url) => json(url);

export const cancel = (url) => json(url, { method: "DELETE" });

/** @returns {Promise<Blob>} */
export const file = async (url) => (await send(url)).blob();
