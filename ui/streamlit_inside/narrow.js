const NARROW_PX = 1100;
const FOLD = '[data-testid="stSidebarCollapseButton"] button[aria-expanded="true"]';
const KEPT = "stSidebarCollapsed-"; // where Streamlit keeps it for all windows of the browser
const foldStates = () => {
  try { return Object.entries(localStorage).filter(([name]) => name.startsWith(KEPT)); }
  catch { return []; } // storage is not allowed
};
export default function () {
  if (window.nvcoreNarrow) return;
  window.nvcoreNarrow = true;
  if (window.innerWidth >= NARROW_PX) return;
  const before = foldStates();
  document.querySelector(FOLD)?.click();
  foldStates().forEach(([name]) => localStorage.removeItem(name));
  before.forEach((entry) => localStorage.setItem(...entry));
}
