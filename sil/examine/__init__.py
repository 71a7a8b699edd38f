# SPDX-License-Identifier: MIT
"""Examines the firmware: number ranges, microcontroller, flaky tests, generated pages."""
