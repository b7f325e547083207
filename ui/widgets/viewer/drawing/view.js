// Which part of the recording's picture the canvas shows.

const LARGEST_ZOOM = 16;

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
  }

  // Where the recording's pixels lie on the canvas, in CSS pixels.
  get place() {
    const { width, height } = this.recording;
    const size = { width: this.width, height: this.height };
    const scale = this.zoom * Math.min(size.width / width, size.height / height);
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

  centreOn(x, y) {
    const half = 0.5 / this.zoom;
    const inside = (value) => Math.max(half, Math.min(1 - half, value));
    this.x = inside(x);
    this.y = inside(y);
  }

  // at: the point of the canvas that stays where it is; by default the middle
  zoomBy(factor, at) {
    const { scale, x, y, size } = this.place;
    const point = at ?? { x: size.width / 2, y: size.height / 2 };
    const { width, height } = this.recording;
    const share = { x: (point.x - x) / (width * scale), y: (point.y - y) / (height * scale) };
    const zoom = Math.max(1, Math.min(LARGEST_ZOOM, this.zoom * factor));
    const shrink = this.zoom / zoom;
    this.zoom = zoom;
    this.centreOn(share.x + (this.x - share.x) * shrink, share.y + (this.y - share.y) * shrink);
  }

  moveBy(right, down) {
    const { scale } = this.place;
    const { width, height } = this.recording;
    this.centreOn(this.x - right / (width * scale), this.y - down / (height * scale));
  }
}
