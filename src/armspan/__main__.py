"""``python -m armspan``."""

import sys

from armspan.cli import main

sys.exit(main())
