// Where labels stand: inside the picture, off each other and off missed pedestrians. A label that
// finds no room is left out, unless it is that of a missed pedestrian.

export const LABEL_GROUND = "rgba(8, 11, 16, 0.72)";
export const LABEL_FONT = '600 12px "Source Sans", "Source Sans Pro", sans-serif';
export const LABEL_HEIGHT = 15;
export const LEAST_INSIDE = 40; // height of a box from which a label may stand in it
const FAR_LINES = 5;
const MOST_WIDTHS = 5000;
const labelWidths = new Map(); // measuring is slow

function overlapArea(a, b) {
  const across = Math.min(a.x + a.w, b.x + b.w) - Math.max(a.x, b.x);
  const down = Math.min(a.y + a.h, b.y + b.h) - Math.max(a.y, b.y);
  return across > 0 && down > 0 ? across * down : 0;
}

function grown(box, by) {
  return { x: box.x - by, y: box.y - by, w: box.w + 2 * by, h: box.h + 2 * by };
}

// Functions of a label's width that give its place at a box. share: 0 in line with the box's left
// edge, 1 with its right edge.
export const PLACE = {
  above: (box, share, gap) => (w) => [box.x + share * (box.w - w), box.y - gap - LABEL_HEIGHT],
  below: (box, share, gap) => (w) => [box.x + share * (box.w - w), box.y + box.h + gap],
  rightOf: (box, gap) => () => [box.x + box.w + gap, box.y],
  leftOf: (box, gap) => (w) => [box.x - gap - w, box.y],
  inside: (box, share) => (w) => [box.x + share * (box.w - w), box.y + 2],
};

export class Labels {
  // area: the part of the picture that is seen; missed: boxes that no label may cover
  constructor(ctx, area, missed) {
    this.ctx = ctx;
    this.area = area;
    this.taken = missed.map((box) => grown(box, 3));
    ctx.font = LABEL_FONT;
    ctx.textBaseline = "middle";
  }

  widthOf(text) {
    let width = labelWidths.get(text);
    if (width === undefined) {
      if (labelWidths.size >= MOST_WIDTHS) labelWidths.clear();
      width = this.ctx.measureText(text).width + 8;
      labelWidths.set(text, width);
    }
    return width;
  }

  rectAt([x, y], w, h = LABEL_HEIGHT) {
    const { area } = this;
    return {
      x: Math.max(area.x, Math.min(area.x + area.w - w, x)),
      y: Math.max(area.y, Math.min(area.y + area.h - h, y)),
      w, h,
    };
  }

  isFree(rect) {
    return this.taken.every((other) => overlapArea(rect, other) === 0);
  }

  // The place that hides least, where none is free.
  leastHiding(rects) {
    const hidden = rects.map((rect) => this.taken.reduce((sum, other) => sum + overlapArea(rect, other), 0));
    return rects[hidden.indexOf(Math.min(...hidden))];
  }

  // parts: [{text, colour, ground}]; left out (null) where no place is free
  put(parts, places) {
    const w = this.totalWidth(parts);
    const rect = places.map((place) => this.rectAt(place(w), w)).find((one) => this.isFree(one));
    if (!rect) return null;
    this.draw(parts, rect);
    return rect;
  }

  // The tag of a missed pedestrian, the first of its forms that finds a place; never left out.
  putTag(forms, box) {
    const near = [
      PLACE.above(box, 0.5, 6), PLACE.below(box, 0.5, 6), PLACE.above(box, 0, 6), PLACE.above(box, 1, 6),
      PLACE.below(box, 0, 6), PLACE.below(box, 1, 6), PLACE.rightOf(box, 6), PLACE.leftOf(box, 6),
    ];
    for (const parts of forms) {
      const rect = this.put(parts, near);
      if (rect) return rect;
    }
    const parts = forms[forms.length - 1];
    const far = [];
    for (let line = 1; line <= FAR_LINES; line += 1) {
      const gap = 6 + line * (LABEL_HEIGHT + 1);
      far.push(PLACE.above(box, 0.5, gap), PLACE.below(box, 0.5, gap));
    }
    const w = this.totalWidth(parts);
    const rects = far.map((place) => this.rectAt(place(w), w));
    const free = rects.find((rect) => this.isFree(rect));
    const rect = free ?? this.leastHiding([...near, ...far].map((place) => this.rectAt(place(w), w)));
    if (free) this.drawLeader(rect, box, parts[0].ground);
    this.draw(parts, rect);
    return rect;
  }

  // Room for a mark of this size at one of the places, free or not.
  reserve(places, w, h) {
    const rects = places.map((place) => this.rectAt(place, w, h));
    const rect = rects.find((one) => this.isFree(one)) ?? this.leastHiding(rects);
    this.taken.push(rect);
    return rect;
  }

  totalWidth(parts) {
    return parts.reduce((sum, part) => sum + this.widthOf(part.text), 0);
  }

  draw(parts, rect) {
    const { ctx } = this;
    this.taken.push(rect);
    let { x } = rect;
    for (const part of parts) {
      const width = this.widthOf(part.text);
      ctx.fillStyle = part.ground ?? LABEL_GROUND;
      ctx.fillRect(x, rect.y, width, rect.h);
      ctx.fillStyle = part.colour;
      ctx.fillText(part.text, x + 4, rect.y + rect.h / 2 + 0.5);
      x += width;
    }
  }

  // From a tag that stands apart to its box.
  drawLeader(rect, box, colour) {
    const { ctx } = this;
    const isAbove = rect.y < box.y;
    const centre = rect.x + rect.w / 2;
    ctx.beginPath();
    ctx.moveTo(centre, isAbove ? rect.y + rect.h : rect.y);
    ctx.lineTo(box.x + box.w / 2, isAbove ? box.y - 3 : box.y + box.h + 3);
    ctx.lineWidth = 1.5;
    ctx.strokeStyle = colour;
    ctx.stroke();
  }
}
