# SPDX-License-Identifier: MIT
"""The report of one run: figures, pictures, page."""
