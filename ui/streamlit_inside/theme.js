let ground = null;
let send = null;
export default function ({ setTriggerValue }) {
  send = setTriggerValue;
  if (ground !== null) return;
  const app = document.querySelector('[data-testid="stApp"]');
  if (!app) return;
  const seen = () => getComputedStyle(app).backgroundColor;
  ground = seen();
  new MutationObserver(() => {
    if (seen() === ground) return;
    ground = seen();
    send("ground", ground);
  }).observe(app, { attributes: true, attributeFilter: ["class"] });
}
