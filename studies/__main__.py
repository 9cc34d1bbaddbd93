"""python -m studies [list | run | draw | check | readme] ..."""

import sys

from studies._gallery.command import main

sys.exit(main(sys.argv[1:]))
