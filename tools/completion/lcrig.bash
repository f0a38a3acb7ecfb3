# SPDX-License-Identifier: Apache-2.0
# Completion of lcrig, lcrigd and lcrig-sim for bash. The programs themselves say which words are
# possible.

# The word as a program would receive it: without its quotes, closed or still open.
_lcrig_unquoted() {
  local word=$1
  case $word in
    \'*) word=${word#\'} && word=${word%\'} ;;
    \"*) word=${word#\"} && word=${word%\"} ;;
    *) word=${word//\\/} ;;
  esac
  printf '%s' "$word"
}

_lcrig() {
  # bash has cut words at = and : (COMP_WORDBREAKS). They are joined again for lcrig.
  local -a words=()
  local i word joins=no
  for ((i = 1; i <= COMP_CWORD; i++)); do
    word=${COMP_WORDS[i]}
    if [[ ${#words[@]} -gt 0 && ($joins == yes || $word == [=:]*) && $word != '' ]]; then
      words[-1]+=$word
    elif [[ $joins == yes ]]; then
      :
    else
      words+=("$word")
    fi
    joins=no
    [[ $word != *[=:] ]] || joins=yes
  done
  local typed=${words[-1]}
  for i in "${!words[@]}"; do words[i]=$(_lcrig_unquoted "${words[i]}"); done
  local current=${words[-1]}

  local files
  local -a lines=()
  mapfile -t lines < <("${COMP_WORDS[0]}" __complete -- "${words[@]}" 2>/dev/null)
  files=${lines[0]:-none}
  # What bash replaces begins behind the last = or : of the word.
  local kept=${current%"${current##*[=:]}"}
  [[ $COMP_WORDBREAKS == *=* && $kept != '' ]] || kept=''

  COMPREPLY=()
  local candidate
  for candidate in "${lines[@]:1}"; do
    candidate=${candidate%%$'\t'*}
    [[ $candidate == "$current"* ]] || continue
    candidate=${candidate#"$kept"}
    # Among files, and inside of quotes, bash quotes what it inserts.
    if [[ $files == none && $typed != [\"\']* && $candidate == *[!A-Za-z0-9_.,:=/+@%-]* ]]; then
      printf -v candidate '%q' "$candidate"
    fi
    COMPREPLY+=("$candidate")
  done
  [[ ${#COMPREPLY[@]} -ne 1 || ${COMPREPLY[0]} != *= ]] || compopt -o nospace 2>/dev/null

  case $files in
    file) [[ ${#COMPREPLY[@]} -gt 0 ]] || compopt -o default 2>/dev/null ;;
    dir) [[ ${#COMPREPLY[@]} -gt 0 ]] || compopt -o dirnames 2>/dev/null ;;
    json)
      compopt -o filenames 2>/dev/null
      local -a found=()
      mapfile -t found < <(
        compgen -f -X '!*.json' -- "${current#"$kept"}"
        compgen -d -- "${current#"$kept"}"
      )
      COMPREPLY+=("${found[@]}")
      ;;
  esac
}
complete -F _lcrig lcrig lcrigd lcrig-sim
