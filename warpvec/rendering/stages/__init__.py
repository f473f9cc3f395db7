"""Host sides of the kernels' stages: each allocates its buffers and launches its kernels."""
