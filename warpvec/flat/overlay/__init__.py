"""Words that lie over several grounds, and the picture without them."""
