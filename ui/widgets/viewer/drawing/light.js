// Brightness and contrast of the picture as it is painted; the boxes keep their colours.

const MOST_LIGHT = 4; // times as bright, or a quarter

export class Light {
  constructor() {
    this.reset();
    this.isPossible = "filter" in CanvasRenderingContext2D.prototype;
  }

  reset() {
    this.brightness = 1;
    this.contrast = 1;
  }

  get isNeutral() {
    return this.brightness === 1 && this.contrast === 1;
  }

  // For the context that paints the picture; it stays there until `end`.
  begin(ctx) {
    if (!this.isNeutral) ctx.filter = `brightness(${this.brightness}) contrast(${this.contrast})`;
  }

  end(ctx) {
    if (!this.isNeutral) ctx.filter = "none";
  }
}

// The place of a slider, -1 to 1, and the factor that it stands for.
export function factorAt(place) {
  return MOST_LIGHT ** place;
}

export function placeOf(factor) {
  return Math.log(factor) / Math.log(MOST_LIGHT);
}

// place: where the recording's pixels lie on the canvas
export function drawPictures(viewer, ctx, pictures, { scale, x, y }) {
  ctx.imageSmoothingEnabled = scale < 4;
  viewer.light.begin(ctx);
  for (const { bitmap, area, alpha } of pictures) {
    ctx.globalAlpha = alpha;
    ctx.drawImage(bitmap, x + area.x * scale, y + area.y * scale, area.w * scale, area.h * scale);
  }
  ctx.globalAlpha = 1;
  viewer.light.end(ctx);
}
