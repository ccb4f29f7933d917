"""camera/image_raw -> target/window: find the flash and cut it out, lit and unlit."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace
import sys
from threading import Lock
import time
from typing import Any

from blob_tracker.camera import CalibrationError, compile_lens
from blob_tracker.camera.response import Response
from blob_tracker.nodes.interface.segmenter import PARAMETERS
from blob_tracker.nodes.rehearsal import Rehearsal, TimedRehearsal
from blob_tracker.nodes.segmenter.last_detections import LastDetections
from blob_tracker.nodes.segmenter.noise_topic import NoiseTopic
from blob_tracker.pipeline import expectation_in
from blob_tracker.ros.diagnostics.clock_jumps import on_clock_jump
from blob_tracker.ros.diagnostics.connections import Connections
from blob_tracker.ros.diagnostics.health import ERROR, Health, WARN
from blob_tracker.ros.diagnostics.losses import Losses, StampGaps
from blob_tracker.ros.endpoints.debug_image import DebugImage
from blob_tracker.ros.endpoints.delivery import Deliver, Delivery
from blob_tracker.ros.endpoints.latest_track import LatestTrack
from blob_tracker.ros.endpoints.names import target_topic
from blob_tracker.ros.endpoints.pairing import FramePairs
from blob_tracker.ros.endpoints.window_topics import WindowTopics
from blob_tracker.ros.errors import MessageError
from blob_tracker.ros.messages.camera_info import KnownCamera
from blob_tracker.ros.messages.clipping import clipping_frame
from blob_tracker.ros.messages.compressed_image import to_frame as of_compressed
from blob_tracker.ros.messages.image import to_frame as of_image
from blob_tracker.ros.parameters.declaration import declare, on_change
from blob_tracker.ros.parameters.rooms import (
    camera_of, flash_of, flash_values, response_of, segmenter_of,
)
from blob_tracker.ros.process import run
from blob_tracker.segmentation import (
    compile_ahead,
    Detections,
    Expectation,
    exposure_fault,
    FieldSegmenter,
    FrameError,
    Segmenter,
)
from blob_tracker.segmentation.channel import ChannelChoice
from blob_tracker.segmentation.compression import standard_quantisation
from blob_tracker.segmentation.history import LEAST_INTERVAL_S
from blob_tracker.segmentation.lock_in import HIGHEST_FREQUENCY
from blob_tracker.segmentation.picture import draw
from blob_tracker.tracking import Track
from blob_tracker.types import Frame, Window
import numpy as np
from numpy.typing import NDArray
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

# s from one picture to the next. Frames with a window have the first call, those with a candidate
# the second: at a fixed pace every picture could be of an unlit frame.
WITH_WINDOW_S, WITH_CANDIDATE_S, WITH_NOTHING_S = 0.1, 0.2, 0.3
CHECK_S = 0.25  # s between two looks at whether frames still come
UNSEEN_S, LOG_AGAIN_S = 5.0, 30.0  # s without a target until the log says why, and says it again
SILENCE_S = 1.0  # s of wall time without a good frame; slow bags and cameras pause for less

Predict = Callable[[str, int], Track | None]


class SegmenterNode(Node):
    """
    See the module's first line; the work is `blob_tracker.segmentation.Segmenter`'s.

    Parameters
    ----------
    listen : bool
        Whether frames come from camera/...; else whoever has them calls `segment`, from one
        thread.
    deliver : callable, optional
        Takes each window in memory.
    announce : callable, optional
        Told the names of the lights before the first window of any.
    predict : callable, optional
        Tells where the camera sees a light, by its name, at a stamp, ns; else target/track does.
    elsewhere : collection of str
        Parameters of other nodes in the same process.

    Attributes
    ----------
    rehearsal : Rehearsal
        To be run by whoever waits for the frames; this node does where it listens itself.

    """

    def __init__(
        self,
        *,
        listen: bool = True,
        deliver: Deliver[tuple[Window, CameraInfo]] | None = None,
        announce: Callable[[Collection[str]], None] | None = None,
        predict: Predict | None = None,
        elsewhere: Collection[str] = (),
    ) -> None:
        super().__init__('segmenter')
        values = declare(self, PARAMETERS, elsewhere)
        self._deliver, self._announce, self._predict = deliver, announce, predict
        self._lock = Lock()  # frames may come from a thread of the camera's
        self._health = Health(
            self,
            'no frames arrive; is a camera publishing camera/image_raw and camera_info?',
            'the camera has become slower, or frames are lost on the way or for lack of time: '
            'compare missing frames, CPU and the diagnostics of the camera',
            self._describe,
        )
        self._searched = self._health.tally('frames')
        self._cut = self._health.tally('windows')
        self._looks = 0  # that are summed in the last window
        self._connections = Connections(self, self._health)
        self._gaps, self._losses = StampGaps(), Losses()
        self._last_detections = LastDetections()
        self._found = False  # whether a flash mode ever found out about its light
        self._asked: tuple[dict[str, Any], str] | None = None  # of flash, and of the channel
        self._segmenter: FieldSegmenter
        self._quantisation: NDArray[np.uint16] | None = None
        self._response: Response | None = None
        self._new_segmenter: Callable[[], FieldSegmenter]
        self._newest_ns = -1  # of the stamps
        self._topics: dict[str, WindowTopics] = {}  # of all lights that there ever were
        self._targets: dict[str, WindowTopics] = {}
        self._follow = self._in_step = False
        self._track: LatestTrack | None = None
        self._camera = KnownCamera()
        self._noise = NoiseTopic(self, self._health)
        self._debug_image = DebugImage(self)
        fits = deliver is not None
        self.rehearsal = TimedRehearsal(self, fits=fits) if listen else Rehearsal(fits=fits)
        self._due = False  # whether the next frame is likely to show the light
        self._good_frame_ns = self._seen_ns = time.monotonic_ns()
        self._frames = FramePairs(
            self, 'camera', self._health, self._take, remedy=', or set camera_info_url',
            transport=values['image_transport'],
        ) if listen else None
        self._change(values)()
        on_change(self, PARAMETERS, self._change)
        self._clock_jumps = on_clock_jump(self, self._health, self._forget)
        self.create_timer(
            CHECK_S, self._check_silence, clock=Clock(clock_type=ClockType.STEADY_TIME)
        )

    def _change(self, values: dict[str, Any]) -> Callable[[], None]:
        """Build what these parameters ask for; return what puts it into effect."""
        asked = flash_values(values)
        new_flash, lights = flash_of(values)
        new_segmenter = segmenter_of(values)
        response = response_of(values['response_url'])
        # In one process with a camera that is the camera's, which reads it.
        stand_in = camera_of(values['camera_info_url'], warn=self.get_logger().warning) if (
            self._frames
        ) else None
        same_flash, same_channel = (
            self._asked is not None and self._asked[k] == each
            for k, each in enumerate((asked, values['channel']))
        )

        def new_one(before: Segmenter | None = None) -> Segmenter:
            return new_segmenter(
                flash=before.flash if before and same_flash else new_flash(),
                channel=(
                    before.channel if before and same_channel
                    else ChannelChoice(values['channel'])
                ),
            )

        segmenter = FieldSegmenter(new_one, {
            kind: new_one(each)
            for kind, each in (self._segmenter.of_kind if self._asked else {}).items()
        })
        quality = values['jpeg_quality']
        quantisation = standard_quantisation(quality) if quality else None
        for name in lights:
            if name not in self._topics:
                self._topics[name] = WindowTopics(self, target_topic(name))
        follow = values['follow_prediction']
        if follow:
            compile_lens()  # or the first prediction would compile it while frames wait
        if follow and self._predict is None and self._track is None:
            # Of the light without a name: the others are those of modes that do not use it.
            self._track = LatestTrack(self, f'{target_topic("")}/track', self._health)

        def use() -> None:
            with self._lock:
                self._asked = asked, values['channel']
                self._quantisation = quantisation
                self._segmenter = segmenter
                self._new_segmenter = lambda: FieldSegmenter(new_one)
                self._late_ns = int(1e9 * (values['max_pair_interval'] or LEAST_INTERVAL_S))
                self._saturation, self._response = values['saturation'], response
                self._line_time_ns = 1e9 * values['line_time']
                self._follow = follow
                # The other modes have search of their own.
                self._in_step = values['flash.mode'] == 'alternate'
                self._rehearses = values['rehearse'] and self._in_step
                if self._frames is not None:
                    self._frames.stand_in = stand_in
                    self._frames.set_transport(values['image_transport'])
                self._set_lights(lights, _lost_after_ns(values))
                self._noise.enable(values['noise.measure'])

        return use

    def _set_lights(self, lights: Collection[str], lost_after_ns: int) -> None:
        """Speak of these lights and of no other, whose topics stay: see `process.run`."""
        for name, target in self._targets.items():
            if name not in lights:
                target.out_of_view()
        self._targets = {name: self._topics[name] for name in lights}
        for target in self._targets.values():
            target.lost_after_ns = lost_after_ns
        if self._announce is not None:
            self._announce(lights)

    def _forget(self, after_ns: int) -> None:
        """Forget the frames that have a later stamp, ns."""
        if self._frames is not None:
            self._frames.forget(after_ns)
        with self._lock:
            if self._newest_ns > after_ns:
                self._restart()

    def _restart(self) -> None:
        """Forget all frames, as after a start: what follows is of another time."""
        self._segmenter = self._new_segmenter()
        self._newest_ns = -1
        self._last_detections.reset()
        for target in self._targets.values():
            target.forget()

    def _take(self, image: Image | CompressedImage, info: CameraInfo) -> None:
        """Take a frame from the topics."""
        try:
            if isinstance(image, CompressedImage):
                frame = of_compressed(image, info)
            else:
                frame = of_image(image, info)
        except MessageError as error:
            self._health.count('images refused')
            self._health.fault(ERROR, f'camera/image_raw: {error}')
            return
        self.segment(Delivery((frame, info), image.header.frame_id))

    def segment(self, delivery: Delivery[tuple[Frame, CameraInfo]]) -> None:
        """Look for the lights in the next frame; publish the window of each that is there."""
        came_ns = time.monotonic_ns()
        frame, info = delivery.item
        self._due = False
        with self._lock:
            clipped = clipping_frame(frame, self._saturation)
            limit = clipped.saturation
            if self._response is not None:
                limit = min(limit, self._response.saturation)
            if frame.saturation < limit:
                self._health.fault(
                    WARN,
                    f'the camera clips at {frame.saturation} DN; set saturation to that in '
                    'segmenter and locator',
                )
            if self._line_time_ns:
                clipped = replace(clipped, line_time_ns=self._line_time_ns)
            if clipped.quantisation is None and self._quantisation is not None:
                clipped = replace(clipped, quantisation=self._quantisation)
            self._segment(clipped, info, delivery.frame_id)
        self._health.arrived(frame.stamp_ns, came_ns)
        self._losses.add(self._gaps.missing(frame.stamp_ns))
        wanted = self._due and self._rehearses
        self.rehearsal.expect(came_ns, frame.image.dtype.char, wanted)

    def _linear(self, frame: Frame, info: CameraInfo) -> Frame:
        """Return a frame in linear DN where the camera's response is known."""
        if self._response is None:
            return frame
        try:
            self._response.check_size(int(info.width), int(info.height))
            return self._response.linear_frame(frame)
        except CalibrationError as error:
            self._health.fault(WARN, f'response_url: {error}; its pixels are taken for linear')
            return frame

    def _segment(self, raw: Frame, info: CameraInfo, frame_id: str) -> None:
        frame = self._linear(raw, info)
        late_ns = self._newest_ns - frame.stamp_ns
        if late_ns > self._late_ns:
            self._health.fault(
                WARN,
                f'camera/image_raw: the stamps jumped back by {late_ns / 1e9:.3f} s; starting '
                'again',
            )
            self._restart()
        self._newest_ns = max(self._newest_ns, frame.stamp_ns)
        try:
            found = dict(self._segmenter.sightings(frame, self._expected(frame, info)))
        except FrameError as error:
            self._health.fault(WARN, f'camera/image_raw: {error}')
            return
        self._good_frame_ns = time.monotonic_ns()
        for name, window in found.items():
            if self._deliver is not None:
                self._deliver(Delivery((window, info), frame_id, name))
            self._targets[name].publish(window, frame_id, info)
            self._health.left(window.stamp_ns)
            self._cut.count += 1
            self._looks = window.looks
        # Each of several looks has the target in view; the last one has the window of their sum.
        seen = self._segmenter.in_view
        visible = [
            target.visible(frame.stamp_ns, name in seen)
            for name, target in self._targets.items()
        ]
        self._due = not seen and any(visible)
        self._searched.count += 1
        for warning in self._segmenter.warnings:
            self._health.fault(WARN, warning)
        if frame.layout != 'grey':
            self._health.show('channel', self._segmenter.channel.channel)
        if seen:
            self._seen_ns = self._good_frame_ns
            self._health.ok('target in view')
        elif not any(visible):
            self._say_why(raw)
        detections = self._last_detections.update(self._segmenter, self._good_frame_ns)
        if detections:
            self._debug_image.offer(
                lambda: draw(detections), frame.stamp_ns, frame_id, _pause(detections)
            )
        if self._noise.measures:
            self._noise.measure(self._segmenter.unlit_pair, frame, frame_id)

    def _expected(self, frame: Frame, info: CameraInfo) -> Expectation | None:
        """Return where the tracker expects the light in a frame; None if it is not asked."""
        if not self._follow:
            return None
        if self._seen_at(frame.stamp_ns) is None:
            return None
        try:
            camera_model = self._camera.model(info)
        except MessageError as error:
            self._health.fault(WARN, f'follow_prediction: {error}')
            return None
        self._health.count('frames with a prediction')
        return expectation_in(frame, self._seen_at, camera_model)

    def _seen_at(self, stamp_ns: int) -> Track | None:
        """Return the light as the camera sees it at a stamp, as far as the tracker tells."""
        if self._predict is not None:
            return self._predict('', stamp_ns)
        return None if self._track is None else self._track.seen_at(stamp_ns)

    def _say_why(self, frame: Frame) -> None:
        """Say why there is no target."""
        fault = exposure_fault(frame)
        if fault:
            self._health.fault(WARN, f'no target: {fault}')
        else:
            reason = f'no target: {self._segmenter.reason}'
            self._health.ok(reason)
            # One that is out of view is no fault, but whoever waits for it looks into the log.
            if self._good_frame_ns - self._seen_ns > 1e9 * UNSEEN_S:
                hint = '; one that blinks by its own clock needs another flash.mode, such as auto'
                self.get_logger().info(
                    reason + hint * self._in_step, throttle_duration_sec=LOG_AGAIN_S)

    def _describe(self) -> None:
        """Show in the diagnostics what the segmenter saw last."""
        if self._looks:
            self._health.show('frames summed in a window', self._looks)
        self._health.show('missing frames', self._losses.total)
        if self._segmenter.repeated_frames:
            self._health.show('repeated frames', self._segmenter.repeated_frames)
        if self._losses.grave:
            self._health.fault(
                WARN,
                f'{100.0 * self._losses.share:.0f} % of the last frames are missing by their '
                'stamps: the camera dropped them (see its diagnostics), they were lost on the way '
                '(use config/fastdds.xml), or this node was too late for them (see CPU)',
            )
        if self._segmenter.finding or self._found:
            self._found = True  # what was shown once is not left standing
            self._health.show('light found', self._segmenter.finding or 'none')
        self._last_detections.describe(self._health)

    def _check_silence(self) -> None:
        """Say that the targets are out of view when no good frame has come for a while."""
        if time.monotonic_ns() - self._good_frame_ns > 1e9 * SILENCE_S:
            with self._lock:
                for target in self._targets.values():
                    target.out_of_view()


def _lost_after_ns(values: dict[str, Any]) -> int:
    """Return the time without a light after which it is no longer visible, ns."""
    lost_after = values['lost_after']
    if values['flash.mode'] == 'lock_in':
        # So long a block of the slowest camera that shows the light lasts, and a tenth more.
        block = HIGHEST_FREQUENCY * values['flash.frames'] / values['flash.frequency']
        lost_after = max(lost_after, 1.1 * block)
    return int(1e9 * lost_after)


def _pause(detections: Detections) -> float:
    """Return the least time between two pictures, s, by what there is to see in this one."""
    if detections.windows:
        return WITH_WINDOW_S
    return WITH_CANDIDATE_S if detections.candidates else WITH_NOTHING_S


def compile_search() -> None:
    """Compile the search, before the first frame could wait for it."""
    compile_ahead()


def main() -> None:
    """Run the node."""
    sys.exit(run(lambda: [SegmenterNode()], compile_search))
