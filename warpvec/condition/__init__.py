"""What has happened to a picture before it came to us: enlarged, blurred, noisy, saved as JPEG."""
