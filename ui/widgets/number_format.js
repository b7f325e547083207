// Numbers as the server writes them.

const UNDEFINED = "–";

function grouped(text) {
  const [whole, ...rest] = text.split(".");
  return [whole.replace(/\B(?=(\d{3})+$)/g, ","), ...rest].join(".");
}

// As Python's format of ".3f", "+.2f", ".1%", "d", ".4g" and the like, with commas between thousands
// and a minus sign that is as wide as a plus; what is rounded to zero has no sign.
function formatted(value, form) {
  if (value === null || Number.isNaN(value)) return UNDEFINED;
  const decimals = Number(/\.(\d+)|$/.exec(form)[1] ?? 0);
  const size = Math.abs(value) * (form.endsWith("%") ? 100 : 1);
  const digits = form.endsWith("g") ? String(Number(size.toPrecision(decimals))) : grouped(size.toFixed(decimals));
  const sign = !/[1-9]/.test(digits) ? "" : value < 0 ? "−" : form.startsWith("+") ? "+" : "";
  return sign + digits + (form.endsWith("%") ? "%" : "");
}
