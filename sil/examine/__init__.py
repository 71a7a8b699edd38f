# SPDX-License-Identifier: MIT
"""Examines the firmware: ranges of its numbers, processors, flaky tests, generated pages."""
