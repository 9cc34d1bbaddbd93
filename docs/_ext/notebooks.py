"""Notebooks with their results as pages of the manual, as they were saved; a test
runs them.
"""

from __future__ import annotations

import json
import re
from base64 import b64decode
from pathlib import Path


def titles(folder: Path) -> dict[str, str]:
    """Return the title of each notebook by its file name."""
    found = {}
    for file in sorted(folder.glob("*.ipynb")):
        first = "".join(
            json.loads(file.read_text(encoding="utf-8"))["cells"][0]["source"]
        )
        found[file.stem] = first.partition("\n")[0].lstrip("# ")
    return found


def write_page(file: Path, target: Path, figures: Path) -> None:
    """Write one notebook as Markdown; its pictures go to `figures`."""
    parts = []
    cells = json.loads(file.read_text(encoding="utf-8"))["cells"]
    for k, cell in enumerate(cells):
        source = "".join(cell["source"])
        if cell["cell_type"] == "markdown":
            parts.append(source)
            continue
        parts.append(f"```python\n{source}\n```")
        for n, output in enumerate(cell["outputs"]):
            data = output.get("data", {})
            if "image/png" in data:
                name = f"{file.stem}-{k}-{n}.png"
                (figures / name).write_bytes(b64decode(data["image/png"]))
                parts.append(f"![result of the cell](../figures/{name})")
            elif "text/html" in data:
                html = re.sub(
                    r"<style.*?</style>",
                    "",
                    "".join(data["text/html"]),
                    flags=re.DOTALL,
                )
                parts.append("```{raw} html\n" + html.strip() + "\n```")
            else:
                text = "".join(output.get("text", data.get("text/plain", "")))
                parts.append(f"```text\n{text.rstrip()}\n```")
    parts.append(f"Notebook: `docs/notebooks/{file.name}`.")
    target.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
