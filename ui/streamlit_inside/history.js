const PLACES = ["recording", "encounter", "doc"];
const ALWAYS = "recording"; // of every address that is written
const LEAVING_MS = 3000;
const MAY_END = ["encounter"]; // none is open: no place of its own
// start: the page that is open without a name, too
export default function ({ data: { start } }) {
  if (window.nvcoreHistory) return;
  window.nvcoreHistory = true;
  const ofStart = new RegExp(`/${start}$`);
  const push = window.history.pushState.bind(window.history);
  const replace = window.history.replaceState.bind(window.history);
  let leaving = null;
  /** @type {Parameters<History["replaceState"]> | null} */
  let last = null;
  const stays = () => {
    leaving = null;
    if (last) replace(...last);
  };
  window.history.pushState = (state, title, url) => {
    const here = new URL(window.location.href);
    const next = new URL(url ?? here, here);
    const isSamePage = next.pathname.replace(ofStart, "/") === here.pathname.replace(ofStart, "/");
    // a page that a button leaves is emptied first, and written for the next page: it keeps its
    // address to come back to
    if (isSamePage && here.searchParams.has(ALWAYS) && next.search === "") {
      clearTimeout(leaving);
      leaving = setTimeout(stays, LEAVING_MS);
      last = null;
      return;
    }
    if (isSamePage && leaving !== null) {
      last = [state, title, url];
      return;
    }
    clearTimeout(leaving);
    leaving = null;
    const isSame = isSamePage && PLACES.every((name) => {
      const before = here.searchParams.get(name);
      // an address that names no place yet is completed, which is no step
      const after = next.searchParams.get(name);
      return before === null || before === after || (after === null && MAY_END.includes(name));
    });
    if (isSame) replace(state, title, url);
    else push(state, title, url);
  };
}
