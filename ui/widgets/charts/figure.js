// Parts of a figure as Plotly holds it, and parts laid over it.

export function headingOf(plot) {
  const [title = "Figure", subtitle = ""] = plot.layout.meta ?? [];
  return { title, subtitle };
}

export function asText(html) {
  const box = document.createElement("template");
  box.innerHTML = html.replace(/<br\s*\/?>/g, " ");
  return box.content.textContent;
}

// An element of the plot or page with that class, made when it is first needed.
export function partOf(parent, className) {
  let part = parent.querySelector(`.${className}`);
  if (!part) {
    part = document.createElement("div");
    part.className = className;
    parent.append(part);
  }
  return part;
}

export function axisKey(name, letter) {
  return `${letter}axis${(name ?? letter).slice(1)}`;
}
