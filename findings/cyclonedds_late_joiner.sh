#!/usr/bin/env bash
# A reader that joins late gets one sample of Cyclone DDS, though the writer keeps all.
#
# Expected: TransientLocal with History.KeepAll on both sides gives a late reader all samples that
# were written, as those who come from ROS know it.
# Happens: it gets the last. What is kept for late readers has a QoS policy of its own,
# DurabilityService, whose history is KeepLast(1) by default; that of the writer does not count.
# Matters: of what is said once (which lights there are, one message each) a tool that is started
# later hears the last only.
#
# cyclonedds 11.0.1, of five samples:
#   History.KeepAll: 4
#   and DurabilityService with KeepAll: 0 1 2 3 4
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary=:all: \
    cyclonedds==11.0.1
export CYCLONEDDS_URI='<General><Interfaces><NetworkInterface name="lo" multicast="false"/>
    </Interfaces><AllowMulticast>false</AllowMulticast></General>'
cat > "$folder/late.py" <<'END'
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


KEPT = Policy.Durability.TransientLocal, Policy.Reliability.Reliable(duration(seconds=1))
ALL = Policy.History.KeepAll
SERVICE = Policy.DurabilityService(duration(seconds=0), ALL, -1, -1, -1)
participant = DomainParticipant(77)


def heard(name: str, *more: object) -> list[int]:
    """Return what a reader that joins after five samples gets."""
    qos = Qos(*KEPT, ALL, *more)
    topic = Topic(participant, name, Light)
    writer = DataWriter(participant, topic, qos=qos)
    for number in range(5):
        writer.write(Light(number))
    reader = DataReader(participant, topic, qos=Qos(*KEPT, ALL))
    return [light.number for light in reader.take_iter(timeout=duration(seconds=1))]


plain, served = heard('plain'), heard('served', SERVICE)
print('History.KeepAll:', *plain)
print('and DurabilityService with KeepAll:', *served)
if plain != [4] or served != [0, 1, 2, 3, 4]:
    raise SystemExit('A late reader no longer gets just the last sample.')
END
"$folder/venv/bin/python" -I "$folder/late.py"
