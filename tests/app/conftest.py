"""The tests of the page's server are left out where the packages of the extra "app" are missing."""

from importlib.util import find_spec

collect_ignore_glob = [] if all(map(find_spec, ("starlette", "uvicorn", "httpx"))) else ["test_*.py"]
