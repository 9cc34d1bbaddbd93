"""What tests read of the file of a report, and the browser in which they open it."""

import base64
import gzip
import json
import re
import shutil
import subprocess

BROWSER = (
    shutil.which("chromium")
    or shutil.which("chromium-browser")
    or shutil.which("google-chrome")
)
WATCH = """<script>
window.faults = [];
addEventListener("error", (e) => faults.push(String(e.message)));
addEventListener("unhandledrejection", (e) => faults.push(String(e.reason)));
console.error = (...text) => faults.push(text.join(" "));
</script>"""


def charts_of(text):
    packed = re.search(r'id="charts">([^<]*)<', text)[1]
    return json.loads(gzip.decompress(base64.b64decode(packed)))


def browse(*arguments):
    command = [
        BROWSER,
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        "--hide-scrollbars",
        "--virtual-time-budget=20000",
    ]
    return subprocess.run(
        [*command, *arguments], capture_output=True, text=True, timeout=120, check=True
    ).stdout
