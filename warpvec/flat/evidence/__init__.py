"""What is known of the pixels of a picture before anything is drawn: how uncertain they are, and what they hold."""
