"""JAX's persistent compilation cache, so that a second run need not compile again."""

import contextlib
import hashlib
import os
import platform
from pathlib import Path

from tuner.cached import cache_folder


def use_cache() -> bool:
    """Keep compiled code between runs; False where the folder cannot be written."""
    import jax

    import filters  # noqa: F401  # before JAX's configuration is touched

    folder = cache_folder() / _processor()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    if not os.access(folder, os.W_OK):
        return False
    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    return True


def _processor() -> str:
    """The processor that compiled code is for: JAX keys code by program and version alone.

    Home folders are shared by machines, and code for one may end a process on another.
    """
    can = platform.processor()
    with contextlib.suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
        can += next((line for line in lines if line.startswith(("flags", "Features"))), "")
    return f"{platform.machine()}-{hashlib.sha256(can.encode()).hexdigest()[:12]}"
