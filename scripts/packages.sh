# Debian 12 packages of Tandem, and how they get installed. Sourced by scripts/demo and scripts/test.

# To build and run: libraries, program, the demo's picture and the cyclictest it runs beside itself.
build_packages=(
  g++ cmake ninja-build ccache
  libglm-dev libprotobuf-dev protobuf-compiler libboost1.81-dev libhdf5-dev zlib1g-dev
  libcli11-dev libfmt-dev nlohmann-json3-dev libeigen3-dev libgtest-dev libbenchmark-dev
  python3 python3-matplotlib rt-tests python3-dev python3-numpy pybind11-dev
  libglfw3-dev libimgui-dev libepoxy-dev libpng-dev libx11-dev libegl1 libgl1-mesa-dri fonts-dejavu-core
)
# For `tandem netem`: namespaces and conditions, and a kernel that has netem where this one has none.
netem_packages=(iproute2 user-mode-linux)
# What `tandem bench error` and `bench latency` compare with, if it is there; MuJoCo: pip install mujoco.
bench_packages=(libbox2d-dev libbullet-dev libode-dev libenet-dev cyclonedds-dev cyclonedds-tools sockperf)
# For the tests beyond that: formatting, lint, network namespaces.
test_packages=(clang-format-14 clang-tidy-14 iproute2 procps util-linux xvfb libxtst-dev)

# need_packages PACKAGE ...: installs what is missing, with one apt-get call; says what and how when
# it may not. Nothing is asked and nothing is upgraded.
need_packages() {
  local missing=() package
  if ! command -v dpkg-query >/dev/null; then
    echo "This is not a Debian system: install what these Debian 12 packages hold, then comment" >&2
    echo "out this check: $*" >&2
    return 1
  fi
  for package in "$@"; do
    [ "$(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null)" = installed ] ||
      missing+=("$package")
  done
  [ ${#missing[@]} -eq 0 ] && return 0

  local as_root=()
  if [ "$(id -u)" -ne 0 ]; then
    if command -v sudo >/dev/null && sudo -n true 2>/dev/null; then
      as_root=(sudo -n)
    elif command -v sudo >/dev/null && [ -t 0 ]; then
      as_root=(sudo)
    else
      echo "These packages are missing and installing them needs root:" >&2
      echo "  apt-get install --no-install-recommends ${missing[*]}" >&2
      return 1
    fi
  fi
  echo "-- installing ${#missing[@]} Debian packages: ${missing[*]}"
  local log
  log=$(mktemp)
  # A shell may have a package list already; a fresh machine has none.
  if ! { "${as_root[@]}" apt-get update -qq && "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y -qq --no-install-recommends "${missing[@]}"; } >"$log" 2>&1 </dev/null; then
    tail -n 20 "$log" >&2
    echo "Installing failed (above). By hand, as root:" >&2
    echo "  apt-get update && apt-get install --no-install-recommends ${missing[*]}" >&2
    rm -f "$log"
    return 1
  fi
  rm -f "$log"
}
