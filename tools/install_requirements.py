"""Install pinned requirement files into the environment this Python belongs to.

uv does in seconds what takes pip minutes, but it reads none of pip's settings, and a lab's
index, proxy or certificates are set there. So pip fetches uv, pip's settings are handed on to
it, and where uv fails all the same (a keyring, a client certificate) pip does the work itself.

Usage: python install_requirements.py FILE...
"""

import ast
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

PIP = (sys.executable, "-m", "pip")

# Sections in the order in which pip lets one override another.
PIP_SECTIONS = ("global", "install", ":env:")


def pip_settings(listing: str) -> dict[str, str]:
    """Read the output of ``pip config list``: one ``section.key='value'`` a line."""
    sections: dict[str, dict[str, str]] = {name: {} for name in PIP_SECTIONS}
    for line in listing.splitlines():
        name, _, value = line.partition("=")
        section, _, key = name.rpartition(".")
        if section in sections and value:
            sections[section][key] = str(ast.literal_eval(value))
    merged: dict[str, str] = {}
    for section in PIP_SECTIONS:
        merged.update(sections[section])
    return merged


def uv_environment(pip: Mapping[str, str], environment: Mapping[str, str]) -> dict[str, str]:
    """Return the environment in which uv does as pip would; what is set for uv stays."""
    uv = {
        # pip takes the best version that any index has, and trusts the system's certificates.
        "UV_INDEX_STRATEGY": "unsafe-best-match",
        "UV_SYSTEM_CERTS": "1",
        "UV_NO_PROGRESS": "1",
        "UV_NO_CONFIG": "1",
    }
    for key, name, separator in (
        ("index-url", "UV_DEFAULT_INDEX", " "),
        ("extra-index-url", "UV_INDEX", " "),
        ("find-links", "UV_FIND_LINKS", ","),
        ("trusted-host", "UV_INSECURE_HOST", " "),
        ("no-index", "UV_NO_INDEX", " "),
        ("default-timeout", "UV_HTTP_TIMEOUT", " "),
        ("timeout", "UV_HTTP_TIMEOUT", " "),
        ("cert", "SSL_CERT_FILE", " "),
        ("proxy", "ALL_PROXY", " "),
    ):
        if key in pip:
            uv[name] = separator.join(pip[key].split())
    return {**uv, **environment}


def main(files: list[str]) -> int:
    """Install the files' pins, all at once and nothing but them."""
    pins = [argument for file in files for argument in ("--requirement", file)]
    constraints = [argument for file in files for argument in ("--constraint", file)]
    environment = {
        **os.environ,
        "PIP_USER": "0",  # there is no user site in a venv
        "PIP_DISABLE_PIP_VERSION_CHECK": "1",
        "PIP_PROGRESS_BAR": "off",
    }
    got_uv = subprocess.run([*PIP, "install", "--no-deps", *constraints, "uv"], env=environment)
    if got_uv.returncode == 0:
        listing = subprocess.run(
            [*PIP, "config", "list"], env=environment, capture_output=True, text=True, check=True
        ).stdout
        uv = Path(sys.executable).with_name("uv")
        done = subprocess.run(
            [str(uv), "pip", "install", "--python", sys.executable, "--no-deps", *pins],
            env=uv_environment(pip_settings(listing), environment),
        )
        if done.returncode == 0:
            return 0
    print("uv could not install the requirements; pip does it, which takes longer", flush=True)
    return subprocess.run(
        [*PIP, "install", "--no-deps", "--no-compile", *pins], env=environment
    ).returncode


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
