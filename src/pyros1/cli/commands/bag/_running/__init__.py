"""Parts of ``bag record`` and ``bag play`` that work while these run."""
