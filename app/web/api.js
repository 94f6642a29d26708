// The HTTP interface: JSON in, JSON out, refusals as Problem.

/** A problem document (RFC 9457) as an error; `errors` lists { field, detail }. */
export class Problem extends Error {
  constructor(document) {
    super(document.detail);
    this.errors = document.errors;
  }
}

async function request(url, options) {
  let response;
  try {
    response = await fetch(url, options);
  } catch {
    throw new Problem({ detail: "The service cannot be reached. Is it running?", errors: [] });
  }
  if ((response.headers.get("content-type") ?? "").startsWith("application/problem+json")) {
    throw new Problem(await response.json());
  }
  return response.json();
}

/** @param {FormData} form */
export const predict = (form) => request("/v1/predictions", { method: "POST", body: form });

export const job = (url) => request(url);

export const cancel = (url) => request(url, { method: "DELETE" });
