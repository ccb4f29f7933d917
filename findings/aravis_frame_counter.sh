#!/usr/bin/env bash
# The frame counter of a GigE Vision camera goes from 65535 to 1: there is no frame 0.
#
# Expected: the number of a frame has 16 bits and wraps as such numbers do, so that the frames lost
# are (new - old - 1) % 65536.
# Happens: 0 is reserved where GigE Vision counts in 16 bits, and is left out.
# Matters: one lost frame is counted that never was, every 18 minutes at 60 Hz, and what follows
# frames by their number (lit, unlit, lit) is out of step from there on.
#
# Aravis 0.8.26 (Debian 12) with its simulated camera, which starts a little before the end:
#   65534 65535 1 2
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
apt-get download --quiet=2 -o APT::Sandbox::User=root \
    libaravis-0.8-0=0.8.26-1 gir1.2-aravis-0.8=0.8.26-1 python3-gi=3.42.2-3+b1 \
    libgirepository-1.0-1=1.74.0-3 gir1.2-glib-2.0=1.74.0-3
for package in *.deb; do dpkg-deb --extract "$package" root; done
libraries=$(dirname "$(find "$folder/root" -name 'libaravis-0.8.so.0')")
export LD_LIBRARY_PATH=$libraries GI_TYPELIB_PATH=$libraries/girepository-1.0
export PYTHONPATH=$folder/root/usr/lib/python3/dist-packages
/usr/bin/python3 - <<'END'
import gi

gi.require_version('Aravis', '0.8')
from gi.repository import Aravis

Aravis.enable_interface('Fake')
camera = Aravis.Camera.new('Fake_1')
camera.set_region(0, 0, 32, 32)
camera.set_exposure_time(100.0)
camera.set_frame_rate(100.0)
stream = camera.create_stream(None, None)
for _ in range(20):
    stream.push_buffer(Aravis.Buffer.new_allocate(camera.get_payload()))
camera.start_acquisition()
numbers = []
for _ in range(160):
    picture = stream.timeout_pop_buffer(2_000_000)
    numbers.append(picture.get_frame_id())
    stream.push_buffer(picture)
camera.stop_acquisition()

around = [number for number in numbers if number > 65533 or number < 3]
print(*around)
if around != [65534, 65535, 1, 2]:
    raise SystemExit('The simulated camera no longer leaves frame 0 out.')
END
