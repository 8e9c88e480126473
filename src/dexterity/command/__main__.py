"""``python -m dexterity.command``: the command where no script is installed.

Examples
--------
>>> import importlib.util
>>> importlib.util.find_spec("dexterity.command.__main__") is not None
True
"""

import sys

from dexterity.command import main

if __name__ == "__main__":
    sys.exit(main())
