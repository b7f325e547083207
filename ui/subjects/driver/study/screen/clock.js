// Time by the frames of the animation: the only clock that knows when something is to be seen.

const FRAME_MS = 1000 / 60;
const SMOOTHING = 0.1;

function nextFrame() {
  return new Promise((done) => requestAnimationFrame(done));
}

export class Clock {
  constructor() {
    this.frameMs = FRAME_MS;
    this.last = null;
  }

  async frame() {
    const now = await nextFrame();
    const took = this.last === null ? 0 : now - this.last;
    // one that came late, or after a pause, says nothing about the screen
    if (took > 0 && took < 1.5 * this.frameMs) this.frameMs += SMOOTHING * (took - this.frameMs);
    this.last = now;
    return now;
  }

  // Draws in the next frame; the time of the one after it, when what was drawn is on the screen.
  async show(draw) {
    await this.frame();
    draw();
    return this.frame();
  }

  // Waits until what is shown next (drawn a frame later, seen two later) will be on the screen at
  // this time, to the nearest frame.
  async until(time, isOver = () => false) {
    for (;;) {
      const now = await this.frame();
      if (isOver() || now + 2.5 * this.frameMs >= time) return;
    }
  }
}
