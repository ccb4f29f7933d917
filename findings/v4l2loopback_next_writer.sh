#!/usr/bin/env bash
# A v4l2loopback device takes no second writer, and the flag of its stamps says "unknown clock".
#
# Expected: once a program that wrote pictures has ended and nobody has the device open, another one
# may write. Frames are stamped with CLOCK_MONOTONIC and flagged so, as those of cameras are.
# Happens: with exclusive_caps=1, which browsers want, a device is an output until somebody writes
# and a camera from then on. A writer that calls write(), as ffmpeg does, leaves it neither: as soon
# as any program has asked what it is (VIDIOC_QUERYCAP), VIDIOC_S_FMT gives EINVAL until the module
# is loaded again. After a writer that hands over buffers it is an output again. The stamps are
# those of CLOCK_MONOTONIC, but their flag is V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN.
# Version 0.15.0 (Debian 13) takes the next writer, and flags the stamps.
# Matters: a stream cannot be started a second time once anybody has looked at the device, and a
# program that trusts the flag throws good stamps away.
#
# v4l2loopback 0.12.7 on Linux 6.1.176 (both Debian 12), in a virtual machine, one writer after
# another:
#   buffers: an output, VIDIOC_S_FMT: Success
#   write: an output, VIDIOC_S_FMT: Success, stamp monotonic, flag unknown
#   write: neither, VIDIOC_S_FMT: Invalid argument
#   write: neither, VIDIOC_S_FMT: Invalid argument
#   loaded again
#   write: an output, VIDIOC_S_FMT: Success, stamp monotonic, flag unknown
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
linux=6.1.0-50
apt-get download --quiet=2 -o APT::Sandbox::User=root \
    linux-{image,headers}-$linux-amd64=6.1.176-1 linux-headers-$linux-common=6.1.176-1 \
    linux-kbuild-6.1=6.1.176-1 libelf1=0.188-2.1 busybox-static=1:1.35.0-4+deb12u1+b1 \
    v4l2loopback-dkms=0.12.7-2
for package in *.deb; do dpkg-deb --extract "$package" root; done
headers=$folder/root/usr/src/linux-headers-$linux-amd64
sed -i "s, /usr/src/, $folder/root/usr/src/," "$headers/Makefile"
code=$folder/root/usr/src/v4l2loopback-0.12.7
LD_LIBRARY_PATH=$folder/root/usr/lib/x86_64-linux-gnu \
    make --silent -C "$headers" M="$code" modules > make.log 2>&1 || { cat make.log; exit 1; }

mkdir guest guest/{bin,dev}
cp root/bin/busybox guest/bin
cp root/lib/modules/$linux-amd64/kernel/drivers/media/{mc/mc,v4l2-core/videodev}.ko \
    "$code/v4l2loopback.ko" guest
cat > writer.c <<'END'
#include <errno.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

static char picture[160 * 120];

static long long now_us(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * 1000000LL + now.tv_nsec / 1000;
}

static void hand_over(int writer)
{
    struct v4l2_requestbuffers buffers = {
        .count = 2, .type = V4L2_BUF_TYPE_VIDEO_OUTPUT, .memory = V4L2_MEMORY_MMAP};
    struct v4l2_buffer buffer = {
        .type = buffers.type, .memory = V4L2_MEMORY_MMAP, .bytesused = sizeof picture};
    if (ioctl(writer, VIDIOC_REQBUFS, &buffers) || ioctl(writer, VIDIOC_QBUF, &buffer)
        || ioctl(writer, VIDIOC_STREAMON, &buffers.type))
        printf(", buffers: %s", strerror(errno));
}

static void write_and_read(int writer)
{
    struct v4l2_requestbuffers buffers = {
        .count = 2, .type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .memory = V4L2_MEMORY_MMAP};
    struct v4l2_buffer buffer = {.type = buffers.type, .memory = V4L2_MEMORY_MMAP};
    struct v4l2_capability able;
    write(writer, picture, sizeof picture);
    int reader = open("/dev/video0", O_RDWR);
    ioctl(reader, VIDIOC_QUERYCAP, &able);
    ioctl(reader, VIDIOC_REQBUFS, &buffers);
    for (buffer.index = 0; buffer.index < buffers.count; buffer.index++) {
        ioctl(reader, VIDIOC_QUERYBUF, &buffer);
        mmap(NULL, buffer.length, PROT_READ, MAP_SHARED, reader, buffer.m.offset);
        ioctl(reader, VIDIOC_QBUF, &buffer);
    }
    ioctl(reader, VIDIOC_STREAMON, &buffers.type);
    ioctl(reader, VIDIOC_DQBUF, &buffer);
    long long before = now_us();
    write(writer, picture, sizeof picture);
    long long after = now_us();
    if (ioctl(reader, VIDIOC_DQBUF, &buffer))
        printf(", VIDIOC_DQBUF: %s", strerror(errno));
    long long stamp = buffer.timestamp.tv_sec * 1000000LL + buffer.timestamp.tv_usec;
    unsigned clock = buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK;
    printf(", stamp %s, flag %s",
           before <= stamp && stamp <= after ? "monotonic" : "of another clock",
           clock == V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN ? "unknown"
           : clock == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC ? "monotonic" : "of another clock");
}

int main(int count, char **words)
{
    struct v4l2_capability able = {0};
    struct v4l2_format format = {.type = V4L2_BUF_TYPE_VIDEO_OUTPUT, .fmt.pix = {
        .width = 160, .height = 120, .pixelformat = V4L2_PIX_FMT_GREY,
        .field = V4L2_FIELD_NONE}};
    int writer = open("/dev/video0", O_RDWR);
    ioctl(writer, VIDIOC_QUERYCAP, &able);
    int failed = ioctl(writer, VIDIOC_S_FMT, &format);
    printf("seen: %s: %s, VIDIOC_S_FMT: %s", words[1],
           able.device_caps & V4L2_CAP_VIDEO_OUTPUT ? "an output"
           : able.device_caps & V4L2_CAP_VIDEO_CAPTURE ? "a camera" : "neither",
           strerror(failed ? errno : 0));
    if (!failed && strcmp(words[1], "write"))
        hand_over(writer);
    else if (!failed)
        write_and_read(writer);
    puts("");
    return 0;
}
END
gcc -static -o guest/writer writer.c
cat > guest/init <<'END'
#!/bin/busybox sh
/bin/busybox --install -s /bin
mount -t devtmpfs dev /dev
insmod /mc.ko
insmod /videodev.ko
insmod /v4l2loopback.ko exclusive_caps=1
/writer buffers
/writer write
/writer write
/writer write
rmmod v4l2loopback
insmod /v4l2loopback.ko exclusive_caps=1
echo 'seen: loaded again'
/writer write
echo 'the end'
poweroff -f
END
chmod +x guest/init
(cd guest && find . | cpio --create --format=newc --quiet) > initramfs
timeout 300 qemu-system-x86_64 -accel tcg -cpu max -m 512 -nic none -no-reboot -display none \
    -monitor none -serial stdio -kernel root/boot/vmlinuz-$linux-amd64 -initrd initramfs \
    -append 'console=ttyS0 quiet panic=-1 mitigations=off no_timer_check tsc=reliable' \
    < /dev/null | tr -d '\r' > console || true
if ! grep -q '^the end' console; then
    cat console
    echo 'The virtual machine did not come to its end.'
    exit 1
fi
sed -n 's/^seen: //p' console | tee seen
if ! cmp -s seen - <<'END'
buffers: an output, VIDIOC_S_FMT: Success
write: an output, VIDIOC_S_FMT: Success, stamp monotonic, flag unknown
write: neither, VIDIOC_S_FMT: Invalid argument
write: neither, VIDIOC_S_FMT: Invalid argument
loaded again
write: an output, VIDIOC_S_FMT: Success, stamp monotonic, flag unknown
END
then
    echo 'v4l2loopback now takes another writer, or tells the clock of its stamps.'
    exit 1
fi
