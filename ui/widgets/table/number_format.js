// Numbers as the server writes them.

export const UNDEFINED = "–";
const MORE_DECIMALS = 3; // of a difference, as in nvcore.common.wording

function grouped(text) {
  const [whole, ...rest] = text.split(".");
  return [whole.replace(/\B(?=(\d{3})+$)/g, ","), ...rest].join(".");
}

// A half is rounded to the even digit, as Python does; only such numbers are exact in binary.
function rounded(size, decimals) {
  const scaled = size * 10 ** decimals;
  const isHalf = (size * 2 ** (decimals + 1)) % 1 === 0 && scaled % 1 === 0.5;
  return (isHalf ? (2 * Math.round(scaled / 2)) / 10 ** decimals : size).toFixed(decimals);
}

// As Python's format of ".3f", "+.2f", ".1%", "d" and the like, with commas between thousands and a
// minus sign that is as wide as a plus, and a space before %; what is rounded to zero has no sign. ".4g" has no exponents.
export function formatted(value, form) {
  if (value === null || Number.isNaN(value)) return UNDEFINED;
  const decimals = Number(/\.(\d+)|$/.exec(form)[1] ?? 0);
  const size = Math.abs(value) * (form.endsWith("%") ? 100 : 1);
  if (size === Infinity) return value > 0 ? "∞" : "−∞";
  const digits = form.endsWith("g") ? String(Number(size.toPrecision(decimals))) : grouped(rounded(size, decimals));
  const sign = !/[1-9]/.test(digits) ? "" : value < 0 ? "−" : form.startsWith("+") ? "+" : "";
  return sign + digits + (form.endsWith("%") ? " %" : "");
}

// X - Y as nvcore.common.wording.difference writes it, with a wide minus sign.
export function difference(x, y, form) {
  if (Number.isNaN(x) || Number.isNaN(y)) return UNDEFINED;
  const isShare = form.endsWith("%");
  const apart = (x - y) * (isShare ? 100 : 1);
  const most = formatted(x, form) === formatted(y, form) ? 0 : MORE_DECIMALS;
  let of = form.replace("%", "f");
  let text = formatted(Math.abs(apart), of);
  for (let more = 0; more < most && !/[1-9]/.test(text); more += 1) {
    of = `.${Number(of.slice(1, -1)) + 1}f`;
    text = formatted(Math.abs(apart), of);
  }
  const sign = !/[1-9]/.test(text) ? "" : apart < 0 ? "−" : "+";
  return sign + text + (isShare ? " pp" : "");
}
