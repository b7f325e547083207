// What is on the canvas. Pictures keep their shape, as large as the canvas allows.

export const BRIGHT = "#ffffff";
export const DARK = "#000000";
const CROSS = { [BRIGHT]: "#000000", [DARK]: "#707070" };
const CROSS_PX = 24;
const DIMMED = 0.5;

export class Drawing {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
  }

  fit() {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth, clientHeight } = this.canvas;
    this.ratio = ratio;
    this.canvas.width = Math.max(1, Math.round(clientWidth * ratio));
    this.canvas.height = Math.max(1, Math.round(clientHeight * ratio));
  }

  // Where a picture of this size is on the canvas, in pixels of the canvas.
  place(width, height) {
    const scale = Math.min(this.canvas.width / width, this.canvas.height / height);
    const left = (this.canvas.width - width * scale) / 2;
    const top = (this.canvas.height - height * scale) / 2;
    return { scale, left, top, width: width * scale, height: height * scale };
  }

  ground(colour) {
    this.context.fillStyle = colour;
    this.context.fillRect(0, 0, this.canvas.width, this.canvas.height);
  }

  cross(colour) {
    this.ground(colour);
    const { width, height } = this.canvas;
    this.lines(width / 2, height / 2, CROSS_PX * this.ratio, CROSS[colour], 3);
  }

  lines(x, y, arm, colour, thickness) {
    const pen = this.context;
    pen.strokeStyle = colour;
    pen.lineWidth = thickness * this.ratio;
    pen.beginPath();
    pen.moveTo(x - arm, y);
    pen.lineTo(x + arm, y);
    pen.moveTo(x, y - arm);
    pen.lineTo(x, y + arm);
    pen.stroke();
  }

  // Makes what is shown of these pictures at the size of the canvas: then to show it is to copy it.
  prepare(trials) {
    for (const trial of trials) {
      trial.screens = {
        preview: this.screen(trial.coarse, trial, BRIGHT, 1),
        picture: this.screen(trial.full, trial, DARK, 1),
        answer: this.screen(trial.coarse, trial, DARK, DIMMED),
      };
      for (const screen of Object.values(trial.screens)) this.whole(screen);
    }
    this.context.getImageData(0, 0, 1, 1); // what takes longer the first time has been done
    this.ground(BRIGHT);
  }

  screen(image, trial, ground, alpha) {
    const canvas = document.createElement("canvas");
    canvas.width = this.canvas.width;
    canvas.height = this.canvas.height;
    const pen = canvas.getContext("2d");
    pen.fillStyle = ground;
    pen.fillRect(0, 0, canvas.width, canvas.height);
    const at = this.place(trial.width, trial.height);
    pen.globalAlpha = alpha;
    pen.imageSmoothingQuality = "high";
    pen.drawImage(image, at.left, at.top, at.width, at.height);
    return canvas;
  }

  whole(screen) {
    this.context.drawImage(screen, 0, 0, this.canvas.width, this.canvas.height);
  }

  // The coarse picture to touch, and the place that the arrow keys have reached.
  answer(trial, pointer) {
    this.whole(trial.screens.answer);
    if (!pointer) return;
    const at = this.place(trial.width, trial.height);
    const [x, y] = [at.left + pointer.x * at.scale, at.top + pointer.y * at.scale];
    this.lines(x, y, CROSS_PX * this.ratio, "#000000", 6);
    this.lines(x, y, CROSS_PX * this.ratio, "#ffd400", 2);
  }

  // Pixel of the picture at a place of the window; null: beside the picture.
  pixelAt(event, trial) {
    const area = this.canvas.getBoundingClientRect();
    const at = this.place(trial.width, trial.height);
    // the window may have been resized since `fit`
    const [across, down] = [this.canvas.width / area.width, this.canvas.height / area.height];
    const x = ((event.clientX - area.left) * across - at.left) / at.scale;
    const y = ((event.clientY - area.top) * down - at.top) / at.scale;
    const isInside = x >= 0 && y >= 0 && x < trial.width && y < trial.height;
    return isInside ? { x, y } : null;
  }

  shownWidth(trial) {
    return Math.max(1, Math.round(this.place(trial.width, trial.height).width / this.ratio));
  }
}
