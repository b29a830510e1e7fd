#!/usr/bin/env bash
# The cyclomatic complexity of the components that the paper's Table 3 lists, as a table, by lizard
# (pip install lizard==1.24.3):
#
#     ceid-core/examples/subsumption/complexity.sh
#
# Fails if a component has more than 8, or all of them more than 33, which is what the paper has.
#
# Counted as the paper's tool, cccc, does: the decisions in the functions of a component, so that a component without a
# branch has 0. The last column is the usual figure for one function, which is its decisions and 1.
set -euo pipefail
cd "$(dirname "$0")/../.."
export LC_ALL=C

if ! command -v lizard >/dev/null; then
    echo 'missing: pip install lizard==1.24.3' >&2
    exit 3
fi

# Component, the paper's figure for C++11, and the files.
components='ComputerVision 6 examples/subsumption/robot/computer_vision.rs
MotorControl 6 examples/subsumption/robot/motor_control.rs
SensorRecognition 5 examples/subsumption/robot/sensor_recognition.rs
SAInterference 8 examples/subsumption/robot/sa_interference.rs
RealtimeFunctionalityIF 0 src/thread/mod.rs
ChronoCycleLogicalThread 1 src/thread/chrono.rs
RTPreemptCycleLogicalThread 3 src/thread/rt_preempt.rs
TransactionIO 4 src/transaction.rs'

# Decisions of all functions, and the figure of the largest function.
measure() {
    lizard -l rust --csv "$@" | awk -F, '{ decisions += $2 - 1; if ($2 > largest) largest = $2 }
        END { print decisions + 0, largest + 0 }'
}

echo '| component | the paper, C++11 | here | largest function |'
echo '| --- | ---: | ---: | ---: |'
sum=0 of_the_paper=0 status=0
while read -r component paper file; do
    read -r decisions largest <<<"$(measure "$file")"
    echo "| $component | $paper | $decisions | $largest |"
    sum=$((sum + decisions)) of_the_paper=$((of_the_paper + paper))
    if [ "$decisions" -gt 8 ]; then status=1; fi
done <<<"$components"
echo "| total | $of_the_paper | $sum | |"
if [ "$sum" -gt 33 ]; then status=1; fi
exit "$status"
