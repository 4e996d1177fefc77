# Sets up what the workspace needs. Sourced by ./bha, which gives ROOT, VENV, WORKSPACE, LOG,
# ENVIRONMENT, say and die; `setup` is what it calls.
#
# There are two parts, each with a stamp that says what it was made from:
#   .venv               Python packages, ROS 2 among them (requirements/*.txt)
#   ros2_ws/install     the workspace's packages, built by colcon (linked to src/)
# A part whose stamp does not fit is brought up to date, and one that was cut off while it was
# made, or that was moved, is made from nothing. When both fit, nothing is locked or written.
# shellcheck shell=bash

PYTHON_VERSIONS="3.11 to 3.13"

# --- what the system must bring ------------------------------------------------------------

# Print "MAJOR.MINOR" of an interpreter that the wheels exist for; fail for any other.
usable_version() {
    "$1" -c 'import sys, sysconfig
sys.exit(1) if sys.implementation.name != "cpython" or sysconfig.get_config_var("Py_GIL_DISABLED") \
    or not (3, 11) <= sys.version_info[:2] <= (3, 13) else print("%d.%d" % sys.version_info[:2])' \
        2>/dev/null
}

choose_python() {
    local candidate
    if [[ -n "${BHA_PYTHON:-}" ]]; then
        usable_version "$BHA_PYTHON" >/dev/null ||
            die "BHA_PYTHON=$BHA_PYTHON is no CPython $PYTHON_VERSIONS."
        PYTHON="$BHA_PYTHON"
        return
    fi
    for candidate in python3 python3.12 python3.13 python3.11; do
        if usable_version "$candidate" >/dev/null; then
            PYTHON="$candidate"
            return
        fi
    done
    die "needs CPython $PYTHON_VERSIONS; python3 here is $(python3 --version 2>/dev/null ||
        echo 'not installed')." "Install one, or name one: BHA_PYTHON=/path/to/python3.12 ./bha setup"
}

# Print the Debian packages for what is missing.
missing_packages() {
    local version
    version="$(usable_version "$PYTHON")"
    "$PYTHON" -c 'import ensurepip, venv' 2>/dev/null || echo "python$version-venv"
    "$PYTHON" -c 'import os, sys, sysconfig
sys.exit(not os.path.exists(os.path.join(sysconfig.get_path("include"), "Python.h")))' ||
        echo "python$version-dev"
    { command -v cc || command -v gcc; } >/dev/null && { command -v c++ || command -v g++; } \
        >/dev/null || echo "g++"
}

install_packages() {
    local get=(env DEBIAN_FRONTEND=noninteractive apt-get -y -o DPkg::Lock::Timeout=120)
    ((EUID == 0)) || get=(sudo -n "${get[@]}")
    "${get[@]}" update && "${get[@]}" install --no-install-recommends "$@"
}

provide_system() {
    [[ "$(uname -sm)" == "Linux x86_64" ]] ||
        die "ROS 2 comes as wheels for Linux on x86-64 alone; this is $(uname -sm)." \
            "On other machines build against a native ROS 2 Jazzy, as CONTRIBUTING.md says."
    [[ "$ROOT" != *[[:space:]:]* ]] ||
        die "the checkout's path holds a space or a colon, which ROS's tools cannot take:" "$ROOT"
    choose_python
    local packages
    mapfile -t packages < <(missing_packages)
    ((${#packages[@]})) || return 0
    if command -v apt-get >/dev/null && { ((EUID == 0)) || sudo -n true 2>/dev/null; }; then
        phase "system packages: ${packages[*]}" install_packages "${packages[@]}"
    else
        die "the system lacks ${packages[*]}. Install with:" \
            "sudo apt-get update && sudo apt-get install -y ${packages[*]}" "then call me again."
    fi
}

# --- the Python environment ----------------------------------------------------------------

digest() { LC_ALL=C sha256sum | cut -d ' ' -f 1; }

# What .venv is made from: its place, its interpreter, the pins.
venv_key() {
    { echo "$ROOT" && readlink -f "$VENV/bin/python" && cat "$ROOT"/requirements/*.txt \
        "$ROOT"/tools/{install_requirements,relocate_ros_wheels}.py; } 2>/dev/null | digest
}

# The part of it that what colcon builds depends on.
toolchain_key() {
    { echo "$ROOT" && readlink -f "$VENV/bin/python" && grep -h '^ros-' "$ROOT"/requirements/*.txt &&
        cat "$ROOT/requirements/build.txt"; } 2>/dev/null | digest
}

venv_place() { echo "$ROOT $(readlink -f "$VENV/bin/python")"; }

make_venv() {
    [[ -f "$VENV/.stamp" && -x "$VENV/bin/python" && "$(cat "$VENV/.place")" == "$(venv_place)" ]] ||
        { rm -rf "$VENV" && "$PYTHON" -m venv "$VENV" && venv_place >"$VENV/.place"; }
}

install_requirements() {
    rm -f "$VENV/.stamp" &&
        "$VENV/bin/python" "$ROOT/tools/install_requirements.py" "$ROOT"/requirements/*.txt &&
        "$VENV/bin/python" "$ROOT/tools/relocate_ros_wheels.py"
}

# --- the colcon workspace ------------------------------------------------------------------

# What the build of some folders depends on: the tools, the files it reads, and the names of the
# data files it links. Python modules are linked as a folder, so they are not part of it.
build_key() {
    {
        toolchain_key
        cd "$ROOT" && cat ros2_ws/colcon_defaults.yaml
        find "$@" \( -name test -o -name __pycache__ -o -name '.*' -o -name '*.egg-info' \) -prune -o \
            -type f \( ! -name '*.py' -o -name '*.launch.py' \) ! -name '*~' -print | LC_ALL=C sort
        find "$@" \( -name package.xml -o -name setup.py -o -name setup.cfg -o -name CMakeLists.txt \
            -o -name '*.msg' -o -name '*.srv' -o -name '*.action' \) -print0 |
            LC_ALL=C sort -z | xargs -0 cat
    } | digest
}

# In a shell of its own: who calls stays in the folder that relative paths are meant from.
build_workspace() (
    local folder package key status=0
    local -A changed=()
    cd "$WORKSPACE" || return
    # A build that was cut off, or made by other tools, is not worth mending.
    [[ ! -e install/.building && "$(cat install/.toolchain 2>/dev/null)" == "$(toolchain_key)" ]] ||
        rm -rf build install
    mkdir -p build install && toolchain_key >install/.toolchain || return
    # Packages and data files that are gone leave nothing behind.
    for folder in build/*/ install/*/; do
        [[ ! -d "$folder" || -f "src/$(basename "$folder")/package.xml" ]] || rm -rf "$folder"
    done
    find build install -xtype l -delete
    for folder in src/*/package.xml; do
        package="$(basename "$(dirname "$folder")")"
        key="$(build_key "src/$package")"
        [[ "$(cat "install/$package/.key" 2>/dev/null)" == "$key" ]] || changed["$package"]="$key"
    done
    if ((${#changed[@]})); then
        touch install/.building
        env PATH="$VENV/bin:$PATH" VIRTUAL_ENV="$VENV" AMENT_PREFIX_PATH="$VENV" \
            CMAKE_PREFIX_PATH="$VENV" CMAKE_GENERATOR=Ninja MAKEFLAGS="-j$(nproc)" \
            colcon build --event-handlers console_direct+ --packages-select "${!changed[@]}" || status=$?
        rm install/.building
        ((status == 0)) || return "$status"
    fi
    for package in "${!changed[@]}"; do echo "${changed[$package]}" >"install/$package/.key"; done
    record_environment
)

# Write what sourcing the workspace does to an environment, so that later calls need not wait
# for it. A native ROS in the user's environment is shut out: its Python paths do not fit.
record_environment() {
    # shellcheck disable=SC2016
    env -i PATH="$PATH" HOME="${HOME:-/}" AMENT_PREFIX_PATH="$VENV" VENV="$VENV" bash -c '
        source install/local_setup.bash || exit
        libraries="${LD_LIBRARY_PATH:+${LD_LIBRARY_PATH%:}:}$VENV/lib"
        for folder in "$VENV"/lib/python3.*/site-packages/ros_*.libs; do
            [ ! -d "$folder" ] || libraries="$libraries:$folder"
        done
        echo "export VIRTUAL_ENV=\"$VENV\""
        echo "export AMENT_PREFIX_PATH=\"$AMENT_PREFIX_PATH\""
        echo "export PYTHONPATH=\"$PYTHONPATH\""
        echo "export RMW_IMPLEMENTATION=rmw_fastrtps_cpp"
        echo "case \":\$PATH:\" in *\":$VENV/bin:\"*) ;; *) export PATH=\"$VENV/bin:\$PATH\" ;; esac"
        echo "case \":\${LD_LIBRARY_PATH:-}:\" in *\":$libraries:\"*) ;; *)"
        echo "    export LD_LIBRARY_PATH=\"$libraries\${LD_LIBRARY_PATH:+:\$LD_LIBRARY_PATH}\" ;; esac"
        # The wheels would start every Python twice to set the line above.
        echo "export _ROS_WHEELS_BOOTSTRAP_COMPLETE=1"
    ' >"$ENVIRONMENT" && ln -sf "$ROOT/bha" "$VENV/bin/bha"
}

# --- all of it -----------------------------------------------------------------------------

# phase TITLE COMMAND...: run it with its output in the log; one line with the seconds it took.
phase() {
    local title="$1" started="$SECONDS"
    shift
    printf '  %-58s' "$title" >&2
    printf '\n=== %s\n' "$title" >>"$LOG"
    if ! "$@" >>"$LOG" 2>&1; then
        say "failed"
        tail -n 20 "$LOG" | sed 's/^/    | /' >&2
        die "set-up stopped at: $title" "The whole log: $LOG" \
            "Put right what it names and call ./bha again; what is done already is kept."
    fi
    printf '%4d s\n' "$((SECONDS - started))" >&2
}

venv_ready() { [[ -x "$VENV/bin/python" && "$(cat "$VENV/.stamp" 2>/dev/null)" == "$(venv_key)" ]]; }

workspace_ready() {
    [[ -f "$ENVIRONMENT" && "$(cat "$WORKSPACE/install/.stamp" 2>/dev/null)" == "$(build_key src)" ]]
}

is_ready() { venv_ready && { [[ "${1:-}" == --packages-only ]] || workspace_ready; }; }

# setup [--packages-only]: the second form, for images, makes .venv and builds nothing.
setup() {
    [[ $# == 0 || "$*" == --packages-only ]] || die "setup knows one option: --packages-only"
    is_ready "$@" && return
    # What set-up starts holds the lock too, so that it ends only when all of that has ended.
    exec 9<"$ROOT/bha"
    flock -n 9 || { say "bha: another ./bha is setting up; waiting for it." && flock 9; }
    is_ready "$@" || make_ready "$@"
    exec 9<&-
}

make_ready() {
    # What other environments exported has no place in this one.
    unset _ROS_WHEELS_BOOTSTRAP_COMPLETE PYTHONPATH PYTHONHOME AMENT_PREFIX_PATH CMAKE_PREFIX_PATH
    mkdir -p "$(dirname "$LOG")"
    : >"$LOG"
    local started="$SECONDS"
    provide_system
    if ! venv_ready; then
        say "Setting up in $ROOT (once; the log is ros2_ws/log/setup.log)"
        phase "Python environment" make_venv
        phase "pinned packages, ROS 2 among them" install_requirements
        venv_key >"$VENV/.stamp"
    fi
    if [[ "${1:-}" != --packages-only ]] && ! workspace_ready; then
        local key
        key="$(build_key src)"
        phase "workspace (colcon build; a minute or two at first)" build_workspace
        echo "$key" >"$WORKSPACE/install/.stamp"
    fi
    say "  ready after $((SECONDS - started)) s"
}
