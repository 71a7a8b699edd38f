# SPDX-License-Identifier: MIT
"""A fleet seen on a page: what boats say on a MAVLink network, or what a run or a log recorded.

It listens only. `python -m sil.view --help`; the page itself is `page`.
"""
