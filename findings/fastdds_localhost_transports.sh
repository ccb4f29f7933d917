#!/usr/bin/env bash
# ROS 2 kept to one machine takes no notice of the transports that Fast DDS was told to use.
#
# Expected: FASTDDS_BUILTIN_TRANSPORTS=UDPv4, or a profile of UDP alone, switches shared memory off,
# whatever ROS_AUTOMATIC_DISCOVERY_RANGE says: that one is about who is discovered.
# Happens: for LOCALHOST rmw_fastrtps lays transports of its own, UDP on the loopback and shared
# memory of the size by default. The variable is not even read (a wrong value is no error then), and
# what a profile names comes on top.
# Matters: shared memory stays on between containers that do not share it; or the large segment that
# a profile has for pictures gets one of 512 KiB beside it. With OFF and SUBNET both hold.
#
# rclpy 7.1.6 of ROS 2 Jazzy, a node that is to use UDP alone:
#   OFF, by the variable: UDP alone
#   OFF, by a profile: UDP alone
#   LOCALHOST, by the variable: shared memory too
#   LOCALHOST, by a profile: shared memory too
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 'ros-jazzy-rclpy[fastrtps]==7.1.6'
export ROS_LOG_DIR=$folder
unset FASTRTPS_DEFAULT_PROFILES_FILE FASTDDS_DEFAULT_PROFILES_FILE FASTDDS_BUILTIN_TRANSPORTS
cat >"$folder/udp.xml" <<'END'
<dds xmlns="http://www.eprosima.com">
  <profiles>
    <transport_descriptors>
      <transport_descriptor>
        <transport_id>udp</transport_id>
        <type>UDPv4</type>
      </transport_descriptor>
    </transport_descriptors>
    <participant profile_name="participant" is_default_profile="true">
      <rtps>
        <userTransports>
          <transport_id>udp</transport_id>
        </userTransports>
        <useBuiltinTransports>false</useBuiltinTransports>
      </rtps>
    </participant>
  </profiles>
</dds>
END
cat >"$folder/node.py" <<'END'
from pathlib import Path

import rclpy
from rclpy.node import Node

rclpy.init()
node = Node('light')
shared = '/dev/shm/fastrtps' in Path('/proc/self/maps').read_text()
print('shared memory too' if shared else 'UDP alone')
node.destroy_node()
rclpy.shutdown()
END
for range in OFF LOCALHOST; do
    for way in 'FASTDDS_BUILTIN_TRANSPORTS=UDPv4 the variable' \
            "FASTRTPS_DEFAULT_PROFILES_FILE=$folder/udp.xml a profile"; do
        echo "$range, by ${way#* }: $(env ROS_AUTOMATIC_DISCOVERY_RANGE=$range "${way%% *}" \
            "$folder/venv/bin/python" -I "$folder/node.py")"
    done
done | tee "$folder/found"
if ! diff "$folder/found" - >/dev/null <<'END'
OFF, by the variable: UDP alone
OFF, by a profile: UDP alone
LOCALHOST, by the variable: shared memory too
LOCALHOST, by a profile: shared memory too
END
then
    echo 'LOCALHOST no longer goes past the transports that were chosen.' >&2
    exit 1
fi
