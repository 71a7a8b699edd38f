# SPDX-License-Identifier: MIT
"""A boat on a microcontroller, emulated."""
