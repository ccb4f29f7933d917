#!/usr/bin/env bash
# A video device does not start because of a format on the way to another video device.
#
# Expected: behind a media controller (such as that of a Raspberry Pi) the formats between the
# sensor and the video device that is started have to fit each other, and those alone.
# Happens: the kernel validates every enabled link that it comes to from there, those from the
# sensor to video devices that nobody has opened among them. If one does not fit, VIDIOC_STREAMON
# gives EPIPE, which does not say which.
# Matters: one looks for a fault between sensor and device, where there is none. The other links
# have to be disabled, or set up to their ends.
#
# The kernel's own example, vimc, of Linux 6.1.176 (Debian 12), in a virtual machine. Its sensor
# feeds "Raw Capture 0" and, through a debayer and a scaler, "RGB/YUV Capture". All but the latter
# have formats of 160x120 that fit, and "Raw Capture 0" is started:
#   RGB/YUV Capture is at 320x240: Broken pipe
#   RGB/YUV Capture is at 160x120: Success
#   RGB/YUV Capture is at 320x240, the link to the scaler disabled: Success
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
linux=6.1.0-50
apt-get download --quiet=2 -o APT::Sandbox::User=root \
    linux-{image,headers}-$linux-amd64=6.1.176-1 linux-headers-$linux-common=6.1.176-1 \
    linux-{kbuild,source}-6.1=6.1.176-1 libelf1=0.188-2.1 busybox-static=1:1.35.0-4+deb12u1+b1
for package in *.deb; do dpkg-deb --extract "$package" root; done
headers=$folder/root/usr/src/linux-headers-$linux-amd64
sed -i "s, /usr/src/, $folder/root/usr/src/," "$headers/Makefile"
code=drivers/media/test-drivers/vimc
tar --extract --file root/usr/src/linux-source-6.1.tar.xz --wildcards "*/$code/*"
mv linux-source-6.1/$code vimc
LD_LIBRARY_PATH=$folder/root/usr/lib/x86_64-linux-gnu \
    make --silent -C "$headers" M="$folder/vimc" CONFIG_VIDEO_VIMC=m modules > make.log 2>&1 ||
    { cat make.log; exit 1; }

mkdir guest guest/{bin,dev,sys}
cp root/bin/busybox guest/bin
media=root/lib/modules/$linux-amd64/kernel/drivers/media
cp $media/{mc/mc,v4l2-core/videodev,common/v4l2-tpg/v4l2-tpg}.ko \
    $media/common/videobuf2/videobuf2-{common,memops,v4l2,vmalloc,dma-contig}.ko \
    vimc/vimc.ko guest
cat > camera.c <<'END'
#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <linux/media.h>
#include <linux/media-bus-format.h>
#include <linux/v4l2-subdev.h>
#include <linux/videodev2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

static void must(int failed, const char *what)
{
    if (failed) {
        printf("seen: %s: %s\n", what, strerror(errno));
        exit(1);
    }
}

static int opened(const char *entity)
{
    glob_t names;
    glob("/sys/class/video4linux/*/name", 0, NULL, &names);
    for (size_t i = 0; i < names.gl_pathc; i++) {
        char name[64] = "", node[64], device[80];
        FILE *file = fopen(names.gl_pathv[i], "r");
        fgets(name, sizeof name, file);
        fclose(file);
        name[strcspn(name, "\n")] = 0;
        if (!strcmp(name, entity)) {
            sscanf(names.gl_pathv[i], "/sys/class/video4linux/%63[^/]", node);
            sprintf(device, "/dev/%s", node);
            return open(device, O_RDWR);
        }
    }
    must(1, entity);
    return -1;
}

static void set_pad(const char *entity, unsigned pad, unsigned code)
{
    struct v4l2_subdev_format format = {
        .which = V4L2_SUBDEV_FORMAT_ACTIVE, .pad = pad, .format = {
            .width = 160, .height = 120, .code = code, .field = V4L2_FIELD_NONE}};
    int device = opened(entity);
    must(ioctl(device, VIDIOC_SUBDEV_S_FMT, &format), entity);
    must(format.format.width != 160 || format.format.code != code, entity);
    close(device);
}

static int set_device(const char *entity, unsigned pixels, unsigned width, unsigned height)
{
    struct v4l2_format format = {.type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .fmt.pix = {
        .width = width, .height = height, .pixelformat = pixels, .field = V4L2_FIELD_NONE}};
    int device = opened(entity);
    must(ioctl(device, VIDIOC_S_FMT, &format), entity);
    must(format.fmt.pix.width != width || format.fmt.pix.pixelformat != pixels, entity);
    return device;
}

static void start_raw(const char *when)
{
    struct v4l2_requestbuffers buffers = {
        .count = 2, .type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .memory = V4L2_MEMORY_MMAP};
    struct v4l2_buffer buffer = {.type = buffers.type, .memory = V4L2_MEMORY_MMAP};
    int device = set_device("Raw Capture 0", V4L2_PIX_FMT_SRGGB8, 160, 120);
    must(ioctl(device, VIDIOC_REQBUFS, &buffers), "VIDIOC_REQBUFS");
    for (buffer.index = 0; buffer.index < buffers.count; buffer.index++)
        must(ioctl(device, VIDIOC_QBUF, &buffer), "VIDIOC_QBUF");
    int failed = ioctl(device, VIDIOC_STREAMON, &buffers.type);
    printf("seen: RGB/YUV Capture is at %s: %s\n", when, strerror(failed ? errno : 0));
    close(device);
}

static unsigned entity_id(int media, const char *name)
{
    struct media_entity_desc entity = {.id = MEDIA_ENT_ID_FLAG_NEXT};
    while (!ioctl(media, MEDIA_IOC_ENUM_ENTITIES, &entity)) {
        if (!strcmp(entity.name, name))
            return entity.id;
        entity.id |= MEDIA_ENT_ID_FLAG_NEXT;
    }
    must(1, name);
    return 0;
}

int main(void)
{
    set_pad("Sensor A", 0, MEDIA_BUS_FMT_SRGGB8_1X8);
    set_pad("Debayer A", 0, MEDIA_BUS_FMT_SRGGB8_1X8);
    set_pad("Scaler", 0, MEDIA_BUS_FMT_RGB888_1X24);
    set_pad("Scaler", 1, MEDIA_BUS_FMT_RGB888_1X24);

    close(set_device("RGB/YUV Capture", V4L2_PIX_FMT_RGB24, 320, 240));
    start_raw("320x240");
    close(set_device("RGB/YUV Capture", V4L2_PIX_FMT_RGB24, 160, 120));
    start_raw("160x120");
    close(set_device("RGB/YUV Capture", V4L2_PIX_FMT_RGB24, 320, 240));
    int media = open("/dev/media0", O_RDWR);
    struct media_link_desc link = {
        .source = {.entity = entity_id(media, "Debayer A"), .index = 1},
        .sink = {.entity = entity_id(media, "Scaler"), .index = 0}, .flags = 0};
    must(ioctl(media, MEDIA_IOC_SETUP_LINK, &link), "MEDIA_IOC_SETUP_LINK");
    start_raw("320x240, the link to the scaler disabled");
    return 0;
}
END
gcc -static -o guest/camera camera.c
cat > guest/init <<'END'
#!/bin/busybox sh
/bin/busybox --install -s /bin
mount -t devtmpfs dev /dev
mount -t sysfs sys /sys
for module in mc videodev v4l2-tpg videobuf2-common videobuf2-memops videobuf2-v4l2 \
    videobuf2-vmalloc videobuf2-dma-contig vimc
do
    insmod /$module.ko
done
/camera
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
RGB/YUV Capture is at 320x240: Broken pipe
RGB/YUV Capture is at 160x120: Success
RGB/YUV Capture is at 320x240, the link to the scaler disabled: Success
END
then
    echo 'A video device now starts whatever the formats on the way to another one are, or never.'
    exit 1
fi
