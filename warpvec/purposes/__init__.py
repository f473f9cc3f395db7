"""Write files for the programs that read them. What a program cannot show is drawn by other means."""
