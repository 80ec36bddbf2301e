# SPDX-License-Identifier: Apache-2.0
# What the benchmarks in shell share; for `source`.

# need NAME PROGRAM...: ends benchmark NAME in peace where one of the programs is not installed.
need() {
  local program
  for program in "${@:2}"; do
    command -v "$program" >/dev/null || {
      printf '%s: %s is not installed: nothing was compared\n' "$1" "$program"
      exit 0
    }
  done
}

# In a folder that is gone when the benchmark ends.
folder=$(mktemp -d)
trap 'rm -rf -- "$folder"' EXIT

# quiet COMMAND...: its output goes to a log, and to stderr if it fails.
quiet() {
  "$@" >log.txt 2>&1 </dev/null || {
    cat -- log.txt >&2
    return 1
  }
}
