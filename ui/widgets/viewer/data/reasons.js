// What nvcore says of the boxes of a row: who it is, what it counts and costs, and why.

export class Reasons {
  constructor() {
    this.rows = new Map(); // row -> promise of [{title, lines, encounter, truth}], in the boxes' order
  }

  // Every answer holds for the settings with which it was given.
  reset(address) {
    this.address = address;
    this.rows.clear();
  }

  // null where the server does not say
  ofRow(row) {
    if (!this.rows.has(row)) this.rows.set(row, this.fetchRow(row));
    return this.rows.get(row);
  }

  async fetchRow(row) {
    try {
      const answer = await fetch(`${this.address}/${row}`, { credentials: "same-origin", cache: "no-store" });
      const isJson = (answer.headers.get("content-type") ?? "").startsWith("application/json");
      if (answer.ok && isJson) return await answer.json();
    } catch {
      // the server is away: asked again the next time
    }
    this.rows.delete(row);
    return null;
  }
}
