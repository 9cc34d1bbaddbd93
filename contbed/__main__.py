"""`python -m contbed` is `contbed`."""

import sys

from contbed.cli import main

sys.exit(main())
