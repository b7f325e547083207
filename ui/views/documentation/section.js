// A browser scrolls to the section in the address once, when its heading appears; on a slow machine
// more appears above it later. So the heading is kept in sight until the reader does something.

const PATIENCE_MS = 10000;
let done = null;
export default function () {
  const name = decodeURIComponent(location.hash.slice(1));
  if (!name || done === location.href) return;
  done = location.href;
  const until = Date.now() + PATIENCE_MS;
  const timer = setInterval(look, 100);
  const acts = ["wheel", "keydown", "pointerdown", "touchstart"];
  const stop = () => {
    clearInterval(timer);
    acts.forEach((act) => removeEventListener(act, stop, true));
  };
  acts.forEach((act) => addEventListener(act, stop, true));
  function look() {
    const heading = document.getElementById(name);
    const top = heading?.getBoundingClientRect().top;
    if (heading && (top < 0 || top > innerHeight / 2)) heading.scrollIntoView();
    if (Date.now() > until || location.href !== done) stop();
  }
}
