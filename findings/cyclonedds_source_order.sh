#!/usr/bin/env bash
# A DDS reader that orders samples by their time stamps drops those that come too late.
#
# Expected: DestinationOrder.BySourceTimestamp with History.KeepAll and reliable delivery sorts:
# what is taken is in the order of the stamps, and all of it is there.
# Happens: a sample that is older than the newest one so far is left out, though nothing has been
# taken yet. The standard allows it: the order holds for what is delivered.
# Matters: of two cameras, or of one whose stamps were corrected backwards, samples are missing
# although delivery is reliable and no history was full.
#
# cyclonedds 11.0.1, written with the stamps 10, 30, 20 and 40 s:
#   10 30 40
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    cyclonedds==11.0.1
export CYCLONEDDS_URI='<General><Interfaces><NetworkInterface name="lo" multicast="false"/>
    </Interfaces><AllowMulticast>false</AllowMulticast></General>'
cat > "$folder/order.py" <<'END'
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class Light(IdlStruct, typename='Light'):
    number: int


participant = DomainParticipant(77)
topic = Topic(participant, 'lights', Light)
qos = Qos(Policy.DestinationOrder.BySourceTimestamp, Policy.History.KeepAll,
          Policy.Reliability.Reliable(duration(seconds=1)))
reader, writer = DataReader(participant, topic, qos=qos), DataWriter(participant, topic, qos=qos)
for seconds in (10, 30, 20, 40):
    writer.write(Light(seconds), timestamp=seconds * 10 ** 9)
taken = [light.number for light in reader.take_iter(timeout=duration(seconds=1))]
print(*taken)
if taken != [10, 30, 40]:
    raise SystemExit('A late sample is no longer left out.')
END
"$folder/venv/bin/python" -I "$folder/order.py"
