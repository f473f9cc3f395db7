"""Host sides of the kernels of the splat renderer."""
