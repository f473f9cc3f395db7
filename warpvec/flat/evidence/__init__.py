"""The pixels of a picture before anything is drawn: how uncertain they are, and what they cost as a photo."""
