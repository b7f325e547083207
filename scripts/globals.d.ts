// What the scripts of the dashboard find in a page, for the type checker.

declare const Plotly: any;

// Once for each page, by the component that set it.
interface Window {
  nvcoreFigureMenu?: boolean;
  Plotly?: any;
  nvcoreHistory?: boolean;
  nvcoreLive?: { compare: () => unknown };
  nvcoreNarrow?: boolean;
}

interface Document {
  nvcoreTime?: number;
}

// A selector does not tell which kind of element it finds.
interface ParentNode {
  querySelector(selectors: string): any;
  querySelectorAll(selectors: string): NodeListOf<any>;
}

interface DocumentEventMap {
  "nvcore-similarity": CustomEvent;
}

interface KeyboardEvent {
  nvcore?: boolean; // pressed by `ui/shell/live/sliders.js`
}
