"""Read, measure and write images, and convert their colours and alpha."""
