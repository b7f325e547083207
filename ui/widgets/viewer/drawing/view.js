// Which part of the recording's picture the canvas shows.

const ZOOMS = [1, 1.5, 2, 3, 4, 6, 8, 12, 16]; // of the buttons and keys; the wheel stops anywhere
export const LARGEST_ZOOM = ZOOMS[ZOOMS.length - 1];

export class View {
  constructor() {
    this.fit();
  }

  // zoom 1 fits the picture into the canvas; (x, y) is the share of it that lies in the middle
  fit() {
    this.zoom = 1;
    this.x = 0.5;
    this.y = 0.5;
  }

  // area: what is seen at most, in the recording's pixels
  set(area, width, height) {
    this.area = area;
    this.width = width;
    this.height = height;
    this.centreOn(this.x, this.y); // another size of the canvas has other bounds
  }

  // Scale at which the whole picture is seen.
  get fitScale() {
    return Math.min(this.width / this.area.w, this.height / this.area.h);
  }

  // Where the recording's pixels lie on the canvas, in CSS pixels.
  get place() {
    const { area } = this;
    const size = { width: this.width, height: this.height };
    const scale = this.zoom * this.fitScale;
    const x = size.width / 2 - (area.x + this.x * area.w) * scale;
    const y = size.height / 2 - (area.y + this.y * area.h) * scale;
    return { scale, x, y, size };
  }

  // The part of the canvas that shows the picture.
  get seen() {
    const { area } = this;
    const { scale, x, y, size } = this.place;
    const left = Math.max(0, x + area.x * scale), top = Math.max(0, y + area.y * scale);
    const right = Math.min(size.width, x + (area.x + area.w) * scale);
    const bottom = Math.min(size.height, y + (area.y + area.h) * scale);
    return { x: left, y: top, w: right - left, h: bottom - top };
  }

  // The picture fills the canvas as far as it is large enough: it cannot be moved out of sight.
  centreOn(x, y) {
    const { w: width, h: height } = this.area;
    const scale = this.zoom * this.fitScale;
    const inside = (value, half) => Math.max(half, Math.min(1 - half, value));
    this.x = inside(x, Math.min(0.5, this.width / (2 * width * scale)));
    this.y = inside(y, Math.min(0.5, this.height / (2 * height * scale)));
  }

  // The middle of a box of the recording comes into the middle, as far as may be.
  centreOnBox({ x, y, w, h }) {
    const { area } = this;
    this.centreOn((x + w / 2 - area.x) / area.w, (y + h / 2 - area.y) / area.h);
  }

  // at: the point of the canvas that stays where it is; by default the middle
  zoomTo(wanted, at = null) {
    const { scale, x, y, size } = this.place;
    const point = at ?? { x: size.width / 2, y: size.height / 2 };
    const { area } = this;
    const share = {
      x: ((point.x - x) / scale - area.x) / area.w, y: ((point.y - y) / scale - area.y) / area.h,
    };
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
    const { w: width, h: height } = this.area;
    this.centreOn(this.x - right / (width * scale), this.y - down / (height * scale));
  }
}
