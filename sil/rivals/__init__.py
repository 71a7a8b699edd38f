# SPDX-License-Identifier: MIT
"""Compares Flotilla with other ways to sail a plan, under equal conditions.

Hull, sensors, propellers and weather are the same for all.
"""
