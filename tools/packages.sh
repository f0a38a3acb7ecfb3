# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# What quickstart and check install. Sourced, not run.

# shellcheck disable=SC2034  # used by the sourcing scripts
BUILD_PACKAGES=(g++ cmake ninja-build pkg-config ccache libboost1.81-dev libserialport-dev
  libspdlog-dev libexpected-dev nlohmann-json3-dev libsqlite3-dev libcli11-dev libeigen3-dev
  libssl-dev libutfcpp-dev)
# shellcheck disable=SC2034
TEST_PACKAGES=(libgtest-dev libgmock-dev librapidcheck-dev git socat sqlite3 strace procps python3 python3-jsonschema
  clang-19 clang-tidy-19 clang-format-19 clang-tools-19 libclang-rt-19-dev lld codespell shellcheck
  scdoc systemd)

# For tests/package/run alone.
# shellcheck disable=SC2034
PACKAGING_PACKAGES=(build-essential debhelper po-debconf python3 scdoc lintian debootstrap
  systemd-container sqlite3)

missing_packages() {
  local package
  for package in "$@"; do
    [[ $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) == installed ]] ||
      printf '%s\n' "$package"
  done
}

as_root() {
  if [[ $(id -u) -eq 0 ]]; then
    "$@"
  else
    sudo "$@"
  fi
}

apt_get() {
  as_root env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=300 "$@"
}

# --no-remove: another Boost (libboost1.74-dev) conflicts with ours and must not vanish unasked.
apt_install() {
  apt_get install --yes --no-install-recommends --no-remove "$@"
}

# Installs those of the named packages that are missing; needs root or sudo only when some are.
install_packages() {
  local missing log
  mapfile -t missing < <(missing_packages "$@")
  [[ ${#missing[@]} -gt 0 ]] || return 0
  if [[ $(id -u) -ne 0 ]] && ! command -v sudo >/dev/null; then
    cat >&2 <<MESSAGE
These Debian packages are missing, and you are neither root nor is sudo there to install them:
  ${missing[*]}
Ask an administrator to run this, then start again:
  apt-get update && apt-get install --no-install-recommends ${missing[*]}
MESSAGE
    return 1
  fi
  echo "installing ${#missing[@]} packages: ${missing[*]}"
  log=$(mktemp)
  # Package lists that are absent or old make the first attempt fail.
  if ! apt_install "${missing[@]}" >"$log" 2>&1; then
    if ! { apt_get update && apt_install "${missing[@]}"; } >"$log" 2>&1; then
      cat "$log" >&2
      echo "apt could not install the packages (its messages are above)." >&2
      if dpkg-query -W libboost1.74-dev >/dev/null 2>&1; then
        echo "libboost1.74-dev is installed and conflicts with libboost1.81-dev: remove it first," \
          "or build in a container." >&2
      fi
      rm -f "$log"
      return 1
    fi
  fi
  rm -f "$log"
}
