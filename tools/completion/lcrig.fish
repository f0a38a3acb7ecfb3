# SPDX-License-Identifier: Apache-2.0
# Completion of lcrig, lcrigd and lcrig-sim for fish. The programs themselves say which words are
# possible.
function __lcrig_complete
    set -l before (commandline -opc)
    set -l current (commandline -ct)
    set -l lines (command $before[1] __complete -- $before[2..-1] "$current" 2>/dev/null)
    set -q lines[1]; or return
    switch $lines[1]
        case file
            __fish_complete_path "$current"
        case json
            __fish_complete_suffix "$current" .json
        case dir
            __fish_complete_directories "$current"
    end
    set -q lines[2]; and printf '%s\n' $lines[2..-1]
end
for program in lcrig lcrigd lcrig-sim
    complete -c $program -f -a '(__lcrig_complete)'
end
