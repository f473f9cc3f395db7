"""Make a drawing without overlaps, for cutting and plotting."""
