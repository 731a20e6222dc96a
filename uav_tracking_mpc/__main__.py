"""``python -m uav_tracking_mpc`` is the ``uav_tracking`` command."""

import sys

from uav_tracking_mpc.cli.main import main

sys.exit(main())
