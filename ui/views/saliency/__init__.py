"""Parts of the Saliency page."""
