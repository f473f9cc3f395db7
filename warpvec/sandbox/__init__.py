"""Work on hostile input in a child process with limits on time, memory, files and connections."""
