// Pictures come before the run and are decoded by then. Answers go at once; what does not arrive is
// sent again until it has.

const AGAIN_MS = 1000;

async function fetchPicture(address) {
  const answer = await fetch(address);
  const type = answer.headers.get("content-type") || "";
  if (!answer.ok || !type.startsWith("image/")) {
    throw new Error(answer.ok ? "the app did not answer" : await answer.text());
  }
  return createImageBitmap(await answer.blob());
}

async function fetchTrial(url, trial) {
  const [full, coarse] = await Promise.all(
    ["full", "coarse"].map((view) => fetchPicture(`${url}/${trial.picture}/${view}.png`)),
  );
  return { ...trial, full, coarse };
}

// Resolves when the app has kept it; rejects when it never will. Calls `onRetry` before each wait.
async function put(address, content, onRetry) {
  for (;;) {
    let answer = null;
    try {
      answer = await fetch(address, { method: "PUT", body: JSON.stringify(content), keepalive: true });
    } catch {
      answer = null; // not reached: try again
    }
    if (answer && answer.status < 300) return;
    if (answer && answer.status < 500) throw new Error(await answer.text());
    onRetry();
    await new Promise((done) => setTimeout(done, AGAIN_MS));
  }
}
