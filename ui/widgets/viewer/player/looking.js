// Which of a recording's two pictures are seen, as it is chosen: above them or by a key.

class Looking extends Player {
  showLook() {
    showSources(this.parts.sources, this.look);
    this.setHeight();
  }

  changeLook(changes) {
    const { sinceS, isDriver } = this.look;
    Object.assign(this.look, changes);
    if (this.look.sinceS !== sinceS || this.look.isDriver !== isDriver) this.resetVisible();
    this.showLook();
    this.showView();
    this.load();
    clearTimeout(this.lookTimer);
    this.lookTimer = setTimeout(() => this.reportLook?.(this.look.choice), SETTLE_MS);
  }

  nextLook() {
    if (!this.look.visible) return;
    this.look.next();
    this.changeLook({});
  }

  toggleDriver() {
    if (!this.look.visible) return;
    const picture = this.look.needsVisible ? this.look.picture : "visible";
    this.changeLook({ picture, isDriver: !this.look.isDriver });
  }

  resetVisible() {
    const query = new URLSearchParams({ v: this.sent.picture_version });
    if (this.look.isDriver) query.set("seen_s", this.look.sinceS.toFixed(1));
    this.visible.reset((row) => `${this.addressOfVisible}/${row}.jpg?${query}`);
  }
}
