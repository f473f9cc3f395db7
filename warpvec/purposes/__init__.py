"""What a file is for: the programs and machines that read it, what they cannot show, and what is drawn in its place."""
