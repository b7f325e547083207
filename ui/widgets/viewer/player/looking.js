// Which of a recording's two pictures are seen, as it is chosen: above them or by a key.

/** @import { Viewer } from "./viewer.js" */
import { showSources } from "../controls/sources.js";
import { Player, SETTLE_MS } from "./player.js";

export class Looking extends Player {
  /** @this {Viewer} */
  showLook() {
    showSources(this.parts.sources, this.look);
    this.setHeight();
  }

  /** @this {Viewer} */
  changeLook(changes) {
    const { sinceS, isAdapting, isByHand, changeAt } = this.look;
    Object.assign(this.look, changes);
    const isSeenOtherwise = this.look.sinceS !== sinceS || this.look.isAdapting !== isAdapting
      || this.look.isByHand !== isByHand || this.look.changeAt !== changeAt;
    if (isSeenOtherwise) this.resetVisible();
    this.showLook();
    this.showView();
    this.load();
    clearTimeout(this.lookTimer);
    this.lookTimer = setTimeout(() => this.tellLook(), SETTLE_MS);
  }

  /** @this {Viewer} */
  tellLook() {
    const { choice } = this.look;
    const text = JSON.stringify(choice);
    if (text === this.toldLook) return;
    this.toldLook = text;
    this.reportLook?.(choice);
  }

  /** @this {Viewer} */
  nextLook() {
    if (!this.look.visible) return;
    this.look.next();
    this.changeLook({});
  }

  /** @this {Viewer} */
  toggleAdapting() {
    if (!this.look.visible) return;
    const picture = this.look.needsVisible ? this.look.picture : "visible";
    this.changeLook({ picture, isAdapting: !this.look.isAdapting });
  }

  // The recording's own times, or those of the slider.
  /** @this {Viewer} */
  toggleByHand() {
    this.changeLook({ isByHand: !this.look.isByHand });
  }

  // Simulate that it becomes dark at this row, or no longer.
  /** @this {Viewer} */
  toggleTunnel() {
    const isOver = this.look.changeAt !== null;
    this.changeLook({ changeAt: isOver ? null : this.recording.times[this.row] });
  }

  /** @this {Viewer} */
  resetVisible() {
    const { look, recording } = this;
    this.visible.reset((row) => {
      const query = new URLSearchParams({ v: this.sent.picture_version });
      const seconds = look.seenAt(row, recording.endOf(row));
      if (seconds !== null) query.set("seen_s", seconds.toFixed(1));
      return `${this.addressOfVisible}/${row}.jpg?${query}`;
    });
  }
}
