// Where the page is scrolled past the picture, the whole viewer stands small below the page's
// navigation: a click in a plot further down moves a picture that is in sight.

const DOCK_GAP_PX = 4;

export class Dock {
  constructor(viewer) {
    this.viewer = viewer;
    this.isClosed = false; // until the picture has been in sight again
    this.request = 0;
    this.check = () => {
      if (this.request === 0) this.request = requestAnimationFrame(() => this.place());
    };
    document.addEventListener("scroll", this.check, { capture: true, passive: true });
    window.addEventListener("resize", this.check);
  }

  get isDocked() {
    return this.viewer.root.classList.contains("docked");
  }

  // The page around the component, which stands in a shadow root.
  around(selector) {
    return this.viewer.holder.getRootNode().host?.closest(selector) ?? null;
  }

  place() {
    this.request = 0;
    const { holder, root } = this.viewer;
    if (!holder.isConnected || root.getRootNode().fullscreenElement === root) return;
    const { top } = holder.getBoundingClientRect();
    const ceiling = bottomOfNavigation();
    if (!this.isDocked) this.middle = middleOfPicture(this.viewer);
    const isPast = holder.offsetHeight > 0 && top + this.middle < ceiling;
    if (!isPast) this.isClosed = false;
    if (isPast && !this.isClosed) this.dock(ceiling);
    else this.undock();
  }

  dock(ceiling) {
    const { holder, root } = this.viewer;
    if (!this.isDocked) {
      holder.style.height = `${holder.offsetHeight}px`; // the page stays as long as it was
      root.classList.add("docked");
      root.dataset.docked = "true";
    }
    const page = (this.around('[data-testid="stMainBlockContainer"]') ?? holder);
    const { left, width } = page.getBoundingClientRect();
    const look = getComputedStyle(page);
    const [before, after] = [parseFloat(look.paddingLeft) || 0, parseFloat(look.paddingRight) || 0];
    root.style.top = `${ceiling + DOCK_GAP_PX}px`;
    root.style.left = `${left + before}px`;
    root.style.width = `${width - before - after}px`;
    // what gets the focus, or is asked into sight, does not stop behind the viewer
    const scroller = this.around('[data-testid="stMain"]');
    if (scroller) scroller.style.scrollPaddingTop = `${root.getBoundingClientRect().bottom + DOCK_GAP_PX}px`;
  }

  undock() {
    const { holder, root } = this.viewer;
    if (!this.isDocked) return;
    root.classList.remove("docked");
    root.dataset.docked = "false";
    for (const name of ["top", "left", "width"]) root.style[name] = "";
    holder.style.height = "";
    this.around('[data-testid="stMain"]')?.style.removeProperty("scroll-padding-top");
  }

  close() {
    this.isClosed = true;
    this.place();
  }

  // Back to the large picture.
  open() {
    this.undock(); // else the page would stop short of it, for the small viewer's room
    this.viewer.holder.scrollIntoView({ block: "start" });
    this.viewer.root.focus({ preventScroll: true });
  }

  destroy() {
    this.undock();
    cancelAnimationFrame(this.request);
    document.removeEventListener("scroll", this.check, { capture: true });
    window.removeEventListener("resize", this.check);
  }
}

// The navigation stays at the top of the window where the window is wide enough.
function bottomOfNavigation() {
  const bars = document.querySelectorAll('.st-key-navigation, [data-testid="stHeader"]');
  return Math.max(0, ...[...bars].map((bar) => bar.getBoundingClientRect().bottom));
}

function middleOfPicture({ holder, parts }) {
  const { top, height } = parts.stage.getBoundingClientRect();
  return top + height / 2 - holder.getBoundingClientRect().top;
}
