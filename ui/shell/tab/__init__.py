"""What the browser's tab does by itself: history, reload, dragged sliders, narrow windows."""
