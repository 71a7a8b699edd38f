# SPDX-License-Identifier: MIT
"""Shows a fleet on a web page: live from MAVLink, or recorded."""
