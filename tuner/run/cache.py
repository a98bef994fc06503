"""JAX's persistent compilation cache, so that a second run need not compile again."""

import os

from tuner.cached import cache_folder, processor


def use_cache() -> bool:
    """Keep compiled code between runs; False where the folder cannot be written."""
    import jax

    import filters  # noqa: F401  # before JAX's configuration is touched

    folder = cache_folder() / processor()
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
