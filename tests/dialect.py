# SPDX-License-Identifier: MIT
"""pymavlink generated from our own dialect: the wheel lacks messages that we send."""

import contextlib
import functools
import importlib.util
import io
import tempfile
from pathlib import Path
from shutil import copy
from types import ModuleType

import pymavlink
from pymavlink.generator import mavgen

OURS = Path(__file__).parents[1] / "firmware" / "link" / "mavlink" / "flotilla.xml"
WHEEL = Path(pymavlink.__file__).parent / "dialects" / "v20"
INCLUDED = ("common", "standard", "minimal")


@functools.cache
def dialect() -> ModuleType:
    """Our dialect as a module, generated once per session from the firmware's XML."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for xml in (OURS, *(WHEEL / f"{included}.xml" for included in INCLUDED)):
            copy(xml, folder)
        out = folder / "flotilla_dialect.py"
        options = mavgen.Opts(str(out), wire_protocol="2.0", language="Python3")
        with contextlib.redirect_stdout(io.StringIO()) as said:
            done = mavgen.mavgen(options, [str(folder / OURS.name)])
        assert done is not False and out.exists(), said.getvalue()
        spec = importlib.util.spec_from_file_location("flotilla_dialect", out)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        return module
