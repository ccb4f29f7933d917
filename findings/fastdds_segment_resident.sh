#!/usr/bin/env bash
# A large shared-memory segment costs each process all of it, whether anything is published or not.
#
# Expected: the segment that a profile of Fast DDS asks for is reserved; its pages are taken as
# messages fill them, as with any other file that is mapped or any large malloc().
# Happens: all of it is resident from the moment at which the participant is made, in each process.
# Matters: a profile made for pictures, with 32 MiB, costs a node that publishes a few numbers as
# much; ten nodes fill a third of a gigabyte. Nodes that publish no pictures want one of their own.
#
# rclpy 7.1.6 of ROS 2 Jazzy, a node that has published nothing:
#   segment of 1 MiB: 1 MiB of it resident
#   segment of 32 MiB: 32 MiB of it resident
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"${PYTHON:-python3}" -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet --disable-pip-version-check \
    numpy==2.2.6 'ros-jazzy-rclpy[fastrtps]==7.1.6'
export ROS_LOG_DIR=$folder ROS_AUTOMATIC_DISCOVERY_RANGE=OFF
unset FASTDDS_BUILTIN_TRANSPORTS FASTDDS_DEFAULT_PROFILES_FILE
cat >"$folder/node.py" <<'END'
from pathlib import Path

import rclpy
from rclpy.node import Node

rclpy.init()
node = Node('light')
resident, of_segment = 0, False
for line in Path('/proc/self/smaps').read_text().splitlines():
    words = line.split()
    if '-' in words[0] and not words[0].endswith(':'):
        name = words[-1]
        of_segment = '/fastrtps_' in name and '_port' not in name
    elif of_segment and words[0] == 'Rss:':
        resident = max(resident, int(words[1]))
print(f'{resident // 1024} MiB of it resident')
node.destroy_node()
rclpy.shutdown()
END
for mebibytes in 1 32; do
    cat >"$folder/profile.xml" <<END
<dds xmlns="http://www.eprosima.com">
  <profiles>
    <transport_descriptors>
      <transport_descriptor>
        <transport_id>shared</transport_id>
        <type>SHM</type>
        <segment_size>$((mebibytes * 1048576))</segment_size>
      </transport_descriptor>
    </transport_descriptors>
    <participant profile_name="participant" is_default_profile="true">
      <rtps>
        <userTransports>
          <transport_id>shared</transport_id>
        </userTransports>
        <useBuiltinTransports>false</useBuiltinTransports>
      </rtps>
    </participant>
  </profiles>
</dds>
END
    echo "segment of $mebibytes MiB: $(FASTRTPS_DEFAULT_PROFILES_FILE=$folder/profile.xml \
        "$folder/venv/bin/python" -I "$folder/node.py")"
done | tee "$folder/found"
if ! diff "$folder/found" - >/dev/null <<'END'
segment of 1 MiB: 1 MiB of it resident
segment of 32 MiB: 32 MiB of it resident
END
then
    echo 'Fast DDS no longer has the whole segment resident.' >&2
    exit 1
fi
