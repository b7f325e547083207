// Which part of the recording's picture the canvas shows.

const ZOOMS = [1, 1.5, 2, 3, 4, 6, 8, 12, 16]; // of the buttons and keys; the wheel stops anywhere
const LARGEST_ZOOM = ZOOMS[ZOOMS.length - 1];

class View {
  constructor() {
    this.fit();
  }

  // zoom 1 fits the picture into the canvas; (x, y) is the share of it that lies in the middle
  fit() {
    this.zoom = 1;
    this.x = 0.5;
    this.y = 0.5;
  }

  set(recording, width, height) {
    this.recording = recording;
    this.width = width;
    this.height = height;
    this.centreOn(this.x, this.y); // another size of the canvas has other bounds
  }

  // Scale at which the whole picture is seen.
  get fitScale() {
    return Math.min(this.width / this.recording.width, this.height / this.recording.height);
  }

  // Where the recording's pixels lie on the canvas, in CSS pixels.
  get place() {
    const { width, height } = this.recording;
    const size = { width: this.width, height: this.height };
    const scale = this.zoom * this.fitScale;
    const x = size.width / 2 - this.x * width * scale;
    const y = size.height / 2 - this.y * height * scale;
    return { scale, x, y, size };
  }

  // The part of the canvas that shows the picture.
  get seen() {
    const { scale, x, y, size } = this.place;
    const left = Math.max(0, x), top = Math.max(0, y);
    const right = Math.min(size.width, x + this.recording.width * scale);
    const bottom = Math.min(size.height, y + this.recording.height * scale);
    return { x: left, y: top, w: right - left, h: bottom - top };
  }

  // The picture fills the canvas as far as it is large enough: it cannot be moved out of sight.
  centreOn(x, y) {
    const { width, height } = this.recording;
    const scale = this.zoom * this.fitScale;
    const inside = (value, half) => Math.max(half, Math.min(1 - half, value));
    this.x = inside(x, Math.min(0.5, this.width / (2 * width * scale)));
    this.y = inside(y, Math.min(0.5, this.height / (2 * height * scale)));
  }

  // at: the point of the canvas that stays where it is; by default the middle
  zoomTo(wanted, at = null) {
    const { scale, x, y, size } = this.place;
    const point = at ?? { x: size.width / 2, y: size.height / 2 };
    const { width, height } = this.recording;
    const share = { x: (point.x - x) / (width * scale), y: (point.y - y) / (height * scale) };
    const zoom = Math.max(1, Math.min(LARGEST_ZOOM, wanted));
    const shrink = this.zoom / zoom;
    this.zoom = zoom;
    this.centreOn(share.x + (this.x - share.x) * shrink, share.y + (this.y - share.y) * shrink);
  }

  // The next larger (1) or smaller (-1) of the steps.
  nextZoom(direction) {
    if (direction > 0) return ZOOMS.find((zoom) => zoom > this.zoom * 1.001) ?? LARGEST_ZOOM;
    return ZOOMS.findLast((zoom) => zoom < this.zoom * 0.999) ?? 1;
  }

  moveBy(right, down) {
    const { scale } = this.place;
    const { width, height } = this.recording;
    this.centreOn(this.x - right / (width * scale), this.y - down / (height * scale));
  }
}
