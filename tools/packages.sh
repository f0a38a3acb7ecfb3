# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash
# What quickstart and check install. Sourced, not run.

# `boost-headers` is no package but what is needed: see boost_package.
# shellcheck disable=SC2034  # used by the sourcing scripts
BUILD_PACKAGES=(g++ cmake ninja-build pkg-config ccache boost-headers libserialport-dev
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

BOOST_MINIMUM=1.81

# The version of Boost's headers on this machine ("1.83"), or nothing.
boost_version() {
  sed -nE 's/^#define BOOST_LIB_VERSION "([0-9]+)_([0-9]+).*/\1.\2/p' \
    /usr/include/boost/version.hpp 2>/dev/null
}

at_least() {  # VERSION MINIMUM
  [[ -n $1 ]] && dpkg --compare-versions "$1" ge "$2"
}

# The package that brings Boost's headers: libboost-dev where it is new enough (Debian 13), else the
# oldest libboost1.NN-dev that is (Debian 12). Fails where apt knows neither.
boost_package() {
  local package version
  while read -r package; do
    version=$(apt-cache policy "$package" | sed -nE 's/^ *Candidate: ([0-9].*)/\1/p')
    if at_least "$version" "$BOOST_MINIMUM"; then
      echo "$package"
      return
    fi
  done < <(apt-cache --names-only search '^libboost([0-9.]+)?-dev$' | cut -d' ' -f1 | sort -V)
  return 1
}

missing_packages() {
  local package
  for package in "$@"; do
    if [[ $package == boost-headers ]]; then
      at_least "$(boost_version)" "$BOOST_MINIMUM" || printf '%s\n' "$package"
    elif [[ $(dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null) != installed ]]; then
      printf '%s\n' "$package"
    fi
  done
}

# The named packages, with `boost-headers` as the package that has them here.
package_names() {
  local package
  for package in "$@"; do
    [[ $package != boost-headers ]] || package=$(boost_package) || package="boost-headers>=$BOOST_MINIMUM"
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

# --no-remove: another Boost that is installed must not vanish without a question.
apt_install() {
  local names
  mapfile -t names < <(package_names "$@")
  apt_get install --yes --no-install-recommends --no-remove "${names[@]}"
}

# Why apt could not install, as far as it is known.
explain_boost() {
  local version
  version=$(boost_version)
  ! at_least "$version" "$BOOST_MINIMUM" || return 0
  boost_package >/dev/null ||
    echo "No package here has Boost's headers of version $BOOST_MINIMUM or later (Debian 12 and 13 have them)."
  [[ -z $version ]] || echo "The Boost headers that are installed ($version) are older than $BOOST_MINIMUM and conflict with" \
    "newer ones: remove them first (libboost$version-dev), or build in a container."
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
  apt-get update && apt-get install --no-install-recommends $(package_names "${missing[@]}" | paste -sd' ')
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
      explain_boost >&2
      rm -f "$log"
      return 1
    fi
  fi
  rm -f "$log"
}
