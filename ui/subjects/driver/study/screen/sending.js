// Pictures come before the run and are decoded by then. Answers go at once; what the app has not kept
// is sent again until it has, also after the page was loaded again, or the app has started anew.

const AGAIN_MS = 1000;
const DRAWN_AGAIN = 10; // tries at an address that is gone, until the page is to be drawn again
const NEVER = [400, 413]; // no other try makes these better
const STORED = "nvcore_study_unsent";

async function fetchPicture(address) {
  const answer = await fetch(address);
  const type = answer.headers.get("content-type") || "";
  if (!answer.ok || !type.startsWith("image/")) {
    throw new Error(answer.ok ? "the app did not answer" : await answer.text());
  }
  return createImageBitmap(await answer.blob());
}

export async function fetchTrial(url, trial) {
  const [full, coarse] = await Promise.all(
    ["full", "coarse"].map((view) => fetchPicture(`${url}/${trial.picture}/${view}.png`)),
  );
  return { ...trial, full, coarse };
}

// One at a time and in their order: an answer that overtakes the report that its picture appears is
// marked. The tab's storage holds them until they are kept, under whose they are.
class Outbox {
  constructor() {
    this.unsent = this.stored();
    this.left = []; // what is sent of it
    this.answered = new Set(); // trials, since the page was loaded
    this.last = Promise.resolve();
    this.url = "";
    this.onRetry = (_isGone) => {};
  }

  // What this participant sends goes there from now on.
  open(url, whose, onRetry) {
    Object.assign(this, { url, onRetry });
    if (this.whose === whose) return;
    this.whose = whose;
    this.left = this.unsent.filter((letter) => letter.whose === whose).map((one) => this.post(one));
  }

  // Resolves when the app has kept it; rejects when it never will.
  add(place, kind, content) {
    const letter = { place, kind, content, whose: this.whose };
    this.unsent.push(letter);
    this.store();
    return this.post(letter);
  }

  // Resolves when nothing is left from before; rejects when something of it is refused.
  async sendLeft() {
    await Promise.all(this.left);
    await this.last;
  }

  isAnswered(place) {
    return this.answered.has(`${this.whose} ${place}`);
  }

  post(letter) {
    const posted = this.last.then(() => this.put(letter));
    this.last = posted.catch(() => {}); // said to who waits for it
    return posted;
  }

  async put(letter) {
    const { whose, place, kind, content } = letter;
    const body = JSON.stringify({ ...content, whose });
    let nGone = 0;
    while (this.whose === whose) {
      const address = `${this.url}/${place}/${kind}`; // another one when the app has started anew
      const answer = await fetch(address, { method: "PUT", body, keepalive: true }).catch(() => null);
      if (answer && (answer.status < 300 || NEVER.includes(answer.status))) {
        this.unsent = this.unsent.filter((one) => one !== letter);
        this.store();
        if (answer.status >= 300) throw new Error(await answer.text());
        if (kind === "answer") this.answered.add(`${whose} ${place}`);
        return;
      }
      this.onRetry(answer?.status === 404 && nGone++ % DRAWN_AGAIN === 0);
      await new Promise((done) => setTimeout(done, AGAIN_MS));
    }
  }

  stored() {
    try {
      return JSON.parse(sessionStorage.getItem(STORED)) || [];
    } catch {
      return []; // the browser keeps nothing
    }
  }

  store() {
    try {
      sessionStorage.setItem(STORED, JSON.stringify(this.unsent));
    } catch {
      // as above: they are kept while the page is open
    }
  }
}

export const outbox = new Outbox();
