const NAME = "nvcore-workspace";
let pauseMs = 1000; // doubled each time
let again = null;
let send = null;
export default function ({ data, setTriggerValue }) {
  let kept = null;
  try { kept = sessionStorage.getItem(NAME); } catch { return; }
  send = setTriggerValue;
  const claim = () => {
    again = setTimeout(claim, pauseMs);
    pauseMs *= 2;
    send("claim", kept);
  };
  if (kept && kept !== data.token && !data.is_settled) {
    if (again === null) claim();
    return;
  }
  clearTimeout(again);
  sessionStorage.setItem(NAME, data.token);
}
