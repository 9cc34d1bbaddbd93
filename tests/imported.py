"""What a program imports, in a process of its own."""

import subprocess
import sys


def modules_after(code: str) -> set[str]:
    """Return the modules that are loaded after some code, with their parents."""
    program = f"import sys\n{code}\nprint(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    return set(done.stdout.split())
