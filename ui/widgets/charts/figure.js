// What is read from a figure as Plotly holds it.

export function headingOf(plot) {
  const [title = "Figure", subtitle = ""] = plot.layout.meta ?? [];
  return { title, subtitle };
}

export function asText(html) {
  const box = document.createElement("template");
  box.innerHTML = html.replace(/<br\s*\/?>/g, " ");
  return box.content.textContent;
}

export function axisKey(name, letter) {
  return `${letter}axis${(name ?? letter).slice(1)}`;
}
