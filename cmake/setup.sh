# Sourced by ./demo and ./check: the packages they need, on Debian and its relatives.

# need PACKAGE...: installs the missing packages, or prints which are missing and exits.
need() {
  command -v dpkg-query >/dev/null && command -v apt-get >/dev/null || {
    echo "This is no Debian, so nothing is installed. Needed, under their Debian names: $*" >&2
    return
  }
  local package missing=() as_root=()
  for package in "$@"; do
    [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) == installed ]] || missing+=("$package")
  done
  ((${#missing[@]})) || return 0
  if ((EUID != 0)); then
    if ! command -v sudo >/dev/null; then
      echo "Missing: ${missing[*]}" >&2
      echo "There is no sudo; as root, run: apt-get install ${missing[*]}" >&2
      exit 1
    fi
    as_root=(sudo)
  fi
  echo "Installing ${missing[*]}"
  local log
  log=$(mktemp)
  apt() { "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -q "$@" >>"$log" 2>&1; }
  if ! { apt update && apt install -y --no-install-recommends "${missing[@]}"; }; then
    tail -n 20 "$log" >&2
    echo "Could not install: ${missing[*]}" >&2
    exit 1
  fi
  rm -f "$log"
}

# Packages to build the library and the command, and for an OpenCL and a Vulkan device on any CPU.
build_packages=(
  g++ cmake ninja-build libtbb-dev libfmt-dev libcli11-dev libfast-float-dev nlohmann-json3-dev libboost-dev zlib1g-dev
  ocl-icd-opencl-dev opencl-headers pocl-opencl-icd
  libvulkan-dev mesa-vulkan-drivers glslang-tools libtiff-dev
)
# Further packages for the tests, benchmarks and checkers.
check_packages=(
  dpkg-dev pkgconf libgtest-dev librapidcheck-dev libgmp-dev libbenchmark-dev lib3mf-dev
  clang clang-format python3 spirv-tools oclgrind vulkan-validationlayers valgrind
)

quiet() { # quiet COMMAND...: shows its output only if it fails
  local log status=0
  log=$(mktemp)
  "$@" >"$log" 2>&1 || status=$?
  ((status == 0)) || cat "$log" >&2
  rm -f "$log"
  return $status
}
