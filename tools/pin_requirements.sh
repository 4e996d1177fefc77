#!/usr/bin/env bash
# Write requirements/*.txt anew from requirements/*.in: one set of pins for Python 3.11 to 3.13.
#
# Usage: tools/pin_requirements.sh [--upgrade | --upgrade-package NAME ...]
# Needs uv on the PATH. Resolving for the oldest interpreter gives pins that all of them accept.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../requirements"
export UV_CUSTOM_COMPILE_COMMAND="tools/pin_requirements.sh"

pin() {
    uv pip compile --quiet --python-version 3.11 --python-platform x86_64-unknown-linux-gnu \
        --no-annotate --no-emit-index-url --no-emit-find-links "$@"
}

# The build asks for an old setuptools; what runs must be content with the same one.
pin runtime.in --constraint build.in --output-file runtime.txt "$@"
pin build.in --constraint runtime.txt --output-file build.txt "$@"
pin dev.in --constraint runtime.txt --constraint build.txt --output-file dev.txt "$@"
