# SPDX-License-Identifier: MIT
"""The bus `mcast` of python-can, by a name that is importable wherever Flotilla is installed."""

from sil.wire.mcast_bus import McastBus

__all__ = ["McastBus"]
