"""The tools of `warpvec mcp`, by which programs such as assistants draw pictures of given folders."""
