# SPDX-License-Identifier: MIT
"""A fleet on a web page: what is heard on MAVLink, or what was recorded."""
